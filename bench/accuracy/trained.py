"""A training for one calibrated sensor against one that knows no sensor, on the frames of that sensor.

``python -m bench.accuracy.trained 2 20000`` prints the force errors of two simulated sensors after 20,000 steps each.
"""

import copy
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from bench.accuracy import sensors
from bench.accuracy.calibration import LEARNED, calibrated, forces
from bench.accuracy.sensors import Sensor
from bench.publish import ROOT
from tfra.codegen.config.read import load
from tfra.model.learned.network import Learned
from tfra.model.sensor import SensorArray
from tfra.recordings.calibration import Calibration
from tfra.train.known import UNKNOWN, Known
from tfra.train.run import Advance, Budget, run

SEED = 21
"""Where the random numbers of the sensors start."""

COUNTS, QUIET = (48, 24), 0.1
"""Units of the networks, and the noise of means of a hundred frames over that of one."""


@contextmanager
def _silent(stage: str, pieces: int, there: int) -> Iterator[Advance]:
    yield lambda pieces, state=None: None


def _network(sensor: SensorArray, steps: int, known: Known) -> Learned:
    with tempfile.TemporaryDirectory() as folder:
        trained = run(sensor, Budget(COUNTS, 1, steps), Path(folder) / "w", _silent, known)
    return Learned(sensor, trained.weights, trained.threshold)


def main(count: int = 2, steps: int = 20_000) -> None:
    """Print the median force errors of ``count`` sensors with either training."""
    nominal = load(ROOT / "examples" / LEARNED).design.sensor
    usual, noise = _network(nominal, steps, UNKNOWN), sensors.NOISE
    for seed in range(count):
        sensors.NOISE = noise
        sensor = Sensor(nominal, np.random.default_rng([SEED, seed]), thickness=0.0)
        found = calibrated(sensor)
        calibration = Calibration(found.gain, found.rest, found.dead, found.gain_error, found.cover)
        own = _network(nominal, steps, Known.of(calibration, nominal))
        print(f"sensor {seed}: {found.dead.sum()} dead, gains to {100 * np.median(found.gain_error):.1f} %")
        for share in (1.0, QUIET):
            sensors.NOISE = share * noise
            both = (forces(copy.deepcopy(sensor), found, lambda _, model=model: model) for model in (usual, own))
            before, after = (100 * each["after"] for each in both)
            print(f"  noise {100 * sensors.NOISE:.2g} % of full scale: {before:.2f} % without, {after:.2f} % with it")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
