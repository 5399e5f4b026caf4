"""Loads on a cover: contacts that the training may know, shapes that it can't know, and two contacts at once.

Every frame is a sum of the exact series of `model/cover/layer.py`; nothing comes from the simulator of the training.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from tfra.model.arrays import Floats
from tfra.model.cover.contact import Contacts
from tfra.model.cover.layer import ElasticLayer, Sampling, frames
from tfra.model.sensor import SensorArray
from tfra.model.tfra import friction


@dataclass(frozen=True)
class Scene:
    """Frames ``(n, rows, columns)`` in Pa and the true resultants ``(n, 3)`` in N."""

    stress: Floats
    force: Floats


def peak(stress: Floats) -> Floats:
    """Largest magnitude of each frame, ``(n, 1, 1)``."""
    return np.asarray(np.abs(stress).max(axis=(1, 2), keepdims=True))


Load = Callable[[SensorArray, Contacts, np.random.Generator], Scene]
"""Frames of as many loads as there are contacts, which state sizes, places and forces."""

PARTS, POINTS = 6, 2
"""Each taxel's cell has PARTS x PARTS parts of even pressure; that of a shape is the mean of POINTS x POINTS points."""

_CHUNK = 100  # loads at once: bounds the memory of their pressures


@dataclass(frozen=True)
class Cover:
    """The contacts themselves, on a cover that may be another one than the sensor's.

    ``thickness`` is relative to the sensor's, ``margin`` in thicknesses is how far the cover goes on beyond the block.
    """

    thickness: float = 1.0
    poisson: float = 0.48
    margin: float = 0.0
    sampling: Sampling = "point"

    def __call__(self, sensor: SensorArray, contacts: Contacts, rng: np.random.Generator) -> Scene:
        """Frames of single contacts."""
        thickness, margin = self.thickness * sensor.thickness, self.margin * sensor.thickness
        layer = ElasticLayer.under(sensor, self.poisson, thickness, margin)
        x, y = np.arange(sensor.columns) * sensor.pitch_x, np.arange(sensor.rows) * sensor.pitch_y
        window = (sensor.pitch_x, sensor.pitch_y) if self.sampling == "area" else (0.0, 0.0)
        return Scene(layer.base_stress(contacts, x, y, window), contacts.force)


def pair(sensor: SensorArray, contacts: Contacts, rng: np.random.Generator) -> Scene:
    """Every contact with another one: 0.2 to 1 times its normal force, friction and direction of its own."""
    one = Cover()(sensor, contacts, rng)
    other = rng.permutation(len(contacts))
    weight = rng.uniform(0.2, 1.0, len(contacts)) * contacts.force[:, 2] / contacts.force[other, 2]
    force = one.force + weight[:, None] * one.force[other]
    return Scene(one.stress + weight[:, None, None] * one.stress[other], force)


Pressure = Callable[[Floats, Floats, Floats, Floats], Floats]
"""Function of u, v = (x, y) / half size, of an angle, and of the friction; any scale."""


@dataclass(frozen=True)
class Shape:
    """A load on an ellipse that no training draws: the distributions of its normal and of its tangential force."""

    normal: Pressure
    tangential: Pressure

    def __call__(self, sensor: SensorArray, contacts: Contacts, rng: np.random.Generator) -> Scene:
        """Frames of one load in the place of each contact, turned by a random angle."""
        angle, mu = rng.uniform(0.0, 2 * np.pi, len(contacts)), friction(contacts.force)
        stress = np.empty((len(contacts), sensor.taxels))
        x, y, z = _influence(sensor)
        for start in range(0, len(contacts), _CHUNK):
            few = slice(start, start + _CHUNK)
            u, v = _points(sensor, contacts.center[few], contacts.half[few])
            normal, tangential = (
                _shares(sensor, pressure(u, v, angle[few, None, None], mu[few, None, None]))
                for pressure in (self.normal, self.tangential)
            )
            f_x, f_y, f_z = contacts.force[few].T[:, :, None]
            stress[few] = f_x * (tangential @ x.T) + f_y * (tangential @ y.T) + f_z * (normal @ z.T)
        return Scene(stress.reshape(-1, sensor.rows, sensor.columns), contacts.force)


