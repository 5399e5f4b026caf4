"""What estimators make of the loads, before the calibration and after it."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from tfra.calibrate.calibrated import Calibrated
from tfra.model.arrays import Floats
from tfra.model.metrics import turn_deg
from tfra.model.sensor import SensorArray
from tfra.model.tfra import Result
from tfra.recordings.front_end import FrontEnd
from tfra.recordings.input import Input

Estimator = Callable[[SensorArray], Callable[[Floats], Result]]
"""An estimator of frames ``(n, rows, columns)`` in Pa, for the array with another cover, or as CONFIG has it."""


@dataclass(frozen=True)
class Errors:
    """Median errors over loads: of F_z, relative, of mu, and of phi in degrees; nan where nothing tells."""

    estimator: str
    force_before: float
    force_after: float
    mu_before: float
    mu_after: float
    phi_before: float
    phi_after: float


def errors(found: Calibrated, estimators: Mapping[str, Estimator]) -> list[Errors]:
    """The errors of ``estimators`` by their names, with CONFIG as it is, and with gains and cover of ``found``."""
    if not estimators:
        return []
    at = np.array([bool(load.normal) for load in found.loads])
    raw = found.told.value.reshape(-1, *found.shape)[at]
    repaired = FrontEnd(found.array, Input(dead=found.dead_places))
    sensor = found.array.sensor
    before = sensor, repaired(raw)
    after = replace(sensor, thickness=found.fit.thickness), repaired(raw * found.gain)
    rows = []
    for name, estimator in estimators.items():
        both = (_errors(found, at, estimator(cover)(stress)) for cover, stress in (before, after))
        rows.append(Errors(name, *(value for pair in zip(*both, strict=True) for value in pair)))
    return rows


def _errors(found: Calibrated, at: Floats, result: Result) -> tuple[float, float, float]:
    loads = [load for load, is_press in zip(found.loads, at, strict=True) if is_press]
    normal, tangential = (np.array([getattr(load, key) for load in loads]) for key in ("normal", "tangential"))
    phi = np.array([np.nan if load.direction is None else load.direction for load in loads])
    off = np.abs(result.resultant[:, 2] / normal + 1)
    turned = turn_deg(np.degrees(phi), result.phi_deg)
    pulled = tangential > 0
    return _median(off), _median(np.abs(result.mu - tangential / normal)[pulled]), _median(turned[pulled])


def _median(values: Floats) -> float:
    known = values[np.isfinite(values)]
    return float(np.median(known)) if len(known) else float("nan")
