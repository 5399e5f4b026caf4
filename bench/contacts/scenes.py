"""Contacts and their frames for the study of TFRA's errors: one influence at a time."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy import special

from bench.accuracy.loads import peak
from bench.publish import ROOT
from tfra.codegen.config.read import load
from tfra.model.arrays import Floats
from tfra.model.boussinesq import operators
from tfra.model.cover.contact import Contacts, ContactShape, taxel_forces
from tfra.model.cover.layer import frames
from tfra.model.cover.scenes import random_contacts
from tfra.model.sensor import SensorArray
from tfra.model.tfra import Tfra, friction

SEED = 2024
EXAMPLES = {"ellipse": "hertz_40x20", "rectangle": "rectangle_40x40"}


@dataclass(frozen=True)
class Group:
    """Contacts on one sensor."""

    sensor: SensorArray
    contacts: Contacts

    @property
    def pitch(self) -> Floats:
        """Both pitches ``(2,)``, m."""
        return np.array([self.sensor.pitch_x, self.sensor.pitch_y])

    @property
    def middle(self) -> Floats:
        """Middle of the array ``(2,)``, m."""
        return self.pitch * (self.sensor.columns - 1, self.sensor.rows - 1) / 2

    def changed(self, **fields: Floats) -> "Group":
        """The same contacts with other fields of :class:`Contacts`, whose shapes they broadcast to."""
        arrays: dict[str, Any] = {
            name: np.broadcast_to(value, getattr(self.contacts, name).shape) for name, value in fields.items()
        }
        return replace(self, contacts=replace(self.contacts, **arrays))


@dataclass(frozen=True)
class Scene:
    """Frames ``(n, rows, columns)`` in Pa, the true resultants ``(n, 3)`` in N, and the steps of the search."""

    sensor: SensorArray
    stress: Floats
    forces: Floats
    steps: int = 100


Scenes = Iterator[tuple[str, Scene]]


def groups(count: int) -> dict[str, Group]:
    """Random contacts on the 40 x 40 mm sensor, and the examples' contacts in 24 directions.

    Of ``count`` drawn ones those are left out that TFRA flags, nearly always because no taxel is under traction.
    """
    projects = {name: load(ROOT / "examples" / f"{example}.toml") for name, example in EXAMPLES.items()}
    paper = {name: Group(project.design.sensor, Contacts.of(project.contacts)) for name, project in projects.items()}
    sensor = paper["rectangle"].sensor
    drawn = Contacts.of(random_contacts(sensor, count, np.random.default_rng(SEED)))
    swept = Tfra(sensor)(frames(sensor, drawn)).status == 0
    return {"random": Group(sensor, Contacts(**{key: array[swept] for key, array in vars(drawn).items()}))} | paper


def scene(group: Group, steps: int = 100) -> Scene:
    """The group on an elastic layer, stress at the taxels' centres."""
    return Scene(group.sensor, frames(group.sensor, group.contacts), group.contacts.force, steps)


def nodes(shape: ContactShape, order: int) -> tuple[Floats, Floats, Floats]:
    """u, v in [-1, 1] and weights of sum 1, ``(order^2,)`` each: Gauss points of the shape's own profile.

    The root at the edge of ``hertz`` goes by u = r cos t, v = r sin t with s = sqrt(1 - r^2): the load is
    3 s^2 ds dt / (2 pi), smooth in both.  That of ``rounded`` is the weight of Chebyshev's second kind.
    """
    if shape is ContactShape.HERTZ:
        x, w = np.polynomial.legendre.leggauss(order)
        s, t = (x[:, None] + 1) / 2, 2 * np.pi * np.arange(order) / order
        r = np.sqrt(1 - s * s)
        weight = 1.5 * w[:, None] * s * s / order * np.ones(order)
        return (r * np.cos(t)).ravel(), (r * np.sin(t)).ravel(), weight.ravel()
    x, w = special.roots_chebyu(order) if shape is ContactShape.ROUNDED else np.polynomial.legendre.leggauss(order)
    u, v = np.meshgrid(x, x)
    return u.ravel(), v.ravel(), np.outer(w, w).ravel() / w.sum() ** 2


def half_space(sensor: SensorArray, contacts: Contacts, order: int = 48) -> Floats:
    """b_z at the taxels' centres, ``(n, rows, columns)`` in Pa, at depth h of a half-space: Eq. 5 by quadrature."""
    x, y = (p[:, None] for p in sensor.positions())
    stress = np.empty((len(contacts), sensor.taxels))
    loads = zip(contacts.shape, contacts.center, contacts.half, contacts.force, strict=True)
    for row, (shape, center, half, (f_x, f_y, f_z)) in zip(stress, loads, strict=True):
        u, v, weight = nodes(ContactShape(shape), order)
        rx, ry = center[0] + half[0] * u - x, center[1] + half[1] * v - y
        h = sensor.thickness
        c0 = 3 * h * h / (2 * np.pi * (rx * rx + ry * ry + h * h) ** 2.5)  # Eq. 5
        row[:] = (c0 * (rx * f_x + ry * f_y + h * f_z)) @ weight
    return stress.reshape(-1, sensor.rows, sensor.columns)


def kernels(group: Group) -> Scenes:
    """Scenes from TFRA's assumptions to a sensor's conditions."""
    sensor, contacts, forces = group.sensor, group.contacts, group.contacts.force
    ideal = taxel_forces(sensor, contacts).reshape(len(contacts), -1) @ operators(sensor).a.T  # Eq. 3
    yield "forces at taxels", Scene(sensor, ideal.reshape(-1, sensor.rows, sensor.columns), forces)
    yield "half-space", Scene(sensor, half_space(sensor, contacts), forces)
    yield "layer", scene(group)
    yield "layer, areas", Scene(sensor, frames(sensor, contacts, "area"), forces)


