"""The pool of a skin's windows: a contact, the others about it, and the window that the search lays about it.

A patch is a part of a skin with edges of its own, so that many windows reach beyond them.  A load's three responses
there give its frames of any friction; windows are cut out of them.
"""

import math
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from tfra.model.arrays import Bools, Ints, Singles
from tfra.model.sensor import SensorArray
from tfra.model.skin.smoothing import smoothing
from tfra.model.skin.windows import corners, places
from tfra.train.pool import Frames, random_forces
from tfra.train.prior import LARGEST, random_cover, random_loads
from tfra.train.simulator import grid_count, responses

CHUNK = 256
"""Loads on one cover; all contacts of a frame are on the same one."""

ROOM, LEAST_ROOM = 1.4, 8
"""Sides of a patch beyond those of the window: this share of them, and so many taxels at least."""

CROWDED, MOST, NEAREST, RATIO = 0.6, 4, 1.0, 5.0
"""Share of frames with other contacts, up to ``MOST``; their smallest gap in pitches, and the largest ratio of normal
forces, either way."""

ASIDE = 0.1
"""Share of windows that are off by a taxel, as those of noisy frames are."""

DRAGGED, BLURRED = 0.7, 4.0
"""How far the region of a contact lies aside for each unit of friction, and how far it reaches beyond the footprint, in
thicknesses."""

_INTO = np.array([1, 1, -1], np.float32)


