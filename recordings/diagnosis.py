"""One-line warnings about what is probably wrong with a recording and its results.

TFRA gives forces for any numbers, also for those of the wrong sign or unit, or without a tare.  Warnings change no
result; their thresholds lie outside of the values that contacts under a cover show.
"""

from collections.abc import Iterator, Sequence
from functools import cached_property

import numpy as np

from tfra.model.arrays import Floats, Ints
from tfra.model.converter import Measured
from tfra.model.fixed.design import Design
from tfra.model.skin.skin import Skin, core_of
from tfra.model.tfra import Status
from tfra.recordings.facts import MEANINGS, WITHOUT_FORCE, has, positive_share, status_label
from tfra.recordings.input import PASCALS, PLAIN, Input
from tfra.recordings.levels import FRAMES, still

UNITS = {"kPa": 1e3, "MPa": 1e6, "bar": 1e5, "hPa (mbar)": 1e2, "psi": 6894.76}
"""Common units of recorded stress, in Pa."""

WRONG_SIGN = 0.6
"""Share of positive stress above which the sign is doubtful: contacts have at most 0.09, zero-mean noise has 0.5."""

FAINT = 0.02
"""Share of full scale below which the largest magnitude of a recording is doubtful."""

BEYOND = 20.0
"""Multiple of full scale above which the unit is doubtful, not the choice of the converter."""

SATURATED = 0.01
"""Share of frames with a taxel at an end of the range above which a warning is given."""

ALL_OVER, MOSTLY, SOME_FRAMES = 0.05, 0.5, 0.05
"""A frame seems to have an offset if all its taxels have one sign and the smallest magnitude is above the first share
of the largest, or if the median is above the second; contacts show 0.03 and 0.22.  A warning is given above the third
share of such frames."""

TILTED, MOST_FRAMES = 0.01, 0.5
"""A frame with more compression than traction seems to have an offset, too, if its median is positive and above the
first share of the largest magnitude: 0.001 in contacts.  Noise does that by chance, so a warning is given above the
second share of such frames."""

SCRAMBLED = 1.15
"""Largest ratio of a recording's roughness to that of its transposed reading: 0.7 in contacts."""

QUIET, STEADY, EVEN, NOTICEABLE, AT_REST = 0.1, 3.0, (0.2, 0.8), 0.003, 0.2
"""Every taxel has an offset of its own if the mean of the quietest frames, this share of all, is so many times the
deviation from it, has tension in a share that no contact shows (0.09 at most), and is over the first and under the
second share of the largest magnitude."""

NOISY = 1e-3
"""Noise of a taxel over the peak of a frame up to which TFRA's friction is right."""

_OFFSET = "--unit codes --coding offset"


class _Recording:
    """Properties of ``frames (n, rows, columns)`` that the warnings check."""

    def __init__(self, frames: Floats) -> None:
        self.frames = frames
        self.flat = frames.reshape(len(frames), -1)

    @cached_property
    def size(self) -> Floats:
        """Magnitudes ``(n, m)``."""
        return np.asarray(np.abs(self.flat))

    @cached_property
    def peak(self) -> Floats:
        """Largest magnitude of each frame."""
        return np.asarray(self.size.max(axis=1))

    @property
    def largest(self) -> float:
        """Largest magnitude of all."""
        return float(self.peak.max())

    @cached_property
    def whole(self) -> bool:
        """Whether all values are whole numbers, without a common divisor."""
        return bool((self.flat % 1 == 0).all()) and np.gcd.reduce(self.flat.astype(np.int64), axis=None) == 1

    def offset(self, least: float) -> bool:
        """Frames that seem to have a constant offset; frames below ``least`` in magnitude are not judged."""
        judged = self.peak >= least
        flat, size, peak = self.flat[judged], self.size[judged], self.peak[judged]
        if not len(flat):
            return False
        median, low, high = np.median(flat, axis=1), flat.min(axis=1), flat.max(axis=1)
        far = np.abs(median) > MOSTLY * peak
        same = (((low > 0) | (high < 0)) & (size.min(axis=1) > ALL_OVER * peak)) | far
        tilted = (-low > high) & (median > TILTED * peak)
        return bool(same.mean() > SOME_FRAMES or (same | tilted).mean() > MOST_FRAMES)

    def offsets(self) -> float:
        """Mean magnitude of what taxels read while nothing presses, in Pa; 0 where it differs from frame to frame."""
        if len(self.flat) < FRAMES:
            return 0.0
        quiet = self.flat[np.argsort(self.size.sum(axis=1))[: max(3, round(QUIET * len(self.flat)))]]
        mean = quiet.mean(axis=0)
        level, deviation = float(np.abs(mean).mean()), float(np.abs(quiet - mean).mean())
        if level <= STEADY * deviation or not EVEN[0] < np.maximum(mean, 0).sum() / np.abs(mean).sum() < EVEN[1]:
            return 0.0
        pressed = np.abs(mean).max() < AT_REST * self.largest
        return level if pressed and level > NOTICEABLE * self.largest else 0.0


