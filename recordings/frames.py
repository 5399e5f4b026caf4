"""Reading recordings, and the ground truth of simulated frames, from files of any supported format."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from tfra.model.arrays import Bools, Floats
from tfra.model.choices import Adc
from tfra.model.sensor import SensorArray
from tfra.recordings.arrays import archive, doubles, fits
from tfra.recordings.calibration import read_calibration
from tfra.recordings.formats import FRAMES, Values, format_of, suffixes
from tfra.recordings.formats.text import FORMAT as TEXT
from tfra.recordings.front_end import Array, FrontEnd
from tfra.recordings.input import PLAIN, Input, arranged, codes_of, overridden
from tfra.recordings.intake import averaged
from tfra.recordings.levels import doubts, fractions
from tfra.runtime.errors import InputError, require
from tfra.runtime.inputs import no_memory
from tfra.runtime.ownership import is_as_written

REFERENCES = {"resultant_ref": (3,), "mu_ref": (), "phi_ref_deg": ()}
"""True values of a frame, by key: their shapes; in N, 1 and degrees, nan where unknown."""

FRAMES_OF_NOISE = 8
"""Fewest frames of a tare that tell the noise."""

MOST = 1e12
"""Limit of any stress, force or angle in its SI unit or degrees: diamond breaks at 1e11 Pa.

The models square sums over taxels at most, so with 4096 taxels nothing overflows below 1e150.
"""


@dataclass(frozen=True, eq=False, repr=False)
class Recording:
    """Frames ``(n, rows, columns)`` in Pa, compression negative, and their times ``(n,)``, if the file has them.

    ``seconds``: the times are in s since the first frame; otherwise their unit is unknown.  ``given``: how it was read.
    ``doubts``: warnings about the numbers of its file; None for frames of no file.  ``noise`` of a taxel at rest in Pa,
    if the tare tells it.  ``dead (rows, columns)``: taxels that neighbours stand in for; None: none.
    """

    frames: Floats
    time: Floats | None = None
    seconds: bool = False
    given: Input = PLAIN
    doubts: tuple[str, ...] | None = None
    noise: float | None = None
    dead: Bools | None = None

    def __len__(self) -> int:
        return len(self.frames)

    def __repr__(self) -> str:
        low, high = self.frames.min(initial=0), self.frames.max(initial=0)
        times = "" if self.time is None else ", time"
        return f"<tfra.Recording of {len(self)} frames {self.frames.shape} in Pa, {low:.4g} to {high:.4g}{times}>"


def read_as(path: Path, chosen: Input, given: Mapping[str, Any]) -> Input:
    """How to read the recording at ``path``: as ``chosen`` in CONFIG's [input], but for the fields ``given``.

    What ``tfra frames`` wrote is in Pa and needs nothing of [input], which is about recordings.  Raises ``ValueError``
    as :func:`tfra.recordings.input.overridden`.
    """
    return overridden(PLAIN if is_as_written(path, "frames") else chosen, given)


def read_recording(path: str | Path, sensor: SensorArray, adc: Adc, given: Input) -> Recording:
    """Return the frames at ``path``, n >= 1, all finite and within ``MOST``, read as ``given`` says.

    docs/recordings.md has the formats.  Raises ``InputError`` naming the file and the line, frame, row or column that
    is wrong; rows, columns and frames count from 0, rows and columns where they are on the array.
    """
    file = Path(path)
    try:
        levels = levels_of(file, sensor, adc, given)
        rest = _rest(levels.frames, file, sensor, adc, given)
        convert = front_end(file, sensor, adc, given, rest)
        frames = pascals(file, levels.frames, convert)
        told = (*(levels.doubts or ()), *doubts(levels.frames, rest, adc, given, convert.alive))
        noise = convert.noise(rest) if rest is not None and len(rest) >= FRAMES_OF_NOISE else None
        dead = None if convert.alive.all() else ~convert.alive
        return replace(levels, frames=frames, doubts=told, noise=noise, dead=dead)
    except MemoryError as error:
        raise no_memory(file, error) from None


def read_references(path: str | Path, count: int) -> dict[str, Floats]:
    """Return the ground truth in a .npz file of ``count`` frames: those of ``REFERENCES`` that it has.

    Unknown values are nan.  Raises ``InputError`` for a key of another shape, without real numbers, or with one that is
    infinite or beyond ``MOST``.  Other formats have no references.
    """
    file = Path(path)
    if file.suffix != ".npz":
        return {}
    with archive(file) as stored:
        shapes = {key: (count, *shape) for key, shape in REFERENCES.items() if key in stored.keys}
        references = {key: doubles(stored.read(key, fits(shape))) for key, shape in shapes.items()}
    for key, values in references.items():
        if len(bad := np.argwhere(np.abs(values) > MOST)):
            raise InputError(file, key, f"frame {bad[0][0]}: {values[tuple(bad[0])]:g} is no true value")
    return references


def front_end(file: Path, sensor: SensorArray, adc: Adc, given: Input, rest: Floats | None) -> FrontEnd:
    """What makes stress of the numbers of ``file``; raises ``InputError`` for keys that don't fit the array."""
    known = None if given.calibration is None else read_calibration(given.calibration, sensor, given)
    try:
        with np.errstate(over="ignore"):  # as below
            return FrontEnd(Array(sensor, adc), given, rest, known)
    except ValueError as error:
        key, _, reason = str(error).partition(": ")
        raise InputError(file, f"input.{key}", reason) from None


