"""What looks wrong in a calibration, or in the loads behind it, in a line each."""

from collections.abc import Iterator

import numpy as np

from tfra.calibrate.calibrated import NOISY, Calibrated
from tfra.calibrate.orientation import name
from tfra.model.arrays import Floats
from tfra.recordings.calibration import SURE
from tfra.recordings.input import codes_of
from tfra.report.table import listed, number

FAR = 2.5
"""A common gain beyond this ratio is not a sensor's."""

FEW = 5
"""Fewer presses tell little of single taxels."""

LEFT = 0.05
"""A model that leaves more of the peaks does not fit."""

UNUSED = 0.1
"""A share of the range that loads should reach."""

SLOPE = 0.05
"""A change of the sensitivity over a decade of forces, or between loading and unloading, that is told."""


def doubts(found: Calibrated) -> Iterator[str]:
    """The doubts about ``found``, the gravest first."""
    yield from _unit(found)
    yield from _sign_and_way(found)
    yield from _single_loads(found)
    yield from _what_is_told(found)
    yield from _taxels(found)
    yield from _cover(found)
    yield from _range(found)
    yield from _shape_of_the_curve(found)


def _unit(found: Calibrated) -> Iterator[str]:
    if not 1 / FAR < found.common < FAR:
        key = "pa_per_code or [adc] full_scale_pa" if found.given.unit == "codes" else "unit"
        yield f"all loads show {number(1 / found.common)} times their forces: look at {key}, and at the unit of force_n"


def _sign_and_way(found: Calibrated) -> Iterator[str]:
    given, config = found.given, found.config
    if given.compression != config.compression:
        yield f'[input]: compression = "{given.compression}" is needed: the loads show that sign'
    if not found.orientation.told:
        yield "no load tells how the array lies: give tangential_n and direction_deg of one, or x_mm and y_mm of two"
    elif not found.orientation.is_sure:
        ways = [name(way) for way in found.orientation.others[:1]]
        yield f"the loads don't tell how the array lies: {name(given)} fits, and {listed(ways)} nearly as well"
    if name(given) != name(config):
        margin = (
            f"better by {found.orientation.margin:.0f} of chi square" if found.orientation.told else "gains show it"
        )
        yield f"[input]: {name(given)} is needed ({margin})"


def _single_loads(found: Calibrated) -> Iterator[str]:
    yield from (f"{line}; left out" for line in found.unseen[:5])
    off = np.flatnonzero(found.off).tolist()
    for at in off[:5]:
        load = found.loads[at]
        force = load.normal or load.pressure / 1e3
        unit = "N" if load.normal else "kPa"
        others = [o for o in off if o != at and _is_force_of(found, at, o) and _is_force_of(found, o, at)]
        hint = f": was it exchanged with {found.loads[others[0]].recording}?" if others else ""
        shown = number(force * found.shown[at])
        line = f"{found.table.name}, line {load.line}"
        yield f"{line}: {number(force)} {unit} in {load.recording} show as {shown} {unit}{hint}"


def _is_force_of(found: Calibrated, at: int, other: int) -> bool:
    """Whether the load ``at`` shows the force of ``other``."""
    ratio = float(found.shown[at]) * found.loads[at].normal / (found.loads[other].normal or np.inf)
    return abs(ratio - 1) < 0.2


def _what_is_told(found: Calibrated) -> Iterator[str]:
    presses = sum(bool(load.normal) for load in found.loads)
    told, alive = int(found.known.sum()), int((~found.dead).sum())
    if presses < FEW:
        who = "1 press tells" if presses == 1 else f"{presses} presses tell"
        yield f"{who} of {told} of {alive} taxels: 30 all over the array are usual"
    elif told < alive / 2:
        x, y = found.array.sensor.positions()
        known = found.known.ravel()
        where = (
            ""
            if not told
            else (
                f", from {1e3 * x[known].min():.1f} to {1e3 * x[known].max():.1f} mm along x and from "
                f"{1e3 * y[known].min():.1f} to {1e3 * y[known].max():.1f} mm along y"
            )
        )
        yield f"the loads tell of {told} of {alive} taxels only{where}: press elsewhere, too"
    if saturated := [r.load.recording for r, full in zip(found.pressed, found.ends, strict=True) if full]:
        some = listed(saturated[:3]) + (f" and {len(saturated) - 3} more" if len(saturated) > 3 else "")
        yield f"taxels at an end of the converter's range under {some} tell nothing: use less force"


def _taxels(found: Calibrated) -> Iterator[str]:
    for which, what in ((found.dead, "dead"), (found.noisy, f"noisier than usual by a factor over {NOISY:g}")):
        places = [f"{row},{column}" for row, column in np.argwhere(which)]
        if places:
            yield f"taxels that are {what}: {' '.join(places[:12])}{' ...' * (len(places) > 12)}"


def _cover(found: Calibrated) -> Iterator[str]:
    config_mm, cover = 1e3 * found.array.sensor.thickness, found.cover
    if cover.is_other(config_mm):
        value, error = cover.thickness_mm, SURE * cover.thickness_error_mm
        yield (
            f"[sensor]: the cover acts as one of {value:.3g} +- {error:.2g} mm, CONFIG says {config_mm:g} mm: "
            f"thickness_mm = {value:.3g} is needed, and weights that were trained for it"
        )
    if found.misfit > LEFT:
        yield (
            f"an elastic layer leaves {100 * found.misfit:.0f} % of the readings' peaks unexplained: "
            "are indenter and radius right, the cover flat, and the columns those of the taxels?"
        )


def _range(found: Calibrated) -> Iterator[str]:
    if found.given.unit != "codes":
        return
    first, last = codes_of(found.given.coding, found.array.adc.bits)
    used = max(float(np.abs(reading.deviation).max()) for reading in found.pressed) / (last - first)
    if used < UNUSED:
        yield f"the loads use {100 * used:.1f} % of the converter's range: more force, or a larger amplification"


def _shape_of_the_curve(found: Calibrated) -> Iterator[str]:
    normal = np.array([load.normal for load in found.loads])
    press = normal > 0
    back = np.array([load.unloading for load in found.loads])
    for value, error, what in (
        (*_slope(np.log10(normal[press]), found.shown[press]), "over ten times the force"),
        (*_difference(found.shown[back], found.shown[~back]), "while unloading"),
    ):
        if abs(value) > max(SLOPE, 3 * error):
            yield f"the sensitivity is {100 * abs(value):.0f} % {'higher' if value > 0 else 'lower'} {what}"


def _slope(x: Floats, y: Floats) -> tuple[float, float]:
    """Slope and standard deviation of a line through y over x."""
    if len(x) < FEW or np.ptp(x) < 0.3:
        return 0.0, 0.0
    coefficients, covariance = np.polyfit(x, y, 1, cov=True)
    return float(coefficients[0]), float(np.sqrt(covariance[0, 0]))


def _difference(a: Floats, b: Floats) -> tuple[float, float]:
    if min(len(a), len(b)) < 3:
        return 0.0, 0.0
    return float(a.mean() - b.mean()), float(np.hypot(a.std() / np.sqrt(len(a)), b.std() / np.sqrt(len(b))))