@lru_cache(maxsize=1)
def _influence(sensor: SensorArray) -> tuple[Floats, Floats, Floats]:
    """Stress at the taxels per newton along x, y, z on each of PARTS x PARTS parts of every cell, ``(m, parts)``."""
    pitch = np.array([sensor.pitch_x, sensor.pitch_y])
    i, j = np.divmod(np.arange(PARTS**2 * sensor.taxels), PARTS * sensor.columns)
    center = ((np.stack([j, i], axis=1) + 0.5) / PARTS - 0.5) * pitch
    shape, half = np.full(len(i), "uniform"), np.broadcast_to(pitch / PARTS / 2, center.shape)
    x, y, z = (
        frames(sensor, Contacts(shape, center, half, np.eye(3)[[axis] * len(i)])).reshape(len(i), -1).T
        for axis in range(3)
    )
    return x, y, z


def _points(sensor: SensorArray, center: Floats, half: Floats) -> tuple[Floats, Floats]:
    """u ``(n, 1, columns of points)`` and v ``(n, rows of points, 1)``."""
    fine = PARTS * POINTS
    x, y = (
        ((np.arange(fine * count) + 0.5) / fine - 0.5) * pitch
        for count, pitch in ((sensor.columns, sensor.pitch_x), (sensor.rows, sensor.pitch_y))
    )
    u, v = (x - center[:, :1]) / half[:, :1], (y - center[:, 1:]) / half[:, 1:]
    return u[:, None, :], v[:, :, None]


def _shares(sensor: SensorArray, pressure: Floats) -> Floats:
    """Shares ``(n, parts)`` of the parts in the load, from its pressure at all points."""
    parts = pressure.reshape(len(pressure), PARTS * sensor.rows, POINTS, PARTS * sensor.columns, POINTS)
    loads = parts.sum(axis=(2, 4)).reshape(len(pressure), -1)
    return np.asarray(loads / loads.sum(axis=1, keepdims=True))


def _inside(u: Floats, v: Floats) -> Floats:
    """1 - u^2 - v^2, but at least 0."""
    return np.maximum(1 - u * u - v * v, 0.0)


def hertz(u: Floats, v: Floats, angle: Floats, mu: Floats) -> Floats:
    """Of an elastic body."""
    return np.sqrt(_inside(u, v))


def ring(u: Floats, v: Floats, angle: Floats, mu: Floats) -> Floats:
    """Of an edge: none within half of the footprint."""
    r = np.hypot(u, v)
    return np.sqrt(np.maximum((1 - r) * (r - 0.5), 0.0))


def punch(u: Floats, v: Floats, angle: Floats, mu: Floats) -> Floats:
    """Of a rigid flat body: the largest at its edge, which is a little rounded."""
    inside = _inside(u, v)
    return np.where(inside > 0, 1 / np.sqrt(np.maximum(inside, 0.02)), 0.0)


def slip(u: Floats, v: Floats, angle: Floats, mu: Floats) -> Floats:
    """Tangential load of Mindlin's partial slip where the surfaces' friction is 1: the middle sticks, carries less."""
    sticks = np.maximum(np.cbrt(1 - mu), 1e-3)
    return np.asarray(np.sqrt(_inside(u, v)) - sticks * np.sqrt(_inside(u / sticks, v / sticks)))


def tilted(u: Floats, v: Floats, angle: Floats, mu: Floats) -> Floats:
    """Of a body that stands on one side of its footprint: steeper than any of the training, a part carries nothing."""
    return np.sqrt(_inside(u, v)) * np.maximum(1 + 2 * (u * np.cos(angle) + v * np.sin(angle)), 0.0)


SHAPES: dict[str, Load] = {
    "ring": Shape(ring, ring),
    "flat punch": Shape(punch, punch),
    "partial slip": Shape(hertz, slip),
    "tilted ellipse": Shape(tilted, tilted),
}
"""Unseen shapes."""