def warnings(
    array: Design | Skin,
    frames: Floats,
    status: Ints,
    given: Input = PLAIN,
    known: Sequence[str] | None = None,
    noise: float | None = None,
) -> list[str]:
    """Return warnings about ``frames (n, rows, columns)`` in Pa and the ``status (n,)`` of each, one line each.

    ``given`` is what made these frames of the recording; the lines name the options of it that may help.  ``known``:
    warnings about the numbers of its file, if it has one; ``noise`` of a taxel at rest in Pa.
    """
    recording = _Recording(frames)
    meaning = list(_values(array, recording, status, given)) or list(_flags(status))
    offsets = []
    if level := recording.offsets():
        offsets = [
            f"taxels read ±{level:.4g} Pa while nothing presses, the same in every frame: was the sensor tared "
            "(--tare-frames N, --tare FILE)?"
        ]
    same = []
    if len(frames) > 1 and (frames == frames[0]).all():
        same = [f"all {len(frames)} frames are the same: is the recording stuck?"]
    layout = [] if offsets else _layout(recording, status, given)  # offsets are rough in every order
    before = known if known is not None else still(frames)
    noisy = [] if noise is None or not core_of(array).sweeps else _noisy(recording, status, noise)
    return [*meaning, *_scale(array, recording, given), *offsets, *same, *before, *layout, *noisy]


def _values(array: Measured, recording: _Recording, status: Ints, given: Input) -> Iterator[str]:
    """Checks offset, then sign, then a sensor at rest: each also looks like the next ones."""
    n = len(status)
    if recording.offset(min(10 * array.adc.lsb, 0.1 * recording.largest)):  # a few codes, whatever the unit
        median = float(np.median(recording.flat))
        codes = f", or are these codes with an offset ({_OFFSET})" if given.unit == "Pa" else ""
        yield (
            f"taxels read about {median:.4g} Pa where nothing seems to press, a common offset: was the sensor tared "
            f"(--tare-frames N, --tare FILE){codes}?"
        )
    elif (positive := positive_share(recording.frames)) > WRONG_SIGN:
        sign = "negative" if given.compression == "positive" else "positive"
        yield (
            f"{100 * positive:.0f} % of the stress is {sign}: is compression {sign} in this file? "
            f"(--compression {sign})"
        )
    elif (silent := int(has(status, Status.NO_CONTACT).sum())) > 0.95 * n:
        yield f"{silent} of {n} frames have no contact: was the sensor at rest?"
    elif (without := _share(status, Status.COMPRESSION_ONLY)) > 0.9:
        yield (
            f"no tension in {100 * without:.0f} % of the frames with a contact, so no tangential force can be found: "
            "does this array measure compression only (as FSRs do), is it clipped at zero, or is friction too small?"
        )


def _scale(array: Measured, recording: _Recording, given: Input) -> Iterator[str]:
    """Checks the magnitude of the values: codes, another unit, or too large for the converter."""
    arguments = array, recording, given
    if line := _codes(*arguments) or _unit(*arguments) or _beyond(*arguments):
        yield line
    top = (1 << (array.adc.bits - 1)) - 1
    scaled = np.rint(recording.flat / array.adc.lsb)
    ends = (scaled >= top) | (scaled <= -top - 1)
    frames, taxels = (int(ends.any(axis=axis).sum()) for axis in (1, 0))
    if frames > SATURATED * len(ends):
        yield (
            f"{frames} of {len(ends)} frames and {taxels} of {ends.shape[1]} taxels reach an end of the converter's "
            f"range, ±{array.adc.full_scale:g} Pa: was it saturated (the forces would be too small)?"
        )


def _share(status: Ints, flag: Status) -> float:
    """Share of the frames with a contact of any kind that have ``flag``."""
    touched = status[~has(status, Status.NO_CONTACT)]
    return float(has(touched, flag).mean()) if len(touched) else 0.0


