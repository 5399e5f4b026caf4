"""What to do next: the load that would make the gains surer than any other."""

import numpy as np

from tfra.calibrate.calibrated import Calibrated
from tfra.calibrate.response import Presses, Response
from tfra.report.table import number

GOOD = 0.02
"""Errors of gains and of the thickness that need no more loads."""


def advice(found: Calibrated) -> str:
    """One sentence on the next load, or that none is needed."""
    if not found.orientation.is_sure:
        return "Next: pull the pressed indenter by a thread, 3 N on 6 N, and note tangential_n and direction_deg."
    if found.fit.thickness_error > GOOD * found.fit.thickness:
        return "Next: press with the smallest ball at hand, at five places: the cover's thickness is the least sure."
    error = found.gain_error[~found.dead]
    if float(np.quantile(error, 0.9)) < GOOD:
        return f"No more loads are needed: nine of ten gains are known to {100 * np.quantile(error, 0.9):.1f} %."
    force, place, before, after = best_press(found)
    return (
        f"Next: press with {number(force)} N at x = {1e3 * place[0]:.1f} mm, y = {1e3 * place[1]:.1f} mm; the errors "
        f"of the gains there fall from {100 * before:.1f} to {100 * after:.1f} %."
    )


def best_press(found: Calibrated) -> tuple[float, tuple[float, float], float, float]:
    """Force in N and place in m of the press that takes the most off the variances of all gains.

    With the errors of the gains near it before and after.  The press is the largest of the table, over each taxel in
    turn; its own place and radius count as known.
    """
    sensor, fit = found.array.sensor, found.fit
    largest = int(np.argmax([load.normal for load in found.loads]))
    force, count = found.loads[largest].normal, sensor.taxels
    x, y = sensor.positions()
    every = np.tile([0.0, 0.0, -force], (count, 1))
    presses = Presses(x, y, np.full(count, np.log(fit.radius[largest])), every, np.zeros(count, dtype=np.bool_))
    stress = Response(sensor, fit.margin)(np.log(fit.thickness), fit.poisson, presses).value
    noise = np.median(found.told.error[largest]) + found.misfit * np.abs(stress).max(axis=1, keepdims=True)
    before = found.gain_error.ravel() ** 2
    told = (stress * fit.sensitivity / noise) ** 2
    after = 1 / (1 / before + told)
    alive = ~found.dead.ravel()
    saved = ((before - after) * alive).sum(axis=1)
    best = int(np.argmax(saved))
    near = alive & (np.abs(stress[best]) > 0.3 * np.abs(stress[best]).max())
    error_before, error_after = (float(np.sqrt(np.median(variance[near]))) for variance in (before, after[best]))
    return force, (float(x[best]), float(y[best])), error_before, error_after
