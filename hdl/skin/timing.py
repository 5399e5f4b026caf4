"""Cycles of a frame of a skin, without building it: bounds from what its blocks state of themselves."""

import math
from dataclasses import dataclass

from tfra.hdl.cores import microarchitecture
from tfra.hdl.interface.microarchitecture import Microarchitecture
from tfra.hdl.skin.peaks import Peaks
from tfra.hdl.skin.smoothing import Smoothing
from tfra.hdl.skin.windows import Windows
from tfra.model.skin.skin import Skin

_USUAL = 1 / 3
"""Taxels of a usual region, of those of a window."""

_FRAME, _CONTACT, _TAXEL = 15, 30, 9
"""Cycles of ``Finding`` for each frame, without those of rows, for each contact, and for each taxel of its region."""


@dataclass(frozen=True)
class SkinTiming:
    """A frame with as many contacts as there may be, each with a round region of ``taxels``, in front of ``core``."""

    skin: Skin
    core: Microarchitecture
    taxels: int

    @classmethod
    def of(cls, skin: Skin, core: Microarchitecture | None = None) -> "SkinTiming":
        """With regions of a third of the window's taxels."""
        rows, columns = skin.shape
        return cls(skin, core or microarchitecture(skin.window), math.ceil(_USUAL * rows * columns))

    @property
    def peaks(self) -> int:
        """Cycles from a frame's last taxel until its peaks are known, in an idle unit."""
        return 1 + Smoothing(self.skin).latency + Peaks(self.skin).latency

    @property
    def finding(self) -> int:
        """Most cycles from there until the last region is known: one for each candidate, which are the contacts."""
        return self.skin.sensor.rows + _FRAME + self.skin.choices.most * self._contact

    @property
    def _contact(self) -> int:
        choices, rows = self.skin.choices, math.ceil(2 * math.sqrt(self.taxels / math.pi))
        return _CONTACT + choices.most + _TAXEL * self.taxels + (5 + 3 * choices.gap) * rows

    @property
    def forces(self) -> int:
        """Cycles in which the core takes the windows."""
        rows, columns = self.skin.shape
        return self.skin.choices.most * max(self.core.initiation_interval, rows * columns + Windows.latency)

    @property
    def interval(self) -> int:
        """Most cycles from frame to frame: taking, finding and forces go on side by side."""
        return max(self.skin.sensor.taxels, self.finding, self.forces)

    @property
    def latency(self) -> int:
        """Most cycles from a frame's last taxel to its first word, in an idle unit: a second contact is found then."""
        first = self.skin.sensor.rows + _FRAME + self._contact
        return self.peaks + first + _CONTACT + self.skin.choices.most

    @property
    def frame_latency(self) -> int:
        """Most cycles from a frame's last taxel to its last word, in an idle unit."""
        return self.peaks + self.finding + self.forces + self.core.frame_latency
