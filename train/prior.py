"""The prior of the training: random pressures, places, frictions and covers.

A pressure is a power law on an ellipse, (1 - u^2 - v^2)^a, or on a rectangle, ((1 - u^2) (1 - v^2))^a, in coordinates
that are scaled by the half sizes and may be rotated.  a = 0 is flat, and a = 1/2 is Hertz's or the rounded one.  Some
pressures are tilted: they grow linearly across the footprint.

A body that sticks in the middle of its footprint and slips at the edge transfers less shear in the middle: the traction
of some loads is the pressure times 1 - s (1 - u^2 - v^2)^b, and s (1 - u^2)^b (1 - v^2)^b on a rectangle.
"""

from dataclasses import dataclass, replace

import numpy as np

from tfra.model.arrays import Bools, Floats
from tfra.model.cover.layer import ElasticLayer
from tfra.model.sensor import SensorArray
from tfra.recordings.calibration import Cover as CalibratedCover
from tfra.train.simulator import Cover, Grids

SMALLEST, LARGEST = 0.3, 3.0
"""Half sizes, in pitches; up to ``SHARE`` of the block's side where that is more."""

SHARE = 0.3

ROTATED, TILTED = 0.3, 0.2
"""Shares of the loads."""

POWERS = (0.0, 0.5, 1.0, 2.0)
"""Exponents a of half of the loads; those of the other half lie anywhere between the first and the last."""

STICKING, EDGES = 0.2, (0.25, 2.0)
"""Share of the loads that stick in the middle, with any s from 0 to 1, and limits of b."""

CONTINUED, AREA = 0.2, 0.12
"""Shares of the covers that continue beyond the array, and of those whose taxels average over their cells."""

MARGIN = 3.0
"""How far a cover continues, in thicknesses: rollers there change nothing."""

THICKNESS, POISSON = 0.03, (0.45, 0.49)
"""Largest relative deviation of the thickness, and limits of nu."""

WRONG, WRONGLY = 0.06, (0.1, 0.3)
"""Share of the covers whose thickness is wrong, and by how much, relative, in either direction."""


@dataclass(frozen=True, eq=False)
class Loads:
    """Pressures by their parameters; lengths in m.

    ``center``, ``half`` and ``tilt`` have shape ``(n, 2)``; ``angle`` (rad), ``power`` and ``square`` have ``(n,)``.  A
    square footprint is a rectangle, any other an ellipse.  ``tilt`` is the relative growth from the centre to the edge.
    ``sticking`` and ``edge``, ``(n,)``, are s and b of the traction.
    """

    center: Floats
    half: Floats
    angle: Floats
    power: Floats
    square: Bools
    tilt: Floats
    sticking: Floats
    edge: Floats

    @property
    def reach(self) -> Floats:
        """Half sides of the upright rectangle about each footprint, ``(n, 2)``."""
        cos, sin = np.abs(np.cos(self.angle)), np.abs(np.sin(self.angle))
        x, y = self.half.T
        ways = np.stack([np.stack([x * cos, y * sin]), np.stack([x * sin, y * cos])])
        return np.asarray(np.where(self.square, ways.sum(axis=1), np.hypot(ways[:, 0], ways[:, 1])).T)

    def grids(self, count: int) -> Grids:
        """Pressure and traction of each load as the shares of ``count x count`` cells of that rectangle."""
        middles = (np.arange(count) + 0.5) * (2.0 / count) - 1.0
        across, along = (self.reach[:, axis, None] * middles for axis in (0, 1))
        cos, sin = np.cos(self.angle)[:, None, None], np.sin(self.angle)[:, None, None]
        x, y = across[:, None, :], along[:, :, None]
        u = (cos * x + sin * y) / self.half[:, 0, None, None]
        v = (cos * y - sin * x) / self.half[:, 1, None, None]
        inside = np.where(self.square[:, None, None], (1 - u * u) * (1 - v * v), 1 - u * u - v * v)
        within, inside = (np.abs(u) < 1) & (np.abs(v) < 1) & (inside > 0), np.maximum(inside, 0.0)
        pressure = within * inside ** self.power[:, None, None]
        pressure *= np.maximum(1 + self.tilt[:, 0, None, None] * u + self.tilt[:, 1, None, None] * v, 0.0)
        traction = pressure * (1 - self.sticking[:, None, None] * inside ** self.edge[:, None, None])
        shares = (load / load.sum(axis=(1, 2), keepdims=True) for load in (pressure, traction))
        return Grids(self.center[:, :1] + across, self.center[:, 1:] + along, *shares)


def random_loads(sensor: SensorArray, count: int, rng: np.random.Generator, share: float = SHARE) -> Loads:
    """Loads anywhere on the block of ``sensor``, with half sizes of up to a ``share`` of its sides."""
    pitch, block = np.array([sensor.pitch_x, sensor.pitch_y]), np.array([sensor.size_x, sensor.size_y])
    half = rng.uniform(SMALLEST * pitch, np.maximum(LARGEST * pitch, share * block), size=(count, 2))
    angle = rng.uniform(0.0, np.pi, count) * (rng.random(count) < ROTATED)
    power = np.where(rng.random(count) < 0.5, rng.choice(POWERS, count), rng.uniform(POWERS[0], POWERS[-1], count))
    square = rng.random(count) < 0.5
    tilt = rng.uniform(-1.0, 1.0, (count, 2)) * (rng.random((count, 1)) < TILTED)
    sticking = rng.random(count) * (rng.random(count) < STICKING)
    aside = rng.uniform(-1.0, 1.0, (count, 2))
    loads = Loads(aside, half, angle, power, square, tilt, sticking, rng.uniform(*EDGES, count))
    shrunk = np.minimum(1.0, 0.45 * block / loads.reach).min(axis=1, keepdims=True)
    center = (block - pitch) / 2 + aside * (block / 2 - shrunk * loads.reach)
    return replace(loads, center=center, half=shrunk * half)


def random_cover(
    sensor: SensorArray, rng: np.random.Generator, known: CalibratedCover | None = None
) -> tuple[Cover, bool]:
    """A cover of either side condition, with taxels that sample or average, and whether its thickness is wrong.

    Thickness and Poisson's ratio of a cover that is ``known``, that of ``sensor``, are normal, within their limits.
    """
    wrong = rng.random() < WRONG
    if wrong:
        deviation = rng.choice((-1, 1)) * rng.uniform(*WRONGLY)
    elif known:
        error = known.thickness_error_mm / known.thickness_mm
        deviation = np.clip(rng.normal(0.0, error), -WRONGLY[1], WRONGLY[1])
    else:
        deviation = rng.uniform(-THICKNESS, THICKNESS)
    thickness = sensor.thickness * (1 + deviation)
    margin = MARGIN * thickness * (rng.random() < CONTINUED)
    poisson = np.clip(rng.normal(known.poisson, known.poisson_error), 0.0, 0.5) if known else rng.uniform(*POISSON)
    layer = ElasticLayer.under(sensor, poisson, thickness, margin)
    return Cover(layer, (sensor.pitch_x, sensor.pitch_y) if rng.random() < AREA else (0.0, 0.0)), wrong
