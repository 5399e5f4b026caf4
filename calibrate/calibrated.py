"""What a calibration has found, and what commands need of it."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from tfra.calibrate.fit import Fit, Readings
from tfra.calibrate.loads import Load
from tfra.calibrate.orientation import Orientation
from tfra.calibrate.presses import Reading
from tfra.model.arrays import Bools, Floats
from tfra.recordings.calibration import Cover
from tfra.recordings.front_end import Array
from tfra.recordings.input import Input

TOLD = 0.25
"""A load told about a taxel if the error of its gain is below this share of the spread that was expected."""

NOISY = 5.0
"""Times the usual noise."""

OFF, SURELY = 0.05, 5.0
"""A load is off if it shows another force by more than this share, and by so many usual deviations."""


def shown(fit: Fit, told: Readings) -> Floats:
    """The force that each load shows over that of the table, ``(n,)``."""
    weights = np.where(told.told, told.error**-2.0, 0.0)
    expected = fit.sensitivity * fit.stress / fit.scale[:, None]
    return np.asarray((weights * told.value * expected).sum(axis=1) / (weights * expected**2).sum(axis=1))


def left(fit: Fit, told: Readings) -> Floats:
    """What the model leaves of the readings, Pa, ``(n, m)``; 0 where nothing was told."""
    return np.where(told.told, told.value - fit.sensitivity * fit.stress, 0.0)


def is_off(ratio: Floats) -> Bools:
    """Which loads show another force than that of the table, by the ``ratio (n,)`` of both."""
    usual = float(np.median(np.abs(ratio - np.median(ratio)))) * 1.48
    return np.asarray(np.abs(ratio - 1) > max(OFF, SURELY * usual))


def short(value: float) -> float:
    """Six digits are more than any calibration knows."""
    return float(f"{value:.6g}")


@dataclass(frozen=True, eq=False)
class Calibrated:
    """What is known of ``array`` from ``readings`` of loads, read as ``given``, and of the array at rest.

    ``fit``: of ``pressed``, the readings of all loads but rest, with what was ``told`` to it; ``spread``: standard
    deviation of the sensitivities over their mean; ``misfit``: what the model leaves, over the peak of a reading.
    ``dead (rows, columns)``: taxels that never change, answer no load, or that CONFIG says are dead.
    ``table``: the file with the loads; ``config``: how CONFIG says that the recordings are read.  ``unseen``: what is
    said of recordings that show no load, which are left out.
    """

    array: Array
    config: Input
    given: Input
    table: Path
    readings: tuple[Reading, ...]
    pressed: tuple[Reading, ...]
    told: Readings
    fit: Fit
    spread: float
    misfit: float
    dead: Bools
    noise: Floats
    orientation: Orientation
    unseen: tuple[str, ...] = ()

    @property
    def loads(self) -> tuple[Load, ...]:
        """Those of the fit, in its order."""
        return tuple(reading.load for reading in self.pressed)

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        return self.array.sensor.rows, self.array.sensor.columns

    @property
    def dead_places(self) -> tuple[tuple[int, int], ...]:
        """Row and column of each dead taxel, as [input] has them."""
        return tuple((int(row), int(column)) for row, column in np.argwhere(self.dead))

    @cached_property
    def common(self) -> float:
        """The usual gain: by how much more the loads press than the readings say."""
        return float(1 / np.average(self.fit.sensitivity, weights=self.fit.sensitivity_error**-2.0))

    @property
    def cover(self) -> Cover:
        """That which acts."""
        fit = self.fit
        return Cover(
            thickness_mm=short(1e3 * fit.thickness),
            thickness_error_mm=short(1e3 * fit.thickness_error),
            poisson=short(fit.poisson),
            poisson_error=short(fit.poisson_error),
        )

    @property
    def ends(self) -> Bools:
        """Loads under which a taxel that is alive reached an end of the converter's range, ``(n,)``."""
        return np.asarray((~self.told.told & ~self.dead.ravel()).any(axis=1))

    @cached_property
    def gain(self) -> Floats:
        """Stress over that of the reading, ``(rows, columns)``; of the dead ones that of the others."""
        gain = 1 / np.where(self.dead.ravel(), 1 / self.common, self.fit.sensitivity)
        return np.asarray(gain.reshape(self.shape))

    @cached_property
    def gain_error(self) -> Floats:
        """Standard deviation of the gain, relative, ``(rows, columns)``; of the dead ones the spread."""
        error = self.fit.sensitivity_error / np.abs(self.fit.sensitivity)
        return np.asarray(np.where(self.dead, self.spread, error.reshape(self.shape)))

    @cached_property
    def known(self) -> Bools:
        """Taxels whose gain a load has told, ``(rows, columns)``."""
        return np.asarray(~self.dead & (self.gain_error < TOLD * self.spread))

    @cached_property
    def noisy(self) -> Bools:
        """Taxels with far more noise than usual, ``(rows, columns)``."""
        return np.asarray(~self.dead & (self.noise > NOISY * np.median(self.noise[~self.dead])))

    @cached_property
    def rest(self) -> Floats:
        """Levels at rest at the end of the last recording, ``(rows, columns)``, in the unit of the recordings."""
        last = self.readings[-1]
        return np.asarray(last.rest + last.moved / 2)

    @cached_property
    def shown(self) -> Floats:
        """The force that each load shows over that of the table, ``(n,)``."""
        return shown(self.fit, self.told)

    @property
    def off(self) -> Bools:
        """Loads that show another force, ``(n,)``."""
        return is_off(self.shown)

    @cached_property
    def residual(self) -> Floats:
        """What the model leaves of each reading, over its peak, ``(n, rows, columns)``; 0 where nothing was told."""
        peak = np.abs(self.told.value).max(axis=1, keepdims=True)
        return np.asarray((left(self.fit, self.told) / peak).reshape(-1, *self.shape))

    @cached_property
    def drift(self) -> float:
        """The usual way of an offset in a frame, in the unit of the recordings: over those that end at rest."""
        ways = [
            np.median(np.abs(reading.moved[~self.dead])) / (reading.span[1] + 1)
            for reading in self.readings
            if reading.moved.any()
        ]
        return float(np.median(ways)) if ways else 0.0

    @property
    def drift_frames(self) -> int:
        """The time constant for offsets that follow, in frames: where lag and noise together are least.

        The lag of a drift d over n frames is d n, and noise s leaves s/sqrt(2 n): the sum of squares is least at
        n^3 = s^2 / (4 d^2).  0: the offsets don't move.
        """
        noise = float(np.median(self.noise[~self.dead]))
        return 0 if not self.drift else max(2, round((noise**2 / (4 * self.drift**2)) ** (1 / 3)))