def _codes(array: Measured, recording: _Recording, given: Input) -> str | None:
    """Whole numbers within the converter's codes, where a code is more than a pascal."""
    lsb, codes = array.adc.lsb, 1 << array.adc.bits
    if given.unit == "codes" or (given.unit == "Pa" and lsb < 1.5):
        return None
    numbers = recording if given.unit == "Pa" else _Recording(recording.frames / PASCALS[given.unit])
    if not 1 < numbers.largest < codes or not numbers.whole:
        return None
    option = _OFFSET if np.median(numbers.flat) > codes / 4 else "--unit codes"
    return (
        f"all values are whole numbers up to {numbers.largest:.0f}: are these codes of the {array.adc.bits}-bit "
        f"converter instead of {given.unit} (1 code = {lsb:.6g} Pa)? ({option})"
    )


def _unit(array: Measured, recording: _Recording, given: Input) -> str | None:
    largest, full = recording.largest, array.adc.full_scale
    if not 0 < largest < FAINT * full:
        return None
    doubt = f"the largest magnitude is {largest:.4g} Pa, {100 * largest / full:.2g} % of full scale, {full:g} Pa"
    read = PASCALS.get(given.unit, np.inf)  # codes of another unit are nothing that fits
    fits = [(name, factor / read) for name, factor in UNITS.items() if FAINT <= largest / full * factor / read <= 2]
    if not fits:
        return f"{doubt}: are the unit, {given.unit}, and adc.full_scale_pa correct, or was nothing pressed?"
    name, factor = fits[0]
    option = f" (--unit {name})" if name in PASCALS else ""
    share = 100 * largest * factor / full
    return f"{doubt}: is the unit {name} (times {factor:g} it would be {share:.0f} %), or was nothing pressed?{option}"


def _beyond(array: Measured, recording: _Recording, given: Input) -> str | None:
    times = recording.largest / array.adc.full_scale
    if times < BEYOND:
        return None
    doubt, unit = f"the largest magnitude is {times:.0f} times full scale", given.unit
    if unit == "codes":
        return f"{doubt}: is adc.full_scale_pa in Pa (not in kPa)?"
    option = " (--unit Pa)" if unit == "kPa" else ""
    return f"{doubt}: is the file in {unit}, and adc.full_scale_pa in Pa (not in kPa)?{option}"


def over_full_scale(array: Measured, frames: Floats, given: Input = PLAIN) -> str:
    """Return a hint at the cause of stress far beyond full scale, which begins with ``"; "``, or nothing."""
    recording = _Recording(frames)
    doubt = _codes(array, recording, given) or _beyond(array, recording, given)
    return f"; {doubt}" if doubt else ""


def _layout(recording: _Recording, status: Ints, given: Input) -> Iterator[str]:
    """Stress is smooth over the array; read along the wrong axis it is not, unless rows equal columns."""
    touched = recording.frames[~has(status, Status.NO_CONTACT)]
    _, rows, columns = recording.frames.shape
    if not len(touched) or rows == columns:
        return
    touched = touched / np.abs(touched).max(axis=(1, 2), keepdims=True)
    frames = touched[:, :: -1 if given.flip_y else 1, :: -1 if given.flip_x else 1]
    way, frames = ("column", frames) if given.order == "rows" else ("row", frames.transpose(0, 2, 1))
    across = frames.reshape(frames.shape[0], frames.shape[2], frames.shape[1])
    here, there = (sum(np.square(np.diff(f, axis=a)).sum(axis=(1, 2)) for a in (1, 2)) for f in (frames, across))
    ratio = float(np.median(here / np.maximum(there, np.finfo(float).tiny)))
    if ratio > SCRAMBLED:
        yield (
            f"neighbours differ {ratio:.1f} times as much as if the file went {way} by {way}: are rows and columns "
            f"swapped in the file (--order {way}s), or in CONFIG's [sensor]?"
        )


def _noisy(recording: _Recording, status: Ints, noise: float) -> Iterator[str]:
    """Noise at which TFRA finds friction that is not there."""
    touched = recording.peak[~has(status, Status.NO_CONTACT) & (recording.peak > QUIET * recording.largest)]
    if len(touched) and (share := noise / float(np.median(touched))) > NOISY:
        yield (
            f"the noise of a taxel is {100 * share:.1g} % of the peaks: TFRA needs well below {100 * NOISY:g} %, or"
            " finds friction that is not there; the learned estimator stands 1 % (tfra train)"
        )


def _flags(status: Ints) -> Iterator[str]:
    """Status bits of most frames with a contact, except those that other warnings cover."""
    covered = (*WITHOUT_FORCE, Status.INPUT_SATURATED)
    for flag in Status:
        if flag not in covered and (share := _share(status, flag)) > 0.5:
            yield f"{100 * share:.0f} % of the frames with a contact: {status_label(flag)} ({MEANINGS[flag]})"
