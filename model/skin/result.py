"""What is known of the contacts of a skin: where they are, and the forces in their windows."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from tfra.model import tfra
from tfra.model.arrays import Floats, Ints
from tfra.model.skin.finding import MARK_SHIFT, Found
from tfra.model.skin.skin import Skin
from tfra.model.skin.smoothing import Number
from tfra.model.skin.tracking import tracks
from tfra.model.skin.windows import PLACE_FRACTION
from tfra.model.tfra import Result


@dataclass(frozen=True, eq=False)
class SkinResult:
    """k contacts in n frames.

    Of shape ``(k,)``: the ``frame``, the number of the ``contact`` in it, ``x`` and ``y`` of the region's centroid in m
    from the first taxel, ``taxels`` of the region, ``top`` and ``left``, the first row and column of the window.
    ``windows`` has a frame for each contact; its status has the bits of ``Mark``, too.  ``found`` and ``dropped (n,)``:
    contacts of each frame, and peaks beyond as many as there may be.  ``pitch``: the smaller one, in m.
    """

    frame: Ints
    contact: Ints
    x: Floats
    y: Floats
    taxels: Ints
    top: Ints
    left: Ints
    windows: Result
    found: Ints
    dropped: Ints
    pitch: float

    def tracks(self, distance: float | None = None) -> Ints:
        """Numbers ``(k,)`` that contacts keep over frames.

        They do while they move less than ``distance`` m from frame to frame, by default two pitches.
        """
        places = np.stack([self.x, self.y], axis=1)
        return tracks(self.found, places, 2 * self.pitch if distance is None else distance)

    @property
    def frame_status(self) -> Ints:
        """Status of each frame's first contact, that of the highest peak, ``(n,)``."""
        status = np.full(len(self.found), tfra.Status.NO_CONTACT, dtype=np.int64)
        first = self.contact == 0
        status[self.frame[first]] = self.windows.status[first] % (1 << MARK_SHIFT)
        return status


def skin_result(skin: Skin, found: Found, windows: Result) -> SkinResult:
    """The contacts that were ``found``, and the ``windows`` of each as an estimator sees them."""
    step = 2.0**-PLACE_FRACTION
    return SkinResult(
        frame=found.frame,
        contact=found.contact,
        x=np.multiply(found.column, step * skin.sensor.pitch_x, dtype=np.float64),
        y=np.multiply(found.row, step * skin.sensor.pitch_y, dtype=np.float64),
        taxels=found.taxels,
        top=found.top,
        left=found.left,
        windows=replace(windows, status=windows.status | found.marks),
        found=found.found,
        dropped=found.dropped,
        pitch=min(skin.sensor.pitch_x, skin.sensor.pitch_y),
    )


def joined(results: Sequence[SkinResult]) -> SkinResult:
    """One result of the frames of all ``results`` of a skin."""
    before = np.cumsum([0, *(len(each.found) for each in results)])
    every = [replace(each, frame=each.frame + first) for each, first in zip(results, before, strict=False)]
    names = [each.name for each in fields(SkinResult) if isinstance(getattr(every[0], each.name), np.ndarray)]
    arrays: dict[str, Any] = {name: np.concatenate([getattr(each, name) for each in every]) for name in names}
    return replace(every[0], windows=tfra.joined([each.windows for each in every]), **arrays)


def estimate(skin: Skin, frames: npt.NDArray[Number], estimator: Callable[[npt.NDArray[Number]], Result]) -> SkinResult:
    """Contacts of ``frames (n, rows, columns)``, their forces by the ``estimator`` of the windows."""
    found, cut = skin.find(frames)
    return skin_result(skin, found, estimator(cut))
