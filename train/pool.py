"""The pool of loads that frames are drawn from: a load's three responses give its frames of any friction.

Mirrored loads would teach nothing, since the network commutes with the mirrors exactly.
"""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import NamedTuple, Self

import numpy as np

from tfra.model.arrays import Bools, Singles
from tfra.model.sensor import SensorArray
from tfra.recordings.calibration import Cover
from tfra.train.prior import random_cover, random_loads
from tfra.train.simulator import grid_count, responses

CHUNK = 512
"""Loads on one cover; both contacts of a frame are on the same one."""

FRICTION = 1.05
"""Largest mu."""

PAIRED, LIGHTEST, PAIR_WEIGHT = 0.12, 0.2, 0.3
"""Share of frames with two contacts, the smallest ratio of their normal forces, and the weight of such a frame."""


class Frames(NamedTuple):
    """Frames ``(n, m)``, the normal force at every taxel, and their resultants ``(n, 3)``, N.

    ``weight (n, 1)`` is that of the force's error: 0 for frames that only train the uncertainty.  ``peak (n, 1)``: the
    largest magnitude that noise and offset refer to; ``there (n, m)``: 0 for taxels that always read zero, else 1.
    """

    n: Singles
    forces: Singles
    weight: Singles
    peak: Singles
    there: Singles


@dataclass(frozen=True, eq=False)
class Pool:
    """Responses ``(n, 3, m)`` of loads to unit forces, n a multiple of ``CHUNK``; which chunks have a wrong cover."""

    responses: Singles
    wrong: Bools

    @classmethod
    def simulate(
        cls,
        sensor: SensorArray,
        chunks: int,
        seed: tuple[int, ...],
        advance: Callable[[int], None],
        known: Cover | None = None,
    ) -> Self:
        """Loads of ``chunks`` covers; each chunk follows from ``seed`` and its number, on any number of threads.

        ``known``: the cover of ``sensor``, if it is.
        """
        every, wrong = np.empty((chunks * CHUNK, 3, sensor.taxels), np.float32), np.empty(chunks, np.bool_)

        def fill(number: int) -> None:
            every[number * CHUNK : (number + 1) * CHUNK], wrong[number] = _chunk(sensor, (*seed, number), known)

        with ThreadPoolExecutor(2) as threads:
            for _ in threads.map(fill, range(chunks)):
                advance(1)
        return cls(every, wrong)

    def draw(self, count: int, rng: np.random.Generator) -> Frames:
        """Return random frames; the first contact of each has F_z = -1 N."""
        first = rng.integers(len(self.responses), size=count)
        forces = random_forces(count, rng)
        frames = self._frames(first, forces)
        two = np.flatnonzero(rng.random(count) < PAIRED)
        second = first[two] // CHUNK * CHUNK + rng.integers(CHUNK, size=len(two))
        added = random_forces(len(two), rng) * rng.uniform(LIGHTEST, 1.0, (len(two), 1)).astype(np.float32)
        frames[two] += self._frames(second, added)
        forces[two] += added
        weight = np.ones((count, 1), np.float32)
        weight[two] = PAIR_WEIGHT
        weight[self.wrong[first // CHUNK]] = 0.0
        return Frames(frames, forces, weight, np.abs(frames).max(axis=1, keepdims=True), np.ones_like(frames))

    def _frames(self, which: np.typing.NDArray[np.int64], forces: Singles) -> Singles:
        units = forces * np.array([1, 1, -1], np.float32)
        return np.asarray((units[:, None] @ self.responses[which])[:, 0])


def random_forces(count: int, rng: np.random.Generator) -> Singles:
    """Resultants ``(count, 3)`` of any friction and direction with F_z = -1 N."""
    mu, phi = rng.uniform(0.0, FRICTION, count), rng.uniform(0.0, 2 * np.pi, count)
    return np.stack([mu * np.cos(phi), mu * np.sin(phi), -np.ones(count)], axis=1).astype(np.float32)


def _chunk(sensor: SensorArray, seed: tuple[int, ...], known: Cover | None) -> tuple[Singles, bool]:
    rng = np.random.default_rng(seed)
    (cover, wrong), loads = random_cover(sensor, rng, known), random_loads(sensor, CHUNK, rng)
    points = grid_count(float(2 * loads.reach.max()), cover.layer.thickness)
    return responses(sensor, cover, loads.grids(points)).reshape(CHUNK, 3, -1), wrong
