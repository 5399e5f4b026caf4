"""A training for one calibrated sensor against one that knows no sensor, on the frames of that sensor.

``python -m bench.accuracy.trained`` prints the force errors of two simulated sensors, as docs/training.md has them.
"""

import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from bench.accuracy.calibration import LEARNED, calibrated, error
from bench.accuracy.sensors import Sensor
from bench.publish import ROOT
from tfra.codegen.config.read import load
from tfra.model.learned.network import Learned
from tfra.model.sensor import SensorArray
from tfra.recordings.calibration import Calibration
from tfra.recordings.front_end import FrontEnd
from tfra.recordings.input import PLAIN
from tfra.train.known import UNKNOWN, Known
from tfra.train.run import Advance, Budget, run

SEED = 21
"""Where the random numbers of the sensors start."""

COUNTS, LOADS, NOISES = (48, 24), 1000, (1e-3, 1e-2)
"""Units of the networks, loads that are estimated, and standard deviations of the noise over each frame's peak."""


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
    usual = _network(nominal, steps, UNKNOWN)
    for seed in range(count):
        sensor = Sensor(nominal, np.random.default_rng([SEED, seed]), thickness=0.0)
        found = calibrated(sensor)
        calibration = Calibration(found.gain, None, found.dead, found.gain_error, found.cover)
        own = _network(nominal, steps, Known.of(calibration, nominal))
        print(f"sensor {seed}: {found.dead.sum()} dead, gains to {100 * np.median(found.gain_error):.1f} %")
        loads, front_end = sensor.loads(0, LOADS), FrontEnd(found.array, PLAIN, None, calibration)
        stress = loads.stress(nominal, sensor.layer)
        peak = np.abs(stress).max(axis=(1, 2), keepdims=True)
        for noise in NOISES:
            frames = front_end(stress / sensor.gain + noise * peak * sensor.rng.standard_normal(stress.shape))
            before, after = (100 * error(model(frames), loads) for model in (usual, own))
            print(f"  noise {100 * noise:g} % of the peak: {before:.2f} % without, {after:.2f} % with it")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
