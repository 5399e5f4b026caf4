"""Frames that put a core to the test: simulated contacts, random codes, and the corners of the input space."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tfra.model.contact import Contact, ContactShape
from tfra.model.design import Design
from tfra.model.fixed.numbers import Ints
from tfra.model.fixed.words import quantise
from tfra.model.layer import frames as layer_frames
from tfra.model.sensor import Floats, SensorArray

CONTACTS = 60
"""Simulated contacts when no frames are given."""

REFERENCES = ("resultant_ref", "mu_ref", "phi_ref_deg")
"""Keys of a frames file that say what the contacts truly are: N, 1, degrees."""


@dataclass(frozen=True)
class Stimuli:
    """Converter codes ``(n, rows, columns)`` with the kind of each frame; true values are NaN where unknown."""

    codes: Ints
    kinds: npt.NDArray[np.str_]
    resultant: Floats
    """``(n, 3)`` N."""
    mu: Floats
    phi_deg: Floats

    @classmethod
    def of(cls, codes: Ints, kind: str, references: Mapping[str, npt.ArrayLike] | None = None) -> Stimuli:
        """Frames of one kind, with the references of a frames file if there are any."""
        n, truth = len(codes), []
        for key, shape in zip(REFERENCES, ((n, 3), (n,), (n,)), strict=True):
            value = np.array((references or {}).get(key, np.full(shape, np.nan)), dtype=np.float64)
            if value.shape != shape:
                raise ValueError(f"{key}: shape {shape} is needed, got {value.shape}")
            truth.append(value)
        return cls(codes, np.full(n, kind), *truth)

    def __add__(self, other: Stimuli) -> Stimuli:
        pairs = ((getattr(self, name), getattr(other, name)) for name in self.__dataclass_fields__)
        return Stimuli(*(np.concatenate(pair) for pair in pairs))

    def __getitem__(self, part: slice) -> Stimuli:
        return Stimuli(*(getattr(self, name)[part] for name in self.__dataclass_fields__))


def mixture(design: Design, seed: int, random: int) -> Stimuli:
    """Return simulated contacts, ``random`` random frames and every directed one."""
    rng = np.random.default_rng(seed)
    known = contacts(design, rng, CONTACTS)
    noise = Stimuli.of(random_codes(design, rng, random), "random")
    return known + noise + Stimuli.of(directed(design, rng), "directed")


def contacts(design: Design, rng: np.random.Generator, count: int) -> Stimuli:
    """Return ``count`` contacts of random shape, place, size and direction, at 5 to 95 % of full scale."""
    loads = [_contact(design.sensor, rng) for _ in range(count)]
    stresses = layer_frames(design.sensor, loads)
    peak = np.abs(stresses).max(axis=(1, 2))
    scale = rng.uniform(0.05, 0.95, count) * design.adc.full_scale / peak
    truth = {
        "resultant_ref": np.array([load.force for load in loads]) * scale[:, None],
        "mu_ref": np.array([load.mu for load in loads]),
        "phi_ref_deg": np.degrees([load.phi for load in loads]),
    }
    return Stimuli.of(quantise(design, stresses * scale[:, None, None]), "contact", truth)


def _contact(sensor: SensorArray, rng: np.random.Generator) -> Contact:
    half_x = rng.uniform(0.1, 0.35) * sensor.size_x
    half_y = rng.uniform(0.1, 0.35) * sensor.size_y
    return Contact(
        shape=list(ContactShape)[rng.integers(len(ContactShape))],
        center_x=rng.uniform(half_x, sensor.size_x - half_x) - sensor.pitch_x / 2,
        center_y=rng.uniform(half_y, sensor.size_y - half_y) - sensor.pitch_y / 2,
        half_x=half_x,
        half_y=half_y,
        normal_force=-1.0,
        mu=rng.uniform(0.0, 0.9),
        phi=rng.uniform(0.0, 2 * math.pi),
    )


def random_codes(design: Design, rng: np.random.Generator, count: int) -> Ints:
    """Return noise of every amplitude; a third of the frames is sparse."""
    half, shape = 1 << (design.adc.bits - 1), (count, design.sensor.rows, design.sensor.columns)
    codes = rng.integers(-half, half, shape) >> rng.integers(0, design.adc.bits, (count, 1, 1))
    keep = rng.random(shape) < np.where(rng.random(count) < 1 / 3, 0.2, 1.0)[:, None, None]
    return np.where(keep, codes, 0).astype(np.int64)


def directed(design: Design, rng: np.random.Generator) -> Ints:
    """Return the corners: nothing, one sign only, extremes, single taxels, symmetric and tiny frames."""
    rows, columns = design.sensor.rows, design.sensor.columns
    low, high = -(1 << (design.adc.bits - 1)), (1 << (design.adc.bits - 1)) - 1
    i, j = np.indices((rows, columns))
    zero = np.zeros((rows, columns), dtype=np.int64)
    even = (i + j) % 2 == 0
    edge = (i == 0) | (j == 0) | (i == rows - 1) | (j == columns - 1)

    def single(value: int, row: int, column: int, rest: int = 0) -> Ints:
        frame = zero + rest
        frame[row, column] = value
        return frame

    frames = [
        zero,
        zero + low,  # compression only, at full scale
        zero - 1,
        -rng.integers(0, high, zero.shape),
        zero + high,  # no contact at all
        rng.integers(0, high, zero.shape),
        single(low, 0, 0),
        single(high, rows - 1, columns - 1),
        single(-1, rows // 2, columns // 2),
        single(low, rows // 2, columns // 2, 1),
        single(low, 0, columns - 1, high),
        np.where(even, low, high),
        np.where(even, high, low),
        np.where(i % 2 == 0, low, high),
        np.where(j < columns // 2, low, high),
        np.where(i < rows // 2, high, low),
        np.where(edge, high // 4, low // 2),  # mirror-symmetric: no direction
        np.where(edge, -1, 1),
        (j - columns // 2) * (high // columns),
        rng.integers(-1, 2, zero.shape),
        rng.integers(-1, 2, zero.shape),
        rng.integers(-4, 5, zero.shape),
    ]
    return np.array(frames, dtype=np.int64)
