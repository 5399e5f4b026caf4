"""A calibration from recordings and a table of loads to what is known of the array."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from tfra.calibrate.calibrated import Calibrated, is_off, left, shown
from tfra.calibrate.fit import MOST_STEPS, SPREAD, Fit, Known, Readings, fit
from tfra.calibrate.loads import Load, read_loads
from tfra.calibrate.orientation import Orientation, is_square, orientation, transposed
from tfra.calibrate.presses import Reading, UnseenError, read_press, read_rest, rearranged
from tfra.model.arrays import Bools, Floats
from tfra.recordings.calibration import MOST_GAIN, marked
from tfra.recordings.frames import levels_of
from tfra.recordings.front_end import Array, pascals_per
from tfra.recordings.input import Input, codes_of
from tfra.runtime.errors import InputError, quoted

MARGIN = 3.0
"""How far the cover may continue beyond the array, in thicknesses: sides there change nothing."""

RADIUS = 5e-3
"""Of balls whose radius is not in the table, m: they are alike then, and only that matters."""

NUMB = 0.1
"""A taxel whose sensitivity is below this share of the usual one answers no load."""

CLIPPED = 2.0
"""A mean that is fewer deviations of the noise from an end of the range is clipped by more than a hundredth of one."""

FAR, ANY = 0.7, 1.0
"""A force that differs from the sum of its readings by more, as a logarithm, and the error that it has then."""

COARSE = 15
"""Steps of a fit that shows which order is right: the wrong one would go on for long."""

LEAST_SPREAD = 0.01
"""Of the sensitivities over their mean: no sensor's are more alike."""

FLOOR = 1e-4
"""Least error of a reading, over its peak."""

FORCES = {"g": 101.97, "kg": 0.10197, "mN": 1000.0}
"""Units that forces may be in instead of N: how much of them is 1 N."""

ALIKE = 1.4
"""Ratio up to which a common gain may be that of a wrong unit."""

Advance = Callable[[str], None]
"""Is told what begins."""


class _Placed(NamedTuple):
    """``readings`` whose taxels lie as ``given`` says, those under a load, and what they tell the fit, in its order."""

    given: Input
    readings: tuple[Reading, ...]
    pressed: tuple[Reading, ...]
    told: Readings


def calibrate(array: Array, config: Input, files: Sequence[Path], table: Path, advance: Advance) -> Calibrated:
    """Calibrate ``array`` from recordings ``files``, read as ``config`` says, of the loads in ``table``.

    Raises ``InputError`` for what is no recording of its load, and for loads that tell no gains.
    """
    plain = replace(config, tare=None, tare_frames=0, rest_code=None, calibration=None, drift_frames=0)
    readings, unseen = _read(array, plain, files, table, advance)
    if not any(reading.load.normal for reading in readings):
        if unseen:
            raise unseen[0]
        raise InputError(table, "force_n", "at least one load with a normal force is needed")
    plain = _signed(plain, readings)
    advance("fitting the loads")
    placed = [_placed(array, plain, plain, readings)]
    if not is_square(array.sensor):
        placed.append(_placed(array, plain, transposed(plain), readings))
    coarse = [_fit(array, each, COARSE) for each in placed]
    here, first = min(zip(placed, coarse, strict=True), key=lambda each: each[1].cost)
    ends = _fit(array, here, MOST_STEPS, start=first)
    goes_on = _fit(array, here, MOST_STEPS, MARGIN * array.sensor.thickness, ends)
    first = min(ends, goes_on, key=lambda each: each.cost)
    _check_unit(table, here.given, 1 / float(np.median(first.sensitivity)))
    found = orientation(array.sensor, here.given, tuple(reading.load for reading in here.pressed), first)
    advance("fitting the cover")
    refined = _refined(array, config, table, here, first, found)
    return replace(refined, unseen=tuple(map(str, unseen)))


def _fit(array: Array, placed: _Placed, steps: int, margin: float = 0.0, start: Fit | None = None) -> Fit:
    """A fit with gains that are alike but for SPREAD, and forces that the sums of the readings confirm."""
    known = _known(array, placed.pressed)
    balance = np.log(np.abs((placed.told.value * placed.told.told).sum(axis=1) / known.normal))
    known = _unsure(known, np.abs(balance - np.median(balance)) > FAR)
    return fit(array.sensor, margin, known, placed.told, SPREAD, steps, start)


