"""Folded, quantised operators against the dense matrices."""

import numpy as np
import pytest

from tests.model.cases import make_design
from tfra.model.boussinesq import operators
from tfra.model.cover.scenes import SENSORS
from tfra.model.fixed.butterfly import EE, OO, OX, OY, butterfly, distinct, taxel_index, to_quads, to_taxels
from tfra.model.fixed.coefficients import quantise_rows
from tfra.model.fixed.tfra.operators import OPERATORS, PRODUCTS


@pytest.fixture(params=SENSORS, name="design")
def _design(request):
    return make_design(SENSORS[request.param])


def taxels(design, seed):
    return np.random.default_rng(seed).integers(-1000, 1000, (5, design.sensor.taxels))


def test_butterfly_twice_is_four_times_the_frame(design):
    x = taxels(design, 1)
    assert (to_taxels(design, butterfly(butterfly(to_quads(design, x)))) == 4 * x).all()


def test_places_of_a_quad_are_mirror_taxels(design):
    rows, columns = design.sensor.rows, design.sensor.columns
    for quad in taxel_index(design).tolist():
        i, j = divmod(quad[0], columns)
        mirrored = [i * columns + columns - 1 - j, (rows - 1 - i) * columns + j, (rows - i) * columns - 1 - j]
        assert quad[1:] == mirrored
    assert distinct(design).sum() == design.sensor.taxels


def dense(design):
    """Name -> dense dimensionless matrix, in the signs of the residuals."""
    ops, h2 = operators(design.sensor), design.sensor.thickness**2
    return {
        "c33_inv": ops.c33_inv / h2,
        "c33": ops.c33 * h2,
        "c31": -ops.c31 * h2,
        "c32": -ops.c32 * h2,
        "normal": ops.c33 @ ops.pinv3,
        "pinv1": ops.pinv1 / h2,
        "pinv2": ops.pinv2 / h2,
        "pinv3": ops.pinv3 / h2,
    }


def test_every_coefficient_is_stored_once(design):
    q, bits = design.quads, design.coefficient_bits
    assert bits == 4 * q * (8 * q + 4) * design.formats.coefficient  # eight operators, four quads of rows that sum
    assert {name: tuple(op.name for op in stack.operators) for name, stack in design.stacks.items()} == OPERATORS
    assert set(PRODUCTS) == set(OPERATORS)


def apply(design, op, x):
    """Exact real result of one operator on taxel vectors, from its integers."""
    folded = butterfly(to_quads(design, x)).astype(float)
    out = np.stack([folded[..., p ^ op.flip] @ (op.rows[:, p].T / 2.0**op.fraction) for p in range(4)], axis=-1)
    return out


def test_folded_operators_are_the_dense_ones_within_their_rounding(design):
    x, matrices = taxels(design, 2), dense(design)
    for stack in design.stacks.values():
        for op in stack.operators:
            if op.name not in matrices:
                continue
            got = to_taxels(design, butterfly(apply(design, op, x))) / 4
            error = np.abs(got - x @ matrices[op.name].T).max()
            assert 0 < error <= design.quads * 4 * 1000 * 2.0**-op.fraction, op.name
            assert np.abs(got).max() <= op.gain * 1000
            assert np.abs(op.rows).max() < 1 << (design.formats.coefficient - 1)
            assert np.abs(op.rows).max() >= 1 << (design.formats.coefficient - 2)


def test_running_sums_go_from_neighbour_to_neighbour():
    """Along rows of the folded array, to and fro; each is within half a unit."""
    design = make_design(SENSORS["5×7, 3×3 mm, h 2 mm"])
    rows = np.random.default_rng(4).normal(size=(3, 4, design.quads))
    words, fraction = quantise_rows(design, rows, design.formats.coefficient)
    error = (words - rows * 2.0**fraction).reshape(3, 4, design.quad_rows, design.quad_columns)
    error[:, :, 1::2] = error[:, :, 1::2, ::-1].copy()
    assert 0.4 < np.abs(np.cumsum(error.reshape(3, 4, -1), axis=-1)).max() <= 0.5 + 1e-6


def test_a_coefficient_that_is_rounded_away_from_zero_fits_its_word():
    """Half a unit is left to a neighbour that fills the word already."""
    design = make_design(SENSORS["4×6, 5×3 mm, h 2 mm"])
    top = 1 << (design.formats.coefficient - 1)
    for largest, fraction in ((top - 2, 0), (top - 1, -1)):
        rows = np.zeros((1, 4, design.quads))
        rows[0, :, :2] = 0.5, largest
        words, found = quantise_rows(design, rows, design.formats.coefficient)
        assert found == fraction
        assert top // 2 <= np.abs(words).max() < top


def test_sum_rows_are_the_sums_of_the_candidates(design):
    """A_pq of Eq. 12 from explicit forces of Eq. 10."""
    ops, h2 = operators(design.sensor), design.sensor.thickness**2
    rng = np.random.default_rng(3)
    b, n = rng.normal(size=design.sensor.taxels) * 1000, rng.random(design.sensor.taxels) * 1000
    d = b + n @ (ops.c33.T * h2), -n @ ops.c31.T * h2, -n @ ops.c32.T * h2
    pinv = ops.pinv1 / h2, ops.pinv2 / h2, ops.pinv3 / h2
    a = np.array([[(p @ v).sum() for v in d] for p in pinv])
    a += n.sum() * np.array([[0, 1, 0], [0, 0, 1], [-1, 0, 0]])
    sums = {}
    for name, which, operand in (("contact", "sums_b", b), ("residual", "sums_n", n)):
        op = next(op for op in design.stacks[name].operators if op.name == which)
        folded = butterfly(to_quads(design, operand[None])).astype(float)[0]
        sums[name] = np.einsum("qpj,jp->qp", op.rows / 2.0**op.fraction, folded)
    s, t = sums["contact"], sums["residual"]
    got = [
        [s[0, OX] + t[0, OX], t[0, EE], t[0, OO]],
        [s[0, OY] + t[0, OY], t[1, OO], t[1, EE]],
        [s[0, EE] + t[2, EE], t[1, OX], t[1, OY]],
    ]
    np.testing.assert_allclose(got, a, atol=2e-4 * np.abs(a).max())
