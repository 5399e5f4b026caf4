"""Which of the eight ways the array lies in its recordings, told by tangential loads and by places that are known."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from tfra.calibrate.fit import Fit
from tfra.calibrate.loads import Load
from tfra.model.arrays import Floats
from tfra.model.sensor import SensorArray
from tfra.recordings.input import Input

SURE = 9.0
"""Least difference of the chi squares of the best and the next way: three standard deviations."""

PLACED = 0.5
"""Standard deviation of a place by hand, in pitches."""

TURNED = 0.1
"""Standard deviation of a tangential force by hand, relative: six degrees."""


@dataclass(frozen=True)
class Orientation:
    """The way that the array lies: ``given`` with the order and the mirrors that fit best.

    ``margin``: how much better it fits than the next way, as a difference of chi squares; ``others``: ways that fit
    nearly as well, most likely first.  ``told``: loads that tell something.
    """

    given: Input
    margin: float
    others: tuple[Input, ...]
    told: int

    @property
    def is_sure(self) -> bool:
        """Whether only one way fits."""
        return not self.others


def name(given: Input) -> str:
    """The way of ``given`` as the keys of [input]."""
    return f'order = "{given.order}", flip_x = {str(given.flip_x).lower()}, flip_y = {str(given.flip_y).lower()}'


def is_square(sensor: SensorArray) -> bool:
    """Whether exchanging rows and columns leaves the places of the taxels as they are."""
    return sensor.rows == sensor.columns and math.isclose(sensor.pitch_x, sensor.pitch_y)


def orientation(sensor: SensorArray, given: Input, loads: tuple[Load, ...], found: Fit) -> Orientation:
    """The way that fits ``loads`` best, if ``found`` was fitted to readings arranged as ``given``."""
    ways = list(_ways(given, is_square(sensor)))
    told = [_misfits(sensor, load, found, at, ways, given) for at, load in enumerate(loads)]
    known = [misfits for misfits in told if misfits is not None]
    total = np.sum(known, axis=0) if known else np.zeros(len(ways))
    order = np.argsort(total, kind="stable")  # the given way is the first
    best, margins = order[0], total[order] - total[order[0]]
    others = tuple(ways[way] for way, margin in zip(order[1:], margins[1:], strict=True) if margin < SURE)
    return Orientation(ways[best], float(margins[1]), others, len(known))


def transposed(given: Input) -> Input:
    """The same with rows and columns exchanged in the order of a frame's numbers."""
    return replace(given, order="columns" if given.order == "rows" else "rows")


def _ways(given: Input, square: bool) -> Iterator[Input]:
    for order in (given.order, transposed(given).order)[: 1 + square]:
        for flip_x in (given.flip_x, not given.flip_x):
            for flip_y in (given.flip_y, not given.flip_y):
                yield replace(given, order=order, flip_x=flip_x, flip_y=flip_y)


def _turn(before: Input, after: Input) -> Floats:
    """The matrix that turns directions on the array, if it lies as ``after``, into those by ``before``."""
    mirrors = [np.diag([-1.0 if each.flip_x else 1.0, -1.0 if each.flip_y else 1.0]) for each in (before, after)]
    exchange = np.eye(2) if before.order == after.order else np.array([[0.0, 1.0], [1.0, 0.0]])
    return np.asarray(mirrors[0] @ exchange @ mirrors[1])


def _misfits(sensor: SensorArray, load: Load, found: Fit, at: int, ways: list[Input], given: Input) -> Floats | None:
    """Chi squares of ``load``, number ``at`` of those fitted, for each of the ``ways``; None if it tells nothing."""
    terms = []
    if load.direction is not None and load.tangential:
        pull = load.tangential * np.array([math.cos(load.direction), math.sin(load.direction)])
        noise = found.tangential_error[at] + (TURNED * load.tangential) ** 2 * np.eye(2)
        terms.append((pull, found.tangential[at], noise))
    if load.place:
        middle = np.array([(sensor.columns - 1) * sensor.pitch_x, (sensor.rows - 1) * sensor.pitch_y]) / 2
        noise = found.place_error[at] + (PLACED * np.diag([sensor.pitch_x, sensor.pitch_y])) ** 2
        terms.append((load.place - middle, found.place[at] - middle, noise))
    if not terms:
        return None
    turns = [_turn(given, way) for way in ways]
    return np.array(
        [
            sum(float(d @ np.linalg.solve(noise, d)) for there, here, noise in terms for d in (here - turn @ there,))
            for turn in turns
        ]
    )
