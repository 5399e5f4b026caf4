"""``tfra calibrate`` on simulated sensors: gains, thickness, intervals, the way that the array lies, and forces.

``make calibration`` writes ``bench/results/calibration.json`` and the table in docs/calibration.md; half an hour.
"""

import sys
import tempfile
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from bench.accuracy.sensors import NOISE, REST, Loads, Sensor
from bench.publish import ROOT, publish
from tfra.calibrate.calibrated import Calibrated
from tfra.calibrate.run import calibrate
from tfra.codegen.config.read import load
from tfra.model.arrays import Floats
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.sensor import SensorArray
from tfra.model.tfra import Result
from tfra.recordings.calibration import SURE, Calibration
from tfra.recordings.front_end import FrontEnd
from tfra.recordings.input import Input, arranged
from tfra.report.table import Table

SENSORS, SEED = 1000, 20
"""Simulated sensors, and where their random numbers start."""

PRESSES, PULLED, TRIED = 30, 4, 100
"""Normal and pulled loads of a calibration, and loads that are estimated after it."""

ARRAYS = ((9, 7, 3e-3, 3e-3, 3e-3), (8, 8, 3e-3, 3e-3, 3e-3), (10, 10, 4e-3, 2e-3, 3e-3), (6, 12, 2.5e-3, 2e-3, 2e-3))
"""Rows, columns, pitches and the thickness in CONFIG, m, in turn."""

Model = Callable[[Floats], Result]
"""An estimator of frames ``(n, rows, columns)`` in Pa."""

LEARNED, TRAINED = "learned_fast.toml", 60
"""CONFIG of a trained array, and sensors like it whose cover is as thick as it says."""


def measured(seed: int) -> dict[str, Any]:
    """What a calibration of the simulated sensor ``seed`` finds, beside the truth."""
    rng = np.random.default_rng(seed)
    sensor = Sensor(SensorArray(*ARRAYS[seed % len(ARRAYS)]), rng)
    found = calibrated(sensor)
    right = all(getattr(found.given, key) == getattr(sensor.given, key) for key in ("order", "flip_x", "flip_y"))
    errors = (found.gain / sensor.gain - 1)[found.known]
    inside = np.abs(errors) < SURE * found.gain_error[found.known]
    thickness = found.fit.thickness / sensor.thickness - 1
    return {
        "right": right and found.orientation.is_sure,
        "dead": bool((found.dead == sensor.dead).all()),
        "told": int(found.known.sum()),
        "taxels": int((~sensor.dead).sum()),
        "gain": float(np.median(np.abs(errors))),
        "gain_inside": int(inside.sum()),
        "thickness": float(thickness),
        "thickness_inside": bool(abs(thickness * sensor.thickness) < SURE * found.fit.thickness_error),
        **{f"tfra_{key}": value for key, value in forces(sensor, found, _tfra).items()},
    }


def learned(seed: int) -> dict[str, float]:
    """Errors of the learned estimator on the sensor ``seed`` like that of ``LEARNED``, before and after."""
    config = load(ROOT / "examples" / LEARNED)
    sensor = Sensor(config.design.sensor, np.random.default_rng([SEED, seed]), thickness=0.0)
    return forces(sensor, calibrated(sensor), lambda _: config.design.float_model)


def calibrated(sensor: Sensor) -> Calibrated:
    """The calibration of ``sensor`` from a day's recordings."""
    with tempfile.TemporaryDirectory() as folder:
        day = sensor.day(Path(folder), sensor.loads(PRESSES, PULLED))
        given = Input("codes", "positive", "unipolar", pa_per_code=sensor.pascals)
        return calibrate(day.array, given, day.files, day.table, lambda title: None)


def forces(sensor: Sensor, found: Calibrated, estimator: Callable[[SensorArray], Model]) -> dict[str, float]:
    """Median |F - F true| / |F| of loads that are tried: before the calibration, after it, and of a perfect sensor."""
    loads = sensor.loads(0, TRIED)
    stress = loads.stress(sensor.nominal, sensor.layer)
    shape = sensor.shape
    given = replace(sensor.given, pa_per_code=sensor.pascals)
    at_rest = np.zeros((REST, *shape))
    levels = [arranged(sensor.codes(np.concatenate([at_rest, frame[None]])), given, sensor.nominal) for frame in stress]
    known = Calibration(found.gain, None, found.dead)
    raw, clean = (_tared(FrontEnd(found.array, given, None, each), levels) for each in (None, known))
    noise = NOISE * sensor.pascals * 2.0**sensor.adc.bits
    perfect = stress + noise * sensor.rng.standard_normal(stress.shape)
    cover, true = (replace(sensor.nominal, thickness=each) for each in (found.fit.thickness, sensor.thickness))
    cases = {"before": (sensor.nominal, raw), "after": (cover, clean), "perfect": (true, perfect)}
    return {name: error(estimator(array)(frames), loads) for name, (array, frames) in cases.items()}


