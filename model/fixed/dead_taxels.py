"""Repairs of dead taxels: the best weights for contacts on the cover of a sensor."""

import numpy as np

from tfra.model.arrays import Bools, Floats, Ints
from tfra.model.cover.layer import frames
from tfra.model.cover.scenes import any_contacts
from tfra.model.fixed.front_end import repair_places
from tfra.model.fixed.repair import HEADER, ONE, PLACE
from tfra.model.sensor import SensorArray

SOURCES = 24
"""Taxels that one is repaired from, fewer if the table has no room: more make a frame longer, but hardly better."""
CONTACTS, SEED = 1000, 10_000
"""Random contacts that the weights are fitted to, and their seed."""
NOISE = 1e-2
"""Standard deviation of their noise, of a frame's peak."""


def repairs(sensor: SensorArray, dead: Bools) -> Ints:
    """Words of the table for ``dead (rows, columns)``, each taxel from the nearest that are alive.

    The weights have the least mean square error for contacts of any shape, size, place and friction, with noise.
    """
    if not dead.any():
        return np.zeros(0, dtype=np.int64)
    contacts, flat, (x, y) = _contacts(sensor), dead.ravel(), sensor.positions()
    alive = np.flatnonzero(~flat)
    sources = min(SOURCES, repair_places(dead.size) // max(1, int(flat.sum())) - 1)
    words = []
    for taxel in np.flatnonzero(flat):
        distance = np.hypot(x[alive] - x[taxel], y[alive] - y[taxel])
        near = alive[np.argsort(distance, kind="stable")[:sources]]
        seen = contacts[:, near]
        square = seen.T @ seen + len(seen) * NOISE**2 * np.eye(len(near))
        weights = np.rint(np.linalg.solve(square, seen.T @ contacts[:, taxel]) * ONE)
        limited = np.clip(weights, -2 * ONE, 2 * ONE - 1).astype(np.int64)
        words += [np.array([HEADER | taxel << PLACE]), near << PLACE | limited & ((1 << PLACE) - 1)]
    return np.concatenate(words)


def _contacts(sensor: SensorArray) -> Floats:
    """Frames ``(n, m)`` of contacts and their mirror images, in their peaks."""
    stress = frames(sensor, any_contacts(sensor, CONTACTS, np.random.default_rng(SEED)))
    mirrored = np.concatenate([stress[:, ::down, ::right] for down in (1, -1) for right in (1, -1)])
    return np.asarray((mirrored / np.abs(mirrored).max(axis=(1, 2), keepdims=True)).reshape(len(mirrored), -1))