def _refined(array: Array, config: Input, table: Path, before: _Placed, first: Fit, found: Orientation) -> Calibrated:
    """Fit again, with the taxels in their places, and the spread and the misfit that the ``first`` fit shows."""
    sensor = array.sensor
    numb = np.abs(first.sensitivity) + first.sensitivity_error < NUMB * abs(np.median(first.sensitivity))
    answered = before.told._replace(told=before.told.told & ~numb)
    spread, misfit = _spread(first, answered), _misfit(first, answered)
    known = _unsure(_known(array, before.pressed), is_off(shown(first, before.told)))
    placed = _placed(array, before.given, found.given, before.readings)
    numb = rearranged(numb.reshape(sensor.rows, -1), before.given, found.given, sensor).ravel()
    told = placed.told._replace(told=placed.told.told & ~numb)
    told = told._replace(error=np.hypot(told.error, misfit * _peaks(told)))
    return Calibrated(
        array=array,
        config=config,
        given=placed.given,
        table=table,
        readings=placed.readings,
        pressed=placed.pressed,
        told=told,
        fit=fit(sensor, first.margin, known, told, spread),
        spread=spread,
        misfit=misfit,
        dead=~told.told.any(axis=0).reshape(sensor.rows, sensor.columns),
        noise=_noise(placed.readings),
        orientation=found,
    )


def _check_unit(table: Path, given: Input, common: float) -> None:
    """Raise ``InputError`` for forces in another unit than N, by the usual gain."""
    for unit, factor in FORCES.items():
        if factor / ALIKE < common < factor * ALIKE:
            reason = f"all loads show {1 / common:.3g} times their forces: are those in {unit}? N is needed"
            raise InputError(table, "force_n", reason)
    if not 1 / MOST_GAIN < common < MOST_GAIN:
        key = "pa_per_code or [adc] full_scale_pa" if given.unit == "codes" else "unit"
        raise InputError(table, "force_n", f"all loads show {1 / common:.3g} times their forces: look at {key}")


def _placed(array: Array, before: Input, after: Input, readings: tuple[Reading, ...]) -> _Placed:
    """``readings``, whose taxels lie as ``before``, as if they lay as ``after``."""
    placed = tuple(reading.placed(before, after, array.sensor) for reading in readings)
    pressed = tuple(reading for reading in placed if not reading.load.at_rest)
    return _Placed(after, placed, pressed, _told(array, after, placed, pressed))


def _unsure(known: Known, which: Bools) -> Known:
    """The same, but the forces of loads ``which (n,)`` may be any: their readings count, and tell the force."""
    return known._replace(error=np.where(which, ANY, known.error))


def _read(
    array: Array, given: Input, files: Sequence[Path], table: Path, advance: Advance
) -> tuple[tuple[Reading, ...], list[UnseenError]]:
    """The readings of all loads that are seen, in the order of the table, and what is said of the others."""
    loads = read_loads(table)
    named = _by_name(files, table, loads)
    levels: dict[Path, Floats] = {}
    found, unseen = [], []
    for load in loads:
        file = named[load.recording]
        if file not in levels:
            advance(f"reading {file.name}")
            levels = {file: levels_of(file, array.sensor, array.adc, given).frames}  # only the last one is kept
        try:
            found.append((read_rest if load.at_rest else read_press)(file, load, levels[file]))
        except UnseenError as error:
            unseen.append(error)
    return tuple(found), unseen


def _by_name(files: Sequence[Path], table: Path, loads: tuple[Load, ...]) -> dict[str, Path]:
    """The files by the names of their loads; raises ``InputError`` for a load without a file, and the reverse."""
    named = {name: file for file in files for name in (file.stem, file.name, str(file))}
    for load in loads:
        if load.recording not in named:
            reason = f"{quoted(load.recording)} is none of the recordings"
            raise InputError(table, f"line {load.line}: recording", reason)
    used = {named[load.recording] for load in loads}
    if unused := [file for file in files if file not in used]:
        raise InputError(table, "recording", f"no row says what was done in {unused[0]}")
    return named


