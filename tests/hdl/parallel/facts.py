"""Per-frame facts for the blocks around the affine coefficients: from model stages and at random."""

import random
from dataclasses import fields
from typing import Any

import numpy as np

from tests.hdl.parallel.designs import make
from tfra.model.arrays import Ints
from tfra.model.choices import Formats
from tfra.model.fixed.butterfly import butterfly, to_quads
from tfra.model.fixed.design import Design
from tfra.model.fixed.matvec import matvec
from tfra.model.fixed.normaliser import Normalised, normaliser
from tfra.model.fixed.tfra.centroids import Direction, centroids
from tfra.model.fixed.tfra.dependent import Dependent, dependent, gather_sums
from tfra.model.fixed.tfra.weights import weights

DESIGNS = {
    "standard": make(4, 4, threshold=0),
    "wide": make(5, 7, "wide", steps=7, threshold=0),
    "short": make(2, 3, Formats("short", 10, 10, 16, 3), bits=8, steps=1, threshold=0),
    "operand over vector": make(4, 6, Formats("long", 18, 27, 0, 0), bits=6, steps=33, threshold=0),
    "ten": make(10, 10, bits=12, threshold=0),
}


def transfers(facts: Any) -> list[Any]:
    """Facts of the model (a dataclass of arrays, frame first) as payloads of the gateware."""
    columns = {f.name: getattr(facts, f.name) for f in fields(facts) if f.name != "stress"}
    frames = len(next(iter(columns.values())))
    return [
        {name: np.ravel(c[k]).tolist() if c.ndim > 1 else int(c[k]) for name, c in columns.items()}
        for k in range(frames)
    ]


def words(rng: random.Random, bits: int, shape: tuple[int, ...]) -> Ints:
    """Signed words of ``bits`` and less: every length is as likely, ends of the range among them."""
    lengths = [rng.randrange(bits) for _ in range(int(np.prod(shape)))]
    values = [rng.choice([rng.randrange(-1 << n, 1 << n), -1 << n, (1 << n) - 1]) for n in lengths]
    return np.array(values, dtype=np.int64).reshape(shape)


def bits_of(rng: random.Random, frames: int) -> Any:
    """One random flag for each frame."""
    return np.array([rng.random() < 0.5 for _ in range(frames)])


def random_frames(design: Design, rng: random.Random, frames: int) -> Normalised:
    """Any facts; half the frames are regular."""
    number = np.array([rng.randrange(8) for _ in range(frames)])
    contact, traction = (number > 0), (number != 1) & (number < 5)
    zero = np.zeros(frames, dtype=np.int64)
    return Normalised(np.zeros((frames, 1), dtype=np.int64), zero, zero, contact, traction, bits_of(rng, frames))


def random_direction(design: Design, rng: random.Random, frames: int) -> Direction:
    """Any words, any flags."""
    cos, sin = words(rng, design.formats.operand, (2, frames))
    return Direction(cos, sin, *(bits_of(rng, frames) for _ in range(3)))


def random_affine(design: Design, rng: random.Random, frames: int) -> Dependent:
    """Any words, as no frame would have them together."""
    operand, vector = design.formats.operand, design.widths.vector
    alpha, beta = words(rng, operand, (2, frames))
    significant = np.array([rng.randrange(vector) for _ in range(frames)])
    return Dependent(alpha, beta, bits_of(rng, frames), words(rng, operand, (frames, 3, 3)), significant)


def real_sums(design: Design, codes: Ints) -> tuple[Normalised, Direction, Ints, Ints]:
    """Facts and sum quads of ``codes (n, m)`` as the model's blocks give them."""
    q = design.quads
    frame, direction = normaliser(design, codes), centroids(design, codes)
    b = butterfly(to_quads(design, frame.stress)) << design.formats.vector_fraction
    contact = matvec(design, "contact", b)
    residual = matvec(design, "residual", weights(contact[:, :q], frame.regular))
    return frame, direction, contact[:, q:], residual[:, :3]


def real_affine(design: Design, codes: Ints) -> tuple[Normalised, Direction, Dependent]:
    """Facts of ``codes (n, m)`` up to the affine coefficients."""
    frame, direction, sums_b, sums_n = real_sums(design, codes)
    return frame, direction, dependent(design, gather_sums(sums_b, sums_n), direction, frame.regular)


def random_codes(design: Design, seed: int, frames: int) -> Ints:
    """Contacts with noise; the first two frames have nothing to sweep."""
    rng = np.random.default_rng(seed)
    top = 1 << (design.adc.bits - 1)
    y, x = np.mgrid[0 : design.sensor.rows, 0 : design.sensor.columns]
    found = []
    for _ in range(frames):
        cx, cy = rng.uniform(0, design.sensor.columns - 1), rng.uniform(0, design.sensor.rows - 1)
        angle, size = rng.uniform(0, 2 * np.pi), rng.uniform(1, 3)
        r2 = ((x - cx) ** 2 + (y - cy) ** 2) / size**2
        slope = ((x - cx) * np.cos(angle) + (y - cy) * np.sin(angle)) / size
        found.append((rng.uniform(0.02, 0.9) * (slope - 1) * np.exp(-r2)).ravel() + rng.normal(0, 0.01, x.size))
    codes = np.clip(np.rint(np.array(found) * top), -top, top - 1).astype(np.int64)
    codes[0], codes[1] = 0, -np.abs(codes[1])
    return codes
