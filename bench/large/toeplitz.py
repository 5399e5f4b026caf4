"""Operators of large arrays without matrices: convolutions with (truncated) kernels and conjugate gradients.

C31, C32 and C33 are block-Toeplitz: each is one kernel, as large as the array or cut to a radius.  C33^-1 b and
y = (A A^T)^-1 e are solved by a fixed number of steps of conjugate gradients; both matrices are symmetric and
positive definite, and A^T y, C33 C33 y are convolutions again.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.fft import irfft2, next_fast_len, rfft2

from tfra.model.arrays import Floats
from tfra.model.sensor import SensorArray

Map = Callable[[Floats], Floats]

EXACT_STEPS = 2000
"""Steps within which conjugate gradients must converge if no number of steps is given."""


def kernels(sensor: SensorArray) -> Floats:
    """C31, C32, C33 of Eq. 5 times h^2 over the distance from taxel to force: ``(3, 2 rows - 1, 2 columns - 1)``."""
    x = np.arange(1 - sensor.columns, sensor.columns) * sensor.pitch_x / sensor.thickness
    y = np.arange(1 - sensor.rows, sensor.rows)[:, None] * sensor.pitch_y / sensor.thickness
    c0 = 3 / (2 * np.pi * (x**2 + y**2 + 1) ** 2.5)
    return np.stack([c0 * x, c0 * y, c0])


class Convolution:
    """One kernel applied to frames: out[i, j] = sum of kernel[i' - i, j' - j] frame[i', j'], zero outside.

    By a Fourier transform, which is exact except for rounding; hardware would add the products.
    """

    def __init__(self, kernel: Floats) -> None:
        rows, columns = ((size + 1) // 2 for size in kernel.shape)
        self._shape = rows, columns
        self._padded = next_fast_len(2 * rows - 1), next_fast_len(2 * columns - 1)  # what wraps is not looked at
        self._spectrum = rfft2(kernel[::-1, ::-1], self._padded)

    def __call__(self, frames: Floats) -> Floats:
        """The product with ``frames (n, rows, columns)``."""
        rows, columns = self._shape
        full = irfft2(rfft2(frames, self._padded) * self._spectrum, self._padded)
        return np.asarray(full[:, rows - 1 : 2 * rows - 1, columns - 1 : 2 * columns - 1])


def conjugate_gradients(matrix: Map, b: Floats, steps: int, tolerance: float = 0.0) -> Floats:
    """Solve ``matrix`` x = ``b (n, ...)`` for symmetric, positive definite maps, each of the n separately.

    Takes ``steps`` steps, fewer once every residual is below ``tolerance`` times its ``b``.
    """
    axes = tuple(range(1, b.ndim))

    def dot(u: Floats, v: Floats) -> Floats:
        return np.asarray((u * v).sum(axis=axes, keepdims=True))

    x, r = np.zeros_like(b), b.copy()
    direction, rho = r.copy(), dot(r, r)
    goal = tolerance**2 * rho
    for _ in range(steps):
        if (rho <= goal).all():
            break
        image = matrix(direction)
        curvature = dot(direction, image)
        step = np.divide(rho, curvature, out=np.zeros_like(rho), where=curvature > 0)
        x, r = x + step * direction, r - step * image
        rho, before = dot(r, r), rho
        direction = r + np.divide(rho, before, out=np.zeros_like(rho), where=before > 0) * direction
    return x


class IterativeProducts:
    """:class:`tfra.model.tfra.Products` by convolutions and ``steps`` of conjugate gradients a solve.

    ``radius`` cuts the kernels to ``|di|, |dj| <= radius``; without it they reach over the array.
    Without ``steps``, solves continue to a residual of ``1e-12``.
    """

    def __init__(self, sensor: SensorArray, radius: int | None = None, steps: int | None = None) -> None:
        whole = kernels(sensor)
        if radius is not None:
            di = np.abs(np.arange(1 - sensor.rows, sensor.rows))[:, None]
            dj = np.abs(np.arange(1 - sensor.columns, sensor.columns))
            whole = np.where(np.maximum(di, dj) <= radius, whole, 0.0)
        self._sensor, self._h2, self._steps = sensor, sensor.thickness**2, steps
        self.taps = max(int(np.count_nonzero(kernel)) for kernel in whole)
        self._forward = [Convolution(kernel) for kernel in whole]
        self._transposed = [Convolution(kernel[::-1, ::-1]) for kernel in whole]
        one = np.ones((1, sensor.rows, sensor.columns))
        columns = [c(one) for c in self._forward[:2]]
        first, second = (conjugate_gradients(self._gram, c, EXACT_STEPS, 1e-12).ravel() for c in columns)
        self.sums = first * self._h2, second * self._h2

    def solve(self, b: Floats) -> Floats:
        return self._flat(self._solve(self._forward[2], self._grid(b))) * self._h2

    def stress(self, n: Floats) -> tuple[Floats, Floats, Floats]:
        x, y, z = (self._flat(c(self._grid(n))) / self._h2 for c in self._forward)
        return x, y, z

    def normal(self, e: Floats) -> Floats:
        solved = self._solve(self._gram, self._grid(e))
        return self._flat(self._forward[2](self._transposed[2](solved)))

    def forces(self, d: Floats) -> tuple[Floats, Floats, Floats]:
        solved = self._solve(self._gram, self._grid(d))
        x, y, z = (self._flat(c(solved)) * self._h2 for c in self._transposed)
        return x, y, z

    def _gram(self, frames: Floats) -> Floats:
        """A A^T."""
        pairs = zip(self._forward, self._transposed, strict=True)
        return np.asarray(np.sum([forward(back(frames)) for forward, back in pairs], axis=0))

    def _solve(self, matrix: Map, frames: Floats) -> Floats:
        if self._steps is None:
            return conjugate_gradients(matrix, frames, EXACT_STEPS, 1e-12)
        return conjugate_gradients(matrix, frames, self._steps)

    def _grid(self, vectors: Floats) -> Floats:
        return vectors.reshape(-1, self._sensor.rows, self._sensor.columns)

    def _flat(self, frames: Floats) -> Floats:
        return frames.reshape(len(frames), -1)
