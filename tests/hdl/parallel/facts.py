"""Per-frame facts for the blocks around the affine coefficients: from model stages and at random."""

from dataclasses import fields
from typing import Any

import numpy as np

from tests.hdl.parallel.designs import make, random_words
from tfra.model.arrays import Ints
from tfra.model.choices import Formats
from tfra.model.cover.scenes import contact_codes
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


def frame_facts(contact: Any, traction: Any, magnitude: Any = 0) -> Normalised:
    """Facts of frames with these flags ``(n,)``, and nothing else."""
    zero = np.zeros(len(contact), dtype=np.int64)
    return Normalised(zero[:, None], zero, zero + magnitude, contact, traction, zero > 0)


def regular_frames(number: int) -> Normalised:
    """Facts of frames with contact and traction."""
    return frame_facts(*np.ones((2, number), dtype=bool))


def random_frames(rng: np.random.Generator, frames: int) -> Normalised:
    """Any flags; about half the frames are regular."""
    return frame_facts(rng.random(frames) < 0.85, rng.random(frames) < 0.6)


def random_direction(design: Design, rng: np.random.Generator, frames: int) -> Direction:
    """Any words, any flags."""
    return Direction(*random_words(rng, design.formats.operand, (2, frames)), *(rng.random((3, frames)) < 0.5))


def random_affine(design: Design, rng: np.random.Generator, frames: int) -> Dependent:
    """Any words, as no frame would have them together."""
    alpha, beta = random_words(rng, design.formats.operand, (2, frames))
    sums = random_words(rng, design.formats.operand, (frames, 3, 3))
    return Dependent(alpha, beta, rng.random(frames) < 0.5, sums, rng.integers(0, design.widths.vector, frames))


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
    """Contacts; the first two frames have nothing to sweep."""
    codes = contact_codes(design, frames, seed).reshape(frames, -1)
    codes[0], codes[1] = 0, -np.abs(codes[1])
    return codes
