"""The blocks that estimators share, as maps of errors: what a product, an update and a clipping make of them."""

from collections.abc import Mapping

import numpy as np

from tfra.model.arrays import Floats, Ints
from tfra.model.fixed.butterfly import HADAMARD
from tfra.model.fixed.combine import products
from tfra.model.fixed.design import Design
from tfra.model.fixed.widths import scalar_fraction
from tfra.study.bounds.affine import Affine, product
from tfra.study.bounds.slack import filled, matrix, row, shifted


class Blocks:
    """The blocks of ``design``; ``exact`` are its operators, not quantised, as ``(rows, 4 K)`` of folded vectors."""

    def __init__(self, design: Design, exact: Mapping[str, Floats]) -> None:
        self.design, self._exact = design, exact
        self._operators = {op.name: op for stack in design.stacks.values() for op in stack.operators}
        self.scalar = 0.5 ** scalar_fraction(design)

    def product(self, name: str, stack: str, vector: Ints, error: Affine | None, noise: str = "") -> Affine:
        """C' (x' + rho) + r - C x = C dx + (C' - C) x' + C' rho + r, where ``error`` is dx of ``vector`` x'.

        Without an ``error``, the vector is the stress, without fraction bits.  Products of the same ``noise``, by
        default the stack's name, share rho.
        """
        op, exact, fmt, own = self._operators[name], self._exact[name], self.design.formats, noise or stack
        bits = fmt.bits(f"operand.{stack}")
        zeros = fmt.vector_fraction if error is None else 0
        rho = Affine.noise(f"operand {own}", flat(filled(vector, 1, bits, zeros)))
        form = rho.through(matrix(op.rows / 2.0**op.fraction, op.flip))
        form += Affine.noise(f"{name} {own}", row(op, exact, vector, bits, fmt.rounding))
        return form if error is None else error.through(exact) + form

    def combined(self, noise: str, scalar: Ints, by: Affine, vector: Ints, error: Affine) -> Affine:
        """s' (x' + rho) + r - s x = s' dx + x' ds - ds dx + s' rho + r; ``by`` is ds, ``error`` dx."""
        bits, value = self.design.formats.bits("operand.combine"), flat(scalar) * self.scalar
        _, shift = products(self.design, scalar, vector)
        rho = Affine.noise(f"operand {noise}", flat(filled(vector, 1, bits)))
        result = Affine.noise(noise, flat(shifted(shift)[:, None] * (vector != 0)))
        return product(f"{noise} both", by, value, error, flat(vector)) + rho.times(value) + result


def unfolded(quads: int) -> Floats:
    """The butterfly of ``quads`` as a matrix ``(4 quads, 4 quads)``."""
    return np.asarray(np.kron(np.eye(quads), HADAMARD), dtype=np.float64)


def clipped(noise: str, words: Floats | Ints, error: Affine) -> Affine:
    """Error of max(0, x): theta dx with 0 <= theta <= 1, which is known where |x'| > |dx|."""
    radius = error.radius
    theta = np.where(words > radius, 1.0, np.where(words < -radius, 0.0, 0.5))
    return error.times(theta) + Affine.noise(noise, np.where(theta == 0.5, radius / 2, 0.0))


def flat(vector: Floats | Ints) -> Floats:
    """Vectors ``(n, ...)`` as ``(n, k)``, in float64."""
    return np.asarray(vector, dtype=np.float64).reshape(len(vector), -1)