def _tared(convert: FrontEnd, recordings: Sequence[Floats]) -> Floats:
    """The stress of the last frame of each, ``(n, rows, columns)``; those before it are at rest."""
    found = []
    for levels in recordings:
        convert.tare(levels[:-1])
        found.append(convert(levels[-1:]))
    return np.concatenate(found)


def _tfra(sensor: SensorArray) -> Model:
    return TfraDesign(sensor).float_model


def error(result: Result, loads: Loads) -> float:
    """Median |F - F true| / |F|."""
    off = np.linalg.norm(result.resultant - loads.force, axis=1) / np.linalg.norm(loads.force, axis=1)
    return float(np.median(off))


def summary(found: Sequence[dict[str, Any]], trained: Sequence[dict[str, float]]) -> dict[str, Any]:
    """The numbers of the table, from those of all sensors."""
    every = {key: np.array([each[key] for each in found]) for key in found[0]}
    like = {key: np.array([each[key] for each in trained]) for key in trained[0]}
    return {
        "sensors": len(found),
        "right": int(every["right"].sum()),
        "dead": int(every["dead"].sum()),
        "told": float(every["told"].sum() / every["taxels"].sum()),
        "gain": [float(np.quantile(every["gain"], share)) for share in (0.5, 0.95)],
        "gain_inside": float(every["gain_inside"].sum() / every["told"].sum()),
        "thickness": [float(np.quantile(np.abs(every["thickness"]), share)) for share in (0.5, 0.95)],
        "thickness_inside": float(every["thickness_inside"].mean()),
        **{f"tfra_{key}": float(np.median(every[f"tfra_{key}"])) for key in ("before", "after", "perfect")},
        **{f"learned_{key}": float(np.median(like[key])) for key in ("before", "after", "perfect")},
    }


def table(numbers: dict[str, Any]) -> Table:
    """The table of docs/calibration.md."""
    sensors, percent = numbers["sensors"], 100.0
    low, high = (percent * value for value in numbers["gain"])
    thin, thick = (percent * value for value in numbers["thickness"])
    rows = [
        ("orientation right, and sure", f"{numbers['right']:,} of {sensors:,} sensors"),
        ("dead taxels found, and no others", f"{numbers['dead']:,} of {sensors:,} sensors"),
        ("taxels that the loads told about", f"{percent * numbers['told']:.1f} % of those alive"),
        ("error of their gains, median of a sensor: median / 95 % of sensors", f"{low:.2f} / {high:.2f} %"),
        ("true gain within its interval of 95 %", f"{percent * numbers['gain_inside']:.1f} %"),
        ("error of the thickness: median / 95 %", f"{thin:.2f} / {thick:.2f} %"),
        ("true thickness within its interval of 95 %", f"{percent * numbers['thickness_inside']:.1f} %"),
    ]
    for kind, label in (("tfra", "TFRA"), ("learned", f"learned estimator, {TRAINED} sensors with CONFIG's thickness")):
        before, after, perfect = (percent * numbers[f"{kind}_{key}"] for key in ("before", "after", "perfect"))
        rows.append(
            (
                f"force error of {label}: before, after, of a perfect sensor",
                f"{before:.1f}, {after:.1f}, {perfect:.1f} %",
            )
        )
    return Table("", ("figure", "measured"), rows)


def main(sensors: int = SENSORS, trained: int = TRAINED) -> None:
    """Measure and publish."""
    with ProcessPoolExecutor(2) as pool:
        found = list(pool.map(measured, range(SEED, SEED + sensors), chunksize=8))
        like = list(pool.map(learned, range(trained)))
    numbers = summary(found, like)
    publish("calibration", numbers, table(numbers).markdown(), "docs/calibration.md")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
