"""A block of frames: the unit of drawing, storage and work, by one process."""

from dataclasses import dataclass
from enum import IntEnum, StrEnum
from functools import cached_property
from io import BytesIO

import numpy as np
import numpy.typing as npt
import polars as pl

from tfra.model.arrays import Floats, Singles

BLOCK = 1024
"""Frames of a block, unless a definition has another size; the last one of a part may have fewer."""

_ARRAYS = {"stress": "stress_pa", "noisy": "noisy_stress_pa", "shares": "share_of_force"}
"""Columns of the arrays, each row a frame's taxels, row by row."""


class Part(StrEnum):
    """Training frames, for choices, and held-out frames, which no choice uses."""

    TRAIN = "train"
    HELD_OUT = "held_out"


class Stream(IntEnum):
    """Random parts of a block, each with its own generator, so that one can be varied alone."""

    CONTACTS = 0
    NOISE = 1


def generator(seed: int, part: Part, number: int, stream: Stream) -> np.random.Generator:
    """The generator of block ``number`` of a part."""
    key = list(Part).index(part), number, stream.value
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=key))


def parquet(table: pl.DataFrame) -> bytes:
    """A table as a Parquet file: the same bytes for the same table."""
    stream = BytesIO()
    table.write_parquet(stream, compression="zstd", statistics=False)
    return stream.getvalue()


def from_parquet(data: bytes) -> pl.DataFrame:
    """The table of a Parquet file."""
    return pl.read_parquet(BytesIO(data))


def with_noise(stress: Singles, spread: npt.ArrayLike, offset: npt.ArrayLike, normal: Floats) -> Singles:
    """``stress (n, rows, columns)`` with noise and a common offset, both shares ``(n,)`` of the frame's peak.

    ``normal`` is the noise at unit deviation.
    """
    peak = np.abs(stress.astype(np.float64)).max(axis=(1, 2), initial=0.0)
    deviation, common = (np.asarray(peak * share)[:, None, None] for share in (spread, offset))
    return np.asarray(stress + deviation * normal + common, dtype=np.float32)


@dataclass(frozen=True)
class Block:
    """Frames of a part from ``start``, with the truth.

    Attributes:
        start: Number of the first frame in its part.
        stress: Output of an ideal array, ``(n, rows, columns)``, Pa.  It is rounded to single precision before any use,
            so that it is the same whether just made or loaded: the rounding is at most 1/32 of a code of the longest
            converter.
        noisy: The same with noise and offset.
        shares: Share of the force on each taxel's cell, ``(n, rows, columns)``, nan where unknown.
        truth: A row each frame: ``force_x_n``, ``force_y_n``, ``force_z_n``, ``mu`` and ``phi_deg``, nan where unknown
            or, without friction, undefined; of simulated frames also what was drawn.  Of a skin, lists of all contacts.
    """

    start: int
    stress: Singles
    noisy: Singles
    shares: Singles
    truth: pl.DataFrame

    def __len__(self) -> int:
        return len(self.stress)

    @cached_property
    def resultant(self) -> Floats:
        """True forces ``(n, 3)``, N."""
        return self.truth.select("force_x_n", "force_y_n", "force_z_n").to_numpy()

    @cached_property
    def forces(self) -> Floats:
        """True forces of the taxels ``(n, 3, rows, columns)``, N."""
        return self.resultant[:, :, None, None] * self.shares[:, None].astype(np.float64)

    @property
    def mu(self) -> Floats:
        """True friction ``(n,)``."""
        return self.truth["mu"].to_numpy()

    @property
    def phi_deg(self) -> Floats:
        """True directions ``(n,)``."""
        return self.truth["phi_deg"].to_numpy()

    def to_parquet(self) -> bytes:
        """Return the block as a Parquet file; equal blocks give equal bytes."""
        arrays = [pl.Series(column, getattr(self, name).reshape(len(self), -1)) for name, column in _ARRAYS.items()]
        return parquet(self.truth.with_columns(*arrays))

    @classmethod
    def from_parquet(cls, data: bytes, start: int, rows: int, columns: int) -> "Block":
        """Return the block in the bytes of a Parquet file."""
        table = from_parquet(data)
        arrays = {name: table[column].to_numpy().reshape(-1, rows, columns) for name, column in _ARRAYS.items()}
        return cls(start, truth=table.drop(*_ARRAYS.values()), **arrays)