@dataclass(frozen=True, eq=False)
class Patches:
    """Loads on patches about windows of the ``sensor``.

    ``responses (n, 3, rows, columns)`` to unit forces, with a border of zeros; ``center`` and ``reach (n, 2)`` in
    pitches; ``height (n,)``, the largest stress of a normal force of 1 N; which chunks have a wrong cover.
    """

    sensor: SensorArray
    responses: Singles
    center: Singles
    reach: Singles
    height: Singles
    wrong: Bools

    @classmethod
    def simulate(cls, sensor: SensorArray, chunks: int, seed: tuple[int, ...], advance: Callable[[int], None]) -> Self:
        """Loads of ``chunks`` covers; each chunk follows from ``seed`` and its number, on any number of threads."""
        patch, border = patch_of(sensor), border_of(sensor)
        count, shape = chunks * CHUNK, (patch.rows + 2 * border[0], patch.columns + 2 * border[1])
        every = cls(
            sensor,
            responses=np.zeros((count, 3, *shape), np.float32),
            center=np.empty((count, 2), np.float32),
            reach=np.empty((count, 2), np.float32),
            height=np.empty(count, np.float32),
            wrong=np.empty(chunks, np.bool_),
        )

        def fill(number: int) -> None:
            part = slice(number * CHUNK, (number + 1) * CHUNK)
            rng = np.random.default_rng((*seed, number))
            (cover, every.wrong[number]), loads = random_cover(patch, rng), random_loads(patch, CHUNK, rng, share=0.0)
            pitch = np.array([sensor.pitch_x, sensor.pitch_y])
            every.center[part], every.reach[part] = loads.center / pitch, loads.reach / pitch
            points = grid_count(float(2 * loads.reach.max()), cover.layer.thickness)
            found = responses(patch, cover, loads.grids(points))
            every.height[part] = np.abs(found[:, 2]).max(axis=(1, 2))
            every.responses[part, :, border[0] : -border[0], border[1] : -border[1]] = found

        with ThreadPoolExecutor(2) as threads:
            for _ in threads.map(fill, range(chunks)):
                advance(1)
        return every

    def draw(self, count: int, rng: np.random.Generator) -> Frames:
        """Return windows of random frames; the contact in the middle has F_z = -1 N, the others are to be ignored."""
        main, forces = rng.integers(len(self.responses), size=count), random_forces(count, rng)
        corner = self._corner(main, forces, rng)
        shape = self.sensor.rows, self.sensor.columns
        frames, peak = self._cut(main, forces, corner, shape), self.height[main]
        others = np.where(rng.random(count) < CROWDED, rng.integers(1, MOST + 1, count), 0)
        for number in range(MOST):
            which = np.flatnonzero(others > number)
            other = main[which] // CHUNK * CHUNK + rng.integers(CHUNK, size=len(which))
            apart = np.abs(self.center[other] - self.center[main[which]]) - self.reach[other] - self.reach[main[which]]
            free = apart.max(axis=1) >= NEAREST
            which, other = which[free], other[free]
            ratio = np.exp(rng.uniform(-math.log(RATIO), math.log(RATIO), (len(which), 1))).astype(np.float32)
            added = random_forces(len(which), rng) * ratio
            frames[which] += self._cut(other, added, corner[which], shape)
            peak[which] = np.maximum(peak[which], self.height[other] * -added[:, 2])
        weight = 1.0 - self.wrong[main // CHUNK, None].astype(np.float32)
        return Frames(frames, forces, weight, peak[:, None], self._there(corner))

    def _cut(self, which: Ints, forces: Singles, corner: Ints, shape: tuple[int, int]) -> Singles:
        """The part ``(k, m)`` of a ``shape`` of each frame, whose first row and column are ``corner (k, 2)``."""
        parts = sliding_window_view(self.responses, shape, axis=(2, 3))
        rows, columns = (corner + border_of(self.sensor)).T
        cut = parts[which, :, rows, columns].reshape(len(which), 3, shape[0] * shape[1])
        return np.asarray(((forces * _INTO)[:, None] @ cut)[:, 0], np.float32)

    def _corner(self, which: Ints, forces: Singles, rng: np.random.Generator) -> Ints:
        """First row and column ``(k, 2)`` of the window that the search lays about a contact that is alone."""
        patch, border = patch_of(self.sensor), border_of(self.sensor)
        pitch = self.sensor.pitch_y, self.sensor.pitch_x
        sizes = patch.rows, patch.columns
        thick = self.sensor.thickness / np.array(pitch)
        reach = np.ceil(LARGEST + BLURRED * thick).astype(np.int64)
        shape = np.minimum(2 * reach + 1, np.array(sizes) + 2 * border)
        about = np.rint(self.center[which, ::-1] - DRAGGED * thick * forces[:, 1::-1] / forces[:, 2:])
        first = np.clip(about.astype(np.int64) - shape // 2, -border, np.array(sizes) + border - shape)
        smooth = smoothing(self._cut(which, forces, first, (int(shape[0]), int(shape[1]))).reshape(-1, *shape))
        region = 2 * smooth >= smooth.max(axis=(1, 2), keepdims=True)
        taxels, corner = region.sum(axis=(1, 2)), []
        for axis, size in enumerate((self.sensor.rows, self.sensor.columns)):
            total = (region.sum(axis=2 - axis) * np.arange(shape[axis])).sum(axis=1) + first[:, axis] * taxels
            corner.append(corners(places(total, taxels), size))
        aside = rng.choice((-1, 1), (len(which), 2)) * (rng.random((len(which), 2)) < ASIDE)
        return np.asarray(np.stack(corner, axis=1) + aside)

    def _there(self, corner: Ints) -> Singles:
        """1 for the taxels of windows ``(k, m)`` that the patch has, 0 beyond its edges."""
        patch = patch_of(self.sensor)
        there = [
            (first[:, None] + np.arange(size) >= 0) & (first[:, None] + np.arange(size) < whole)
            for first, size, whole in zip(
                corner.T,
                (self.sensor.rows, self.sensor.columns),
                (patch.rows, patch.columns),
                strict=True,
            )
        ]
        whole = there[0][:, :, None] & there[1][:, None, :]
        return np.asarray(whole.reshape(len(corner), -1), np.float32)


def patch_of(sensor: SensorArray) -> SensorArray:
    """The patch about windows of ``sensor``."""
    rows, columns = (size + max(int(ROOM * size), LEAST_ROOM) for size in (sensor.rows, sensor.columns))
    return replace(sensor, rows=rows, columns=columns)


def border_of(sensor: SensorArray) -> Ints:
    """Rows and columns that a window reaches beyond a patch at most."""
    return np.array([sensor.rows // 2 + 1, sensor.columns // 2 + 1], dtype=np.int64)