def resolutions(group: Group) -> Scenes:
    """Arrays of 5 x 5 to 20 x 20 taxels over the same surface."""
    sensor = group.sensor
    for side in (5, 7, 10, 14, 20):
        finer = Group(
            SensorArray(side, side, sensor.size_x / side, sensor.size_y / side, sensor.thickness), group.contacts
        )
        yield f"{side}×{side}", scene(finer.changed(center=group.contacts.center + (group.pitch - finer.pitch) / 2))


def noises(group: Group) -> Scenes:
    """Normal noise on every taxel, its standard deviation in percent of the frame's peak."""
    exact, rng = scene(group), np.random.default_rng(SEED)
    for percent in (0, 0.1, 0.3, 1, 3):
        noise = percent / 100 * peak(exact.stress) * rng.normal(size=exact.stress.shape)
        yield f"{percent:g} %", replace(exact, stress=exact.stress + noise)


def converters(group: Group) -> Scenes:
    """Rounded to signed codes; full scale is 105 % of the group's largest stress."""
    exact = scene(group)
    full = 1.05 * np.abs(exact.stress).max()
    for bits in (8, 10, 12, 14, 16):
        lsb = full / 2 ** (bits - 1)
        yield f"{bits}", replace(exact, stress=np.rint(exact.stress / lsb) * lsb)


def frictions(group: Group, layer: bool) -> Scenes:
    """Every contact with one friction coefficient, on the layer or on a half-space."""
    force = group.contacts.force
    for mu in (0.05, 0.1, 0.2, 0.3, 0.5, 0.7, 0.9):
        tangential = force[:, :2] * (mu / friction(force))[:, None]
        same = group.changed(force=np.concatenate([tangential, force[:, 2:]], axis=1))
        stress = (frames if layer else half_space)(same.sensor, same.contacts)
        yield f"{mu:g}", Scene(same.sensor, stress, same.contacts.force)


def sizes(group: Group) -> Scenes:
    """Half sides from a quarter to four pitches, centres within half a pitch of the middle; the paper's stay."""
    rng, count = np.random.default_rng(SEED), len(group.contacts)
    spread = 0.0 if len(np.unique(group.contacts.center, axis=0)) == 1 else 0.5
    centres = group.middle + rng.uniform(-spread, spread, (count, 2)) * group.pitch
    for size in (0.25, 0.5, 0.75, 1, 1.5, 2, 3, 3.5):
        yield f"{size:g}", scene(group.changed(half=size * group.pitch, center=centres))


def centres(group: Group) -> Scenes:
    """Moved off the middle by up to three pitches in a random direction; half sizes at most two pitches."""
    rng = np.random.default_rng(SEED)
    angle = rng.uniform(0, 2 * np.pi, len(group.contacts))
    way = np.stack([np.cos(angle), np.sin(angle)], axis=1) * group.pitch
    small = group.changed(half=np.minimum(group.contacts.half, 2 * group.pitch))
    for distance in (0, 0.25, 0.5, 1, 2, 3):
        yield f"{distance:g}", scene(small.changed(center=group.middle + distance * way))


def pairs(group: Group, turned: bool) -> Scenes:
    """Two contacts at once, apart along x, half sizes at most a pitch; they share the force by 20 to 80 %.

    ``turned`` gives the second one's tangential force a direction of its own.
    """
    rng, count = np.random.default_rng(SEED), len(group.contacts)
    share = rng.uniform(0.2, 0.8, count)
    turn = rng.uniform(0, 2 * np.pi, count) * turned
    small = group.changed(half=np.minimum(group.contacts.half, group.pitch))
    x, y, z = group.contacts.force.T
    other = np.stack([np.cos(turn) * x - np.sin(turn) * y, np.sin(turn) * x + np.cos(turn) * y, z])
    for distance in (0, 2, 3, 4, 5, 6):
        apart = np.array([distance / 2, 0]) * group.pitch
        one = scene(small.changed(center=group.middle - apart, force=(share * [x, y, z]).T))
        two = scene(small.changed(center=group.middle + apart, force=((1 - share) * other).T))
        yield f"{distance}", replace(one, stress=one.stress + two.stress, forces=one.forces + two.forces)


def searches(group: Group) -> Scenes:
    """Steps of the search for the friction coefficient."""
    exact = scene(group)
    for steps in (10, 20, 50, 100, 200, 500, 1000):
        yield f"{1 / steps:g}", replace(exact, steps=steps)


STUDIES: dict[str, tuple[str, Callable[[Group], Scenes]]] = {
    "kernel": ("stress from", kernels),
    "resolution": ("taxels over the same surface", resolutions),
    "noise": ("noise, share of the peak", noises),
    "converter": ("bits of the converter", converters),
    "friction": ("μ of the contact", lambda group: frictions(group, True)),
    "half-space": ("μ of the contact, half-space", lambda group: frictions(group, False)),
    "size": ("half size / pitch", sizes),
    "centre": ("centre off the middle / pitch", centres),
    "same": ("two contacts, same direction: distance / pitch", lambda group: pairs(group, False)),
    "turned": ("two contacts, random directions: distance / pitch", lambda group: pairs(group, True)),
    "search": ("step Δ of the search", searches),
}
"""Influences: what their settings are, and their scenes."""
