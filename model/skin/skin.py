"""A skin: a large array, and the estimator of a window that is laid about every contact."""

from dataclasses import dataclass, field

import numpy.typing as npt

from tfra.model.arrays import Bools
from tfra.model.choices import Adc
from tfra.model.fixed.design import Design
from tfra.model.sensor import SensorArray
from tfra.model.skin.finding import Finding, Found, finding, taken
from tfra.model.skin.smoothing import Number
from tfra.model.skin.windows import windows


@dataclass(frozen=True)
class Skin:
    """The whole array ``sensor``, the design of a ``window``, and how contacts are told apart.

    Raises ``ValueError`` that starts with ``window.rows:`` or ``window.columns:`` for a window larger than the array.
    """

    sensor: SensorArray
    window: Design
    choices: Finding = field(default_factory=Finding)

    def __post_init__(self) -> None:
        for name, size, most in zip(
            ("rows", "columns"), self.shape, (self.sensor.rows, self.sensor.columns), strict=True
        ):
            if size > most:
                raise ValueError(f"window.{name}: at most the array's {most} are supported, got {size}")

    @property
    def name(self) -> str:
        """Name of the core."""
        return self.window.name

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of a window."""
        return self.window.sensor.rows, self.window.sensor.columns

    @property
    def adc(self) -> Adc:
        """The converter, the same for all taxels."""
        return self.window.adc

    def find(self, frames: npt.NDArray[Number]) -> tuple[Found, npt.NDArray[Number]]:
        """The contacts in ``frames (n, rows, columns)``, and their windows ``(k, *shape)``.

        Frames are codes of the converter, or stress in Pa as floating-point numbers.
        """
        found = finding(self.choices, self.shape, self._floor(frames), frames)
        return found, windows(frames, found.frame, (found.top, found.left), self.shape)

    def taken(self, frames: npt.NDArray[Number]) -> Bools:
        """Which taxels ``(n, rows, columns)`` belong to a contact that is found: its region, and the gap about it."""
        return taken(self.choices, self._floor(frames), frames)

    def _floor(self, frames: npt.NDArray[Number]) -> float:
        """The lowest peak, in units of the ``frames``."""
        return float(self.adc.threshold) * (1.0 if frames.dtype.kind == "i" else self.adc.lsb)


def core_of(array: Design | Skin) -> Design:
    """The design of the only core, or of that of a window."""
    return array.window if isinstance(array, Skin) else array
