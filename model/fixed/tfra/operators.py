"""The operators of TFRA and the order of its products.

Stacks group the operators that share an operand:

    contact   b^ -> w = C33^-1 b,  and the sums of A-dagger b
    residual  n^ -> the sums of A-dagger d plus w,  and g = C33 n, d1 = -C31 n, d2 = -C32 n
    normal    e^ -> C33 A3-dagger e                 (twice: e0, then e1)
    force     d^ -> A1-dagger d, A2-dagger d, A3-dagger d

Sums are the A_pq of Eq. 12, one row each: the rows of a quad of sums work on the four parities.
"""

import numpy as np

from tfra.model.boussinesq import Operators
from tfra.model.choices import Choices
from tfra.model.fixed.butterfly import EE, OO, OX, OY
from tfra.model.fixed.coefficients import Folding, Stack, stacked

OPERATORS = {
    "contact": ("c33_inv", "sums_b"),
    "residual": ("sums_n", "c33", "c31", "c32"),
    "normal": ("normal",),
    "force": ("pinv1", "pinv2", "pinv3"),
}
"""Names of the operators of each stack, in the order of the coefficient memories."""

STACKS = tuple(OPERATORS)

PRODUCTS = ("contact", "residual", "normal", "normal", "force")
"""The stack of each product of a frame, in order: b^, n^, e0^, e1^, d^."""


def make_stacks(choices: Choices, ops: Operators) -> dict[str, Stack]:
    """Every stack by its name, in the order of ``OPERATORS``; ``ops`` in SI are to be quantised."""
    h2 = choices.sensor.thickness**2
    c31, c32, c33 = ops.c31 * h2, ops.c32 * h2, ops.c33 * h2
    pinv1, pinv2, pinv3 = ops.pinv1 / h2, ops.pinv2 / h2, ops.pinv3 / h2
    s1, s2, s3 = (p.sum(axis=0) for p in (pinv1, pinv2, pinv3))
    one = np.ones(choices.sensor.taxels)
    sums_n = [
        {EE: one - s1 @ c31, OX: s1 @ c33, OY: s2 @ c33, OO: -s1 @ c32},  # A11, A10, A20, A12
        {EE: one - s2 @ c32, OX: -s3 @ c31, OY: -s3 @ c32, OO: -s2 @ c31},  # A22, A31, A32, A21
        {EE: s3 @ c33 - one},  # A30
    ]
    sums_b = [{EE: s3, OX: s1, OY: s2}]  # A30, A10, A20
    fold = Folding(choices)
    # The sums come first, so that alpha and beta are known while the vectors are still on their way.
    quantised = (
        fold.matrix("c33_inv", ops.c33_inv / h2),
        fold.sums("sums_b", sums_b),
        fold.sums("sums_n", sums_n),
        fold.matrix("c33", c33),
        fold.matrix("c31", -c31, OX),
        fold.matrix("c32", -c32, OY),
        fold.matrix("normal", c33 @ pinv3),
        fold.matrix("pinv1", pinv1, OX),
        fold.matrix("pinv2", pinv2, OY),
        fold.matrix("pinv3", pinv3),
    )
    return stacked(choices, quantised, OPERATORS)