def _signed(given: Input, readings: tuple[Reading, ...]) -> Input:
    """``given`` with the sign of compression that the loads show; raises ``InputError`` for one that shows another."""
    pressed = [reading for reading in readings if not reading.load.at_rest]
    signs = np.sign([reading.deviation.sum() for reading in pressed])
    for reading, sign in zip(pressed, signs, strict=True):
        if sign * signs.sum() < 0:
            reason = "its numbers go another way under the load than those of most: does it start at rest?"
            raise InputError(reading.file, "", reason)
    return replace(given, compression="positive" if signs.sum() > 0 else "negative")


def _noise(readings: tuple[Reading, ...]) -> Floats:
    """Standard deviation of a frame, ``(rows, columns)``, of all recordings together; at least that of rounding."""
    every = np.array([reading.noise for reading in readings if np.isfinite(reading.noise).all()])
    return np.asarray(np.sqrt((every**2).mean(axis=0)) if len(every) else np.zeros_like(readings[0].noise))


def _known(array: Array, pressed: tuple[Reading, ...]) -> Known:
    """What the table says of the loads, in arrays."""
    loads = [reading.load for reading in pressed]
    area = array.sensor.taxels * array.sensor.taxel_area
    return Known(
        normal=np.array([load.normal or load.pressure * area for load in loads]),
        tangential=np.array([load.tangential for load in loads]),
        even=np.array([bool(load.pressure) for load in loads]),
        error=np.array([load.error for load in loads]),
        indenter=tuple(load.indenter for load in loads),
        radius=np.array([load.radius or RADIUS for load in loads]),
    )


def _told(array: Array, given: Input, readings: tuple[Reading, ...], pressed: tuple[Reading, ...]) -> Readings:
    """Deviations in Pa of the gain 1, their errors, and which of them count: of taxels alive and within their range.

    Raises ``InputError`` for a load under which no taxel counts.
    """
    shape, count = (array.sensor.rows, array.sensor.columns), len(pressed)
    pascals = pascals_per(given, array.adc) * (-1.0 if given.compression == "positive" else 1.0)
    noise = _noise(readings)
    rounding = 1 / 12 if given.unit == "codes" else 0.0
    alive = ~marked(given.dead, shape) & np.any([reading.changes for reading in readings], axis=0)
    first, last = codes_of(given.coding, array.adc.bits) if given.unit == "codes" else (-np.inf, np.inf)
    value = pascals * np.array([reading.deviation for reading in pressed]).reshape(count, -1)
    variance = np.array([reading.variance(noise) + rounding * (noise < 0.5) for reading in pressed]).reshape(count, -1)
    means = np.array([reading.pressed for reading in pressed])
    still = np.abs([reading.deviation for reading in pressed]) < 2 * CLIPPED * noise
    inside = still | ((means - CLIPPED * noise > first) & (means + CLIPPED * noise < last))
    told = (alive & inside).reshape(count, -1)
    for reading, compressed in zip(pressed, (told & (value < 0)).any(axis=1), strict=True):
        if not compressed:
            reason = "presses on no taxel that counts: they are dead, or at an end of the converter's range"
            raise InputError(reading.file, "", reason)
    error = np.hypot(abs(pascals) * np.sqrt(variance), FLOOR * np.abs(value).max(axis=1, keepdims=True))
    return Readings(value, error, told)


def _peaks(told: Readings) -> Floats:
    return np.asarray(np.abs(np.where(told.told, told.value, 0.0)).max(axis=1, keepdims=True))


def _spread(found: Fit, told: Readings) -> float:
    """Standard deviation of the sensitivities over their mean: that of the estimates, and of what is left of them."""
    which = told.told.any(axis=0)
    values, errors = found.sensitivity[which], found.sensitivity_error[which]
    spread = np.sqrt(np.var(values) + np.mean(errors**2)) / abs(np.mean(values))
    return float(np.clip(spread, LEAST_SPREAD, SPREAD))


def _misfit(found: Fit, told: Readings) -> float:
    """What the model leaves beyond the errors of the readings, over their peaks."""
    beyond = (left(found, told) ** 2).sum() - (told.error[told.told] ** 2).sum()
    return float(np.sqrt(max(0.0, beyond) / (told.told * _peaks(told) ** 2).sum()))
