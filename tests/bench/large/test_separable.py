"""Sums of separable operators against the dense ones, and their counts by hand."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from bench.large.separable import KERNELS, MOST, Separable, SeparableProducts, block, half_squares, separate, separated
from tfra.model.boussinesq import gram_inverse, operators
from tfra.model.cover.layer import frames
from tfra.model.cover.scenes import SENSORS, local_contacts, random_contacts
from tfra.model.sensor import SensorArray
from tfra.model.tfra import Dense, Tfra

SMALL = SENSORS["5×7, 3×3 mm, h 2 mm"]
SQUARE = SENSORS["10×10, 4×2 mm, h 3 mm"]


@pytest.fixture(scope="module", name="stress")
def _stress():
    return frames(SQUARE, random_contacts(SQUARE, 60, np.random.default_rng(3)))


@pytest.fixture(scope="module", name="parts")
def _parts():
    return separated(SQUARE)


@settings(max_examples=25)
@given(rows=st.integers(2, 6), columns=st.integers(2, 6), terms=st.integers(1, 3), seed=st.integers(0, 99))
def test_an_operator_of_few_terms_is_found(rows, columns, terms, seed):
    rng = np.random.default_rng(seed)
    left, right = rng.normal(size=(terms, rows, rows)), rng.normal(size=(terms, columns, columns))
    sensor, made = SensorArray(rows, columns, 1e-3, 1e-3, 1e-3), Separable(left, right)
    found = separate(sensor, made.matrix())
    assert_allclose(found.up_to(1e-9).matrix(), made.matrix(), atol=1e-9 * np.abs(made.matrix()).max())
    assert found.up_to(1e-9).terms <= terms
    x = rng.normal(size=(4, rows, columns))
    assert_allclose(made(x).reshape(4, -1), x.reshape(4, -1) @ made.matrix().T, atol=1e-9)
    assert_allclose(made.transposed().matrix(), made.matrix().T)


def test_dropped_terms_bound_the_error(parts):
    """What is left out is the root of the sum of the squares of what the dropped terms weigh."""
    ops, h2 = operators(SQUARE), SQUARE.thickness**2
    for name, exact in (("c33", ops.c33 * h2), ("normal", ops.c33 @ ops.pinv3), ("gram", gram_inverse(SQUARE) / h2**2)):
        whole = parts[name]
        weight = np.linalg.norm(whole.left, axis=(1, 2)) * np.linalg.norm(whole.right, axis=(1, 2))
        errors = []
        for tolerance in (1e-1, 1e-3, 1e-5):
            cut = whole.up_to(tolerance)
            error = np.linalg.norm(cut.matrix() - exact)
            assert error == pytest.approx(np.linalg.norm(weight[cut.terms :]), rel=0.01)
            errors.append(error)
        assert errors[0] > errors[1] > errors[2]


def test_factors_commute_with_the_mirrors_or_change_sign(parts):
    """What folding and the counts of products rest on."""
    for name, part in parts.items():
        cut = part.up_to(1e-6)
        for factors, sign in ((cut.left, -1 if name == "c32" else 1), (cut.right, -1 if name == "c31" else 1)):
            scale = np.abs(factors).max(axis=(1, 2), keepdims=True)
            assert np.abs(factors[:, ::-1, ::-1] - sign * factors).max() < 1e-6 * scale.max(), name


def test_few_terms_are_enough_and_counted(parts):
    terms = {name: part.up_to(1e-5).terms for name, part in parts.items()}
    assert terms["c33"] <= 6 >= terms["c33_inv"]
    assert terms["normal"] <= 18
    part = parts["c33"].up_to(1e-5)
    # every term: two products of a 10x10 frame with a 10x10 factor of two halves
    assert part.products == part.terms * 2 * 10 * (25 + 25)
    assert part.words == part.terms * 2 * 50
    assert half_squares(7) == 16 + 9
    cut = {name: p.up_to(1e-5) for name, p in parts.items()}
    once, twice = ("c33_inv", "gram"), ("c31", "c32", "c33", "normal")
    applied = sum(terms[name] for name in once) + 2 * sum(terms[name] for name in twice)
    products = SeparableProducts(SQUARE, cut)
    assert products.multiplications == 1000 * applied
    kernels = sum(terms[name] for name in KERNELS)
    assert products.words == 38 * kernels + 100 * (sum(terms.values()) - kernels)


def test_kernels_are_toeplitz_and_equal_pitches_make_equal_factors(parts):
    """What the count of words rests on."""
    for name in KERNELS:
        for factors in (parts[name].up_to(1e-6).left, parts[name].up_to(1e-6).right):
            assert_allclose(factors[:, 1:, 1:], factors[:, :-1, :-1], atol=1e-9 * np.abs(factors).max())
    sensor = SensorArray(6, 6, 3e-3, 3e-3, 2e-3)
    for name, part in separated(sensor).items():
        for left, right in zip(part.up_to(1e-5).left, part.up_to(1e-5).right, strict=True):
            same = min(np.abs(left - right).max(), np.abs(left + right).max()) < 1e-6 * np.abs(left).max()
            assert same == (name not in ("c31", "c32")), name
    cut = {name: part.up_to(1e-5) for name, part in separated(sensor).items()}
    others = sum(part.terms for name, part in cut.items() if name not in KERNELS)
    assert SeparableProducts(sensor, cut).words == 22 * sum(cut[name].terms for name in KERNELS) + 18 * others


def test_products_are_the_dense_ones(parts, stress):
    x = stress.reshape(len(stress), -1)
    dense, found = Dense(operators(SQUARE)), SeparableProducts(SQUARE, parts)
    for got, expected in (
        (found.solve(x), dense.solve(x)),
        (found.normal(x), dense.normal(x)),
        *zip(found.stress(x), dense.stress(x), strict=True),
        *zip(found.forces(x), dense.forces(x), strict=True),
        *zip(found.sums, dense.sums, strict=True),
    ):
        assert_allclose(got, expected, atol=1e-6 * np.abs(expected).max())


def test_tfra_by_terms(parts, stress):
    exact = Tfra(SQUARE)(stress)
    swept = exact.status == 0
    shares = []
    for tolerance, bits in ((1e-2, None), (1e-6, None), (1e-6, 18), (1e-6, 10)):
        cut = {name: part.up_to(tolerance) for name, part in parts.items()}
        found = Tfra(SQUARE, ops=SeparableProducts(SQUARE, cut, bits))(stress)
        shares.append((found.sweep_index == exact.sweep_index)[swept].mean())
        assert_allclose(found.phi_deg, exact.phi_deg)
    assert shares[0] < 0.8 > shares[3]
    assert shares[1] == 1
    assert shares[2] >= 0.95


@settings(max_examples=50)
@given(bits=st.integers(4, 20), seed=st.integers(0, 99), scale=st.floats(1e-6, 1e6))
def test_blocks_are_words_of_one_exponent(bits, seed, scale):
    x = scale * np.random.default_rng(seed).normal(size=(3, 4, 5))
    x[1] = 0
    found = block(x, bits, (1, 2))
    largest = np.abs(x).max(axis=(1, 2), keepdims=True)
    step = np.where(largest > 0, np.exp2(np.floor(np.log2(np.where(largest > 0, largest, 1))) + 2 - bits), 1)
    words = found / step
    assert_allclose(words, np.rint(words))
    assert np.abs(words).max() < 2 ** (bits - 1)
    assert (np.abs(found - x) <= step).all()
    assert (found[1] == 0).all()
    corrupted = found + step / 4
    assert np.abs(corrupted / step - np.rint(corrupted / step)).max() > 0.2


def test_too_fine_a_tolerance_is_refused():
    part = Separable(np.ones((MOST, 2, 2)), np.ones((MOST, 3, 3)))
    with pytest.raises(ValueError, match=r"^tolerance: 40 terms reach 1.0e\+00"):
        part.up_to(1e-3)
    assert part.up_to(1.0).terms == MOST


def test_local_contacts_are_those_of_a_small_array_moved_by_whole_taxels():
    large = SensorArray(20, 30, 4e-3, 2e-3, 3e-3)
    small = SensorArray(10, 10, 4e-3, 2e-3, 3e-3)
    near = random_contacts(small, 40, np.random.default_rng(1))
    sizes = {(c.half_x, c.half_y) for c in near}
    found = local_contacts(large, 40, np.random.default_rng(1))
    assert (found[0].half_x, found[0].half_y) in sizes
    for contact in local_contacts(large, 200, np.random.default_rng(2)):
        assert contact.half_x <= 0.3 * small.size_x
        assert contact.half_x - 2e-3 <= contact.center_x <= large.size_x - contact.half_x - 2e-3 + 1e-12
        assert contact.half_y - 1e-3 <= contact.center_y <= large.size_y - contact.half_y - 1e-3 + 1e-12
    assert local_contacts(SMALL, 5, np.random.default_rng(3)) == random_contacts(SMALL, 5, np.random.default_rng(3))
