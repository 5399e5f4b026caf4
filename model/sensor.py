"""The tactile array: a grid of normal-stress taxels under an elastic cover."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from tfra.model.arrays import Floats


@dataclass(frozen=True, slots=True)
class SensorArray:
    """Geometry of an array of ``rows x columns`` taxels; lengths in metres.

    Taxel (i, j) sits at x = j * pitch_x, y = i * pitch_y; frames have shape ``(n, rows, columns)`` and
    vectors are row-major with ``taxels = rows * columns`` entries.  The cover block reaches half a pitch
    beyond the outer taxels and is ``thickness`` high.

    Raises ``ValueError`` naming the field for fewer than two rows or columns (a line of taxels can't
    tell the direction of a tangential force) and for lengths that are not positive and finite.
    """

    rows: int
    columns: int
    pitch_x: float
    pitch_y: float
    thickness: float

    def __post_init__(self) -> None:
        for name in ("rows", "columns"):
            if getattr(self, name) < 2:
                raise ValueError(f"{name}: at least 2 taxels are needed, got {getattr(self, name)}")
        for name in ("pitch_x", "pitch_y", "thickness"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0):
                raise ValueError(f"{name}: a positive, finite length is needed, got {value}")

    @property
    def taxels(self) -> int:
        """Number of taxels m."""
        return self.rows * self.columns

    @property
    def taxel_area(self) -> float:
        """s_x * s_y in square metres."""
        return self.pitch_x * self.pitch_y

    @property
    def size_x(self) -> float:
        """Extent of the cover block along x, in metres."""
        return self.columns * self.pitch_x

    @property
    def size_y(self) -> float:
        """Extent of the cover block along y, in metres."""
        return self.rows * self.pitch_y

    def positions(self) -> tuple[Floats, Floats]:
        """Row-major x and y of every taxel, each of shape ``(taxels,)``, in metres."""
        i, j = np.divmod(np.arange(self.taxels), self.columns)
        return j * self.pitch_x, i * self.pitch_y
