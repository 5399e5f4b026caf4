"""The tactile array: a grid of normal-stress taxels under an elastic cover."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field, fields

import numpy as np

from tfra.model.arrays import Floats


def require_finite(
    owner: object,
    *names: str,
    needed: str = "a positive, finite length",
    good: Callable[[float], bool] = lambda value: value > 0,
) -> None:
    """Raise ``ValueError`` that starts with the name of a field of ``owner`` that is not finite and ``good``."""
    for name in names:
        value = getattr(owner, name)
        if not (math.isfinite(value) and good(value)):
            raise ValueError(f"{name}: {needed} is needed, got {value}")


@dataclass(frozen=True, slots=True)
class SensorArray:
    """Geometry of an array of ``rows x columns`` taxels; lengths in metres.

    Taxel (i, j) sits at x = j * pitch_x, y = i * pitch_y; frames have shape ``(n, rows, columns)`` and
    vectors are row-major with ``taxels = rows * columns`` entries.  The cover block reaches half a pitch
    beyond the outer taxels and is ``thickness`` high.

    Raises ``ValueError`` naming the field for fewer than two rows or columns (a line of taxels can't
    tell the direction of a tangential force) and for lengths that are not positive and finite.
    """

    rows: int = field(metadata={"meaning": "taxels along y", "unit": ""})
    columns: int = field(metadata={"meaning": "taxels along x", "unit": ""})
    pitch_x: float = field(metadata={"meaning": "distance of taxels along x", "unit": "m"})
    pitch_y: float = field(metadata={"meaning": "distance of taxels along y", "unit": "m"})
    thickness: float = field(metadata={"meaning": "thickness of the elastic cover", "unit": "m"})

    def __post_init__(self) -> None:
        for name in ("rows", "columns"):
            if getattr(self, name) < 2:
                raise ValueError(f"{name}: at least 2 taxels are needed, got {getattr(self, name)}")
        require_finite(self, "pitch_x", "pitch_y", "thickness")

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


@dataclass(frozen=True, slots=True)
class SensorKey:
    """A field of :class:`SensorArray` as a key of files: a count, or a number in SI units; lengths are mm in CONFIG."""

    field: str
    meaning: str
    unit: str

    @property
    def is_length(self) -> bool:
        """Whether it is a length."""
        return self.unit == "m"

    @property
    def config(self) -> str:
        """The key in CONFIG's ``[sensor]``."""
        return f"{self.field}_mm" if self.is_length else self.si

    @property
    def si(self) -> str:
        """The key in the sidecar."""
        return f"{self.field}_{self.unit.lower()}" if self.unit else self.field


def sensor_keys() -> tuple[SensorKey, ...]:
    """All keys in the order of the fields: a new field of :class:`SensorArray` is in all files at once."""
    return tuple(SensorKey(f.name, **f.metadata) for f in fields(SensorArray))