def pascals(file: Path, levels: Floats, convert: Callable[[Floats], Floats]) -> Floats:
    """Return the stress that ``convert`` makes of frames ``levels (n, rows, columns)``, in Pa.

    Raises ``InputError`` naming ``file`` for the first value that is no stress.
    """
    with np.errstate(over="ignore", invalid="ignore"):  # what overflows is no stress
        frames = convert(levels)
    _refuse(file, frames, ~(np.abs(frames) <= MOST), _no_stress)
    return frames


def tare_of(sensor: SensorArray, adc: Adc, given: Input) -> Floats | None:
    """Return the frames of the tare's own file, ``(k, rows, columns)`` in the recording's unit, if there is one."""
    return None if given.tare is None else levels_of(given.tare, sensor, adc, given).frames


def in_place(file: Path, values: Floats, sensor: SensorArray, adc: Adc, given: Input) -> Floats:
    """Return ``values (n, rows * columns)`` in their own unit with every taxel in its place, ``(n, rows, columns)``.

    Raises ``InputError`` naming ``file`` for one that is not finite or, if they are codes, none of the converter's.
    """
    frames = arranged(values, given, sensor)
    if given != PLAIN:
        _refuse(file, frames, ~np.isfinite(frames), _no_stress)
    if given.unit == "codes":
        _require_codes(file, frames, adc, given)
    return frames


def levels_of(file: Path, sensor: SensorArray, adc: Adc, given: Input) -> Recording:
    """The recording in its own unit, every taxel in its place; all are numbers, or codes, if it has those."""
    values = _read(file, sensor, given)
    if not len(values.frames):
        raise InputError(file, FRAMES, "at least one frame is needed, got none")
    frames = in_place(file, doubles(values.frames), sensor, adc, given)
    if len(frames) < given.average:
        reason = f"{given.average} of them are one frame, the recording has {len(frames)} (--average)"
        raise InputError(file, FRAMES, reason)
    notes = (*values.notes, *(fractions(frames) if given.unit == "codes" else ()))
    time = None if values.time is None else values.time[given.average - 1 :: given.average]  # of the last one of each
    return Recording(averaged(frames, given.average), time, values.seconds, given, notes)


def _rest(levels: Floats, file: Path, sensor: SensorArray, adc: Adc, given: Input) -> Floats | None:
    """The frames of the array at rest, in the recording's unit."""
    if given.tare is not None:
        return tare_of(sensor, adc, given)
    if given.tare_frames > len(levels):
        reason = f"the first {given.tare_frames} frames are the tare, the recording has {len(levels)} (--tare-frames)"
        raise InputError(file, FRAMES, reason)
    return levels[: given.tare_frames] if given.tare_frames else None


def _read(file: Path, sensor: SensorArray, given: Input) -> Values:
    """What the file or folder holds; raises ``InputError`` for a name of no format."""
    if (chosen := format_of(file)) is None:
        *names, last = suffixes()
        needed = f"a name that ends in {', '.join(names)} or {last} is needed, or the folder of a rosbag2"
        raise InputError(file, "", needed)
    if given.columns and chosen is not TEXT:
        raise InputError(file, "input.columns", "are of text, as in .csv files")
    if chosen.needs:
        require(file, *chosen.needs)
    return chosen.read(file, sensor, given)


def _refuse(file: Path, frames: Floats, wrong: Bools, reason: Callable[[float], str]) -> None:
    """Raise ``InputError`` with the ``reason`` for the first of ``frames (n, rows, columns)`` that is ``wrong``."""
    if len(bad := np.argwhere(wrong)):
        place = tuple(bad[0])
        raise InputError(file, FRAMES, "frame {}, row {}, column {} ".format(*place) + reason(float(frames[place])))


def _no_stress(value: float) -> str:
    return f"is {value:g} Pa, the limit is {MOST:g} Pa" if np.isfinite(value) else "is not finite"


def _unsigned(rest: float, bits: int) -> str:
    """A hint at the coding of codes without a sign, most of which are near ``rest``."""
    half = 1 << (bits - 1)
    if abs(rest - half) < half / 16:
        return ": are they offset binary? (--coding offset)"
    code = f" --rest-code {rest:.0f}" if rest > half / 16 else ""
    return f": are they unsigned, at rest at about {rest:.0f}? (--coding unipolar{code})"


def _require_codes(file: Path, frames: Floats, adc: Adc, given: Input) -> None:
    first, last = codes_of(given.coding, adc.bits)

    def reason(value: float) -> str:
        hints = (
            (not -(2**adc.bits) <= value < 2**adc.bits, ": is the unit Pa or kPa? (--unit)"),
            (given.coding == "signed" and frames.min() >= 0, _unsigned(float(np.median(frames)), adc.bits)),
            (frames.min() < 0, ": are they signed? (--coding signed)"),
        )
        hint = next((hint for holds, hint in hints if holds), "")
        codes = f"{given.coding} codes of {adc.bits} bits are from {first} to {last}"
        return f"is {value:g}, {codes}{hint}"

    _refuse(file, frames, (frames < first) | (frames > last), reason)
