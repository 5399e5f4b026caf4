"""Operators of large arrays as short sums of separable ones: X -> sum over k of L_k X R_k^T for frames X.

The kernel (r^2 + h^2)^-5/2 is a Laplace integral of Gaussians exp(-t r^2), each separable, so a few terms make
C31, C32 and C33; their inverses inherit it.  The best K terms of any matrix are the first K singular vectors of the
matrix rearranged as (i i') x (j j') for rows i, i' and columns j, j' of the array (Van Loan and Pitsianis,
Approximation with Kronecker Products, 1993).  A term costs m (rows + columns) products instead of m^2, and half of
that in mirror-folded form: every factor either commutes with the mirror of its axis or changes sign.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse.linalg import svds

from tfra.model.arrays import Floats
from tfra.model.boussinesq import gram_inverse, operators
from tfra.model.sensor import SensorArray

MOST = 40
"""Number of terms to compute."""

NAMES = ("c33_inv", "c31", "c32", "c33", "normal", "gram")
KERNELS = ("c31", "c32", "c33")
ORDER = ("c33_inv", "c31", "c32", "c33", "normal", "normal", "gram", "c31", "c32", "c33")
"""The operator products of a frame."""


@dataclass(frozen=True, eq=False)
class Separable:
    """One operator: ``left (K, rows, rows)`` and ``right (K, columns, columns)``, largest term first.

    The factors of a term are equally long; the operator's unit is shared between them.
    """

    left: Floats
    right: Floats

    @property
    def terms(self) -> int:
        """K."""
        return len(self.left)

    @property
    def products(self) -> int:
        """Multiplications of one application, mirror-folded."""
        rows, columns = self.left.shape[1], self.right.shape[1]
        return int(self.terms * (rows * half_squares(columns) + columns * half_squares(rows)))

    @property
    def words(self) -> int:
        """Entries of all factors, mirror-folded."""
        return self.terms * (half_squares(self.left.shape[1]) + half_squares(self.right.shape[1]))

    def up_to(self, tolerance: float) -> Separable:
        """The terms of at least ``tolerance`` times the first.

        Raises ``ValueError`` naming ``tolerance`` if more terms than computed could be needed.
        """
        size = np.linalg.norm(self.left, axis=(1, 2)) * np.linalg.norm(self.right, axis=(1, 2))
        if tolerance < size[-1] / size[0] and self.terms == MOST:
            raise ValueError(f"tolerance: {MOST} terms reach {size[-1] / size[0]:.1e}, not {tolerance:.1e}")
        count = int(np.count_nonzero(size >= tolerance * size[0]))
        return Separable(self.left[:count], self.right[:count])

    def matrix(self) -> Floats:
        """The operator as a dense ``(m, m)`` matrix."""
        return np.asarray(np.sum([np.kron(u, v) for u, v in zip(self.left, self.right, strict=True)], axis=0))

    def transposed(self) -> Separable:
        """The transposed operator."""
        return Separable(self.left.swapaxes(1, 2), self.right.swapaxes(1, 2))

    def quantised(self, bits: int) -> Separable:
        """Every factor in words of ``bits``, with a fraction of its own."""
        return Separable(block(self.left, bits, (1, 2)), block(self.right, bits, (1, 2)))

    def __call__(self, frames: Floats, bits: int | None = None) -> Floats:
        """The operator times ``frames (n, rows, columns)``.

        With ``bits`` both operands, the frames and their products with the right factors, are first rounded to block
        floating words, one exponent a frame; sums stay exact.
        """
        if bits is not None:
            frames = block(frames, bits, (1, 2))
        by_term = np.einsum("nij,kbj->nkib", frames, self.right, optimize=True)
        if bits is not None:
            by_term = block(by_term, bits, (1, 2, 3))
        return np.asarray(np.einsum("kai,nkib->nab", self.left, by_term, optimize=True))


def block(values: Floats, bits: int, axes: tuple[int, ...]) -> Floats:
    """``values`` rounded to signed words of ``bits`` with one power of two over ``axes``: the largest word fits."""
    largest = np.abs(values).max(axis=axes, keepdims=True)
    # frexp: largest < 2^exponent; a word that would round up to 2^(bits-1) is one too large, hence the limit
    step = np.ldexp(1.0, np.frexp(largest)[1] - (bits - 1))
    limit = 2 ** (bits - 1) - 1
    return np.asarray(np.clip(np.rint(values / step), -limit, limit) * step)


def half_squares(count: int) -> int:
    """Entries of the even and of the odd half of a folded ``count x count`` factor."""
    even, odd = (count + 1) // 2, count // 2
    return even * even + odd * odd


def separate(sensor: SensorArray, matrix: Floats) -> Separable:
    """The leading terms of ``matrix (m, m)``, at most ``MOST``; deterministic."""
    rows, columns = sensor.rows, sensor.columns
    arranged = matrix.reshape(rows, columns, rows, columns).swapaxes(1, 2).reshape(rows**2, columns**2)
    count = min(MOST, min(arranged.shape) - 1)
    left, size, right = svds(arranged, count, v0=np.ones(min(arranged.shape)) + np.arange(min(arranged.shape)))
    order = np.argsort(-size)
    scale = np.sqrt(size[order])[:, None]
    u, v = scale * left.T[order], scale * right[order]
    return Separable(u.reshape(-1, rows, rows), v.reshape(-1, columns, columns))


def separated(sensor: SensorArray) -> dict[str, Separable]:
    """Every operator of the form ``gram`` by name, dimensionless as in :mod:`tfra.model.fixed.coefficients`."""
    ops, h2 = operators(sensor), sensor.thickness**2
    matrices = {
        "c33_inv": ops.c33_inv / h2,
        "c31": ops.c31 * h2,
        "c32": ops.c32 * h2,
        "c33": ops.c33 * h2,
        "normal": ops.c33 @ ops.pinv3,
        "gram": gram_inverse(sensor) / h2**2,
    }
    return {name: separate(sensor, matrix) for name, matrix in matrices.items()}


class SeparableProducts:
    """:class:`tfra.model.tfra.Products` by the operators of :func:`separated`, cut to any number of terms.

    ``bits`` rounds coefficients and operands of every product to block floating words.
    """

    def __init__(self, sensor: SensorArray, parts: dict[str, Separable], bits: int | None = None) -> None:
        if bits is not None:
            parts = {name: part.quantised(bits) for name, part in parts.items()}
        ops = operators(sensor)
        self._sensor, self._parts, self._bits, self._h2 = sensor, parts, bits, sensor.thickness**2
        self._transposed = {name: parts[name].transposed() for name in KERNELS}
        self.sums = ops.pinv1.sum(axis=0), ops.pinv2.sum(axis=0)

    @property
    def multiplications(self) -> int:
        """Real products of a frame, mirror-folded."""
        return sum(self._parts[name].products for name in ORDER)

    @property
    def words(self) -> int:
        """Coefficients to store.

        C31, C32 and C33 are used twice, and their factors are Toeplitz: a word for each distance, two of them added for
        a folded entry.  On square arrays of one pitch, both factors of a term of the others are the same.
        """
        sensor = self._sensor
        distances = 2 * sensor.rows - 1 + 2 * sensor.columns - 1
        one = sensor.rows == sensor.columns and sensor.pitch_x == sensor.pitch_y
        kernels = sum(self._parts[name].terms * distances for name in KERNELS)
        others = sum(part.words for name, part in self._parts.items() if name not in KERNELS)
        return kernels + others // (2 if one else 1)

    def solve(self, b: Floats) -> Floats:
        return self._apply(self._parts["c33_inv"], b) * self._h2

    def stress(self, n: Floats) -> tuple[Floats, Floats, Floats]:
        x, y, z = (self._apply(self._parts[name], n) / self._h2 for name in KERNELS)
        return x, y, z

    def normal(self, e: Floats) -> Floats:
        return self._apply(self._parts["normal"], e)

    def forces(self, d: Floats) -> tuple[Floats, Floats, Floats]:
        solved = self._apply(self._parts["gram"], d) * self._h2
        x, y, z = (self._apply(self._transposed[name], solved) for name in KERNELS)
        return x, y, z

    def _apply(self, part: Separable, vectors: Floats) -> Floats:
        frames = vectors.reshape(-1, self._sensor.rows, self._sensor.columns)
        return part(frames, self._bits).reshape(vectors.shape)
