"""Filters against hand-made matrices and plain loops; filtered TFRA, float against bit-accurate."""

from dataclasses import fields

import numpy as np
import pytest

from tfra.model.boussinesq import Operators, operators
from tfra.model.choices import Architecture
from tfra.model.cover.layer import frames
from tfra.model.cover.scenes import SENSORS, contact_codes, random_contacts
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.fixed.tfra.pipeline import FixedTfra
from tfra.model.fixed.words import decode
from tfra.model.sensor import SensorArray
from tfra.model.tfra import Tfra
from tfra.paper.sparse import Filter, SparseDesign, error, filtered, kept, multiplications

SMALL = np.array([[9.0, 1, -8, 2], [0, 5, 1, 4], [3, 0, 6, -6], [1, 2, 3, 4]])


@pytest.mark.parametrize(
    ("kind", "strength", "expected"),
    [
        ("F1", 0, [[9, 0, 0, 0], [0, 5, 0, 0], [0, 0, 6, 0], [0, 0, 0, 4]]),  # at least one
        ("F1", 50, [[9, 1, 0, 0], [0, 5, 1, 0], [0, 0, 6, -6], [0, 0, 3, 4]]),  # zeros don't count as kept
        ("F1", 100, SMALL),
        ("F2", 0, SMALL),
        ("F2", 50, [[9, 0, -8, 0], [0, 5, 0, 4], [3, 0, 6, -6], [0, 2, 3, 4]]),  # 3 of 6, 2 of 4: just enough
        ("F2", 80, [[9, 0, -8, 0], [0, 5, 0, 4], [0, 0, 6, -6], [0, 0, 0, 4]]),
        ("F3", 0, SMALL),
        ("F3", 80, [[9, 0, -8, 0], [0, 5, 0, 4], [0, 0, 6, -6], [0, 0, 0, 4]]),  # F2 drops 35, F1 89 and more
    ],
)
def test_literal_matrices(kind, strength, expected):
    np.testing.assert_array_equal(np.where(Filter(kind, strength).mask(SMALL), SMALL, 0), expected)


def naive(kind: str, strength: float, row: list[float], diagonal: int, count: int | None = None) -> list[bool]:
    """One row by sorting and comparing, entry by entry."""
    present = [j for j, value in enumerate(row) if value]
    if kind == "F1":
        count = max(1, round(len(row) * strength / 100)) if count is None else count
        chosen = sorted(present, key=lambda j: (abs(j - diagonal), j))[:count]
    else:
        largest = max(abs(value) for value in row)
        chosen = [j for j in present if 100 * abs(row[j]) >= strength * largest]
    return [j in chosen for j in range(len(row))]


def check(chosen: Filter, matrix: np.ndarray, mask: np.ndarray) -> None:
    """Raise ``AssertionError`` unless ``mask`` is what loops over the definition find."""
    rows = matrix.tolist()
    f2 = np.array([naive("F2", chosen.strength, row, i) for i, row in enumerate(rows)])
    if chosen.kind == "F1":
        expected = np.array([naive("F1", chosen.strength, row, i) for i, row in enumerate(rows)])
    elif chosen.kind == "F2":
        expected = f2
    else:
        whole, extra = divmod(int(f2.sum()), len(rows))
        counts = [whole + (i >= len(rows) - extra) for i in range(len(rows))]
        f1 = np.array([naive("F1", 0, row, i, count) for i, (row, count) in enumerate(zip(rows, counts, strict=True))])
        lost = [float((matrix[~m] ** 2).sum()) for m in (f1, f2)]
        expected = f1 if lost[0] < lost[1] else f2
        assert error(matrix, mask) <= min(np.sqrt(lost)) * (1 + 1e-12)
    np.testing.assert_array_equal(mask, expected)


def random_matrices():
    rng = np.random.default_rng(4)
    for size in (1, 2, 5, 8):
        for _ in range(10):
            scale = 10.0 ** rng.uniform(-3, 0, size=(size, 1))
            matrix = scale * rng.normal(size=(size, size)) * (rng.random((size, size)) < 0.8)
            yield matrix + np.eye(size) * (np.abs(matrix).sum(axis=1) == 0)


def test_equals_loops_and_f3_is_never_worse():
    taken = set()
    for matrix in random_matrices():
        for strength in (0, 3, 20, 45, 70, 100):
            for kind in ("F1", "F2", "F3"):
                chosen = Filter(kind, strength)
                check(chosen, matrix, chosen.mask(matrix))
            taken.add(bool((Filter("F3", strength).mask(matrix) == Filter("F2", strength).mask(matrix)).all()))
    assert taken == {True, False}  # F3 took either side


@pytest.mark.parametrize("chosen", [Filter("F1", 100), Filter("F2", 0), Filter("F3", 0)])
def test_the_weakest_filter_changes_no_bit(chosen):
    sensor = SENSORS["5×7, 3×3 mm, h 2 mm"]
    stress = frames(sensor, random_contacts(sensor, 40, np.random.default_rng(1)))
    plain = Tfra(sensor)(stress, keep_sweep=True)
    same = Tfra(sensor, ops=filtered(operators(sensor), chosen))(stress, keep_sweep=True)
    for field in fields(plain):
        if field.name != "sweep":
            np.testing.assert_array_equal(getattr(same, field.name), getattr(plain, field.name))
    np.testing.assert_array_equal(same.sweep.b_z, plain.sweep.b_z)
    np.testing.assert_array_equal(same.sweep.b_xy, plain.sweep.b_xy)


def test_mirrors_survive_f2_but_not_f1():
    """Mirror taxels have coefficients of one size, so F2 treats them alike; a band in row-major order doesn't."""
    sensor = SENSORS["5×7, 3×3 mm, h 2 mm"]

    def mirrored(ops: Operators) -> bool:
        grids = [np.abs(m).reshape(5, 7, 5, 7) > 0 for m in vars(ops).values()]
        return all(np.array_equal(np.flip(g, axes), g) for g in grids for axes in ((0, 2), (1, 3)))

    for strength in (0.5, 2, 10, 50, 100):
        assert mirrored(filtered(operators(sensor), Filter("F2", strength)))
    for strength in (10, 20, 40, 80):
        assert not mirrored(filtered(operators(sensor), Filter("F1", strength)))


def test_multiplications_by_hand():
    """10x10: seven dense matrices of 10,000, C33 A3-dagger twice; forces straight ahead add nothing to C31 and C32."""
    full = operators(SENSORS["10×10, 4×2 mm, h 3 mm"])
    assert multiplications(full) == 7 * 10_000 + 2 * 10_000 - 2 * 1_000
    diagonal = kept(filtered(full, Filter("F1", 1)))
    assert diagonal == dict.fromkeys(vars(full), 100) | {"normal": 100}


def test_filtered_leaves_the_original_alone_and_is_read_only():
    full = operators(SENSORS["4×6, 5×3 mm, h 2 mm"])
    before = {name: matrix.copy() for name, matrix in vars(full).items()}
    sparse = filtered(full, Filter("F2", 10))
    for name, matrix in vars(full).items():
        np.testing.assert_array_equal(matrix, before[name])
        new = getattr(sparse, name)
        assert not new.flags.writeable
        assert set(new[new != 0]) <= set(matrix[matrix != 0])


@pytest.mark.parametrize(
    ("kind", "strength", "message"),
    [
        ("F4", 10, r"^kind: one of F1, F2, F3 is needed, got 'F4'"),
        ("F1", -1, r"^strength: 0 to 100 % is needed, got -1"),
        ("F3", float("nan"), r"^strength: 0 to 100 % is needed, got nan"),
    ],
)
def test_unusable_filters_are_refused(kind, strength, message):
    with pytest.raises(ValueError, match=message):
        Filter(kind, strength)


def test_the_bit_accurate_model_takes_the_same_operators() -> None:
    sensor = SensorArray(4, 6, 5e-3, 3e-3, 2e-3)
    chosen = Filter("F2", 2)
    dense = TfraDesign(sensor, architecture=Architecture(4))
    sparse = SparseDesign(sensor, architecture=Architecture(4), sparse=chosen)
    codes = contact_codes(sparse, 200, seed=4)
    found = decode(sparse, FixedTfra(sparse)(codes).words)
    exact = Tfra(sensor, ops=filtered(operators(sensor), chosen))(codes * sparse.adc.lsb)
    swept = exact.status == 0
    assert (found.sweep_index == exact.sweep_index)[swept].mean() > 0.97
    assert sparse.nonzero_products < 0.8 * dense.nonzero_products
    other = decode(dense, FixedTfra(dense)(codes).words)
    assert (other.sweep_index != exact.sweep_index)[swept].mean() > 0.1  # the filter is not without effect


def test_a_design_takes_no_filter_that_breaks_the_mirrors() -> None:
    with pytest.raises(ValueError, match="sparse: only F2 keeps the mirror symmetry"):
        SparseDesign(SensorArray(4, 6, 5e-3, 3e-3, 2e-3), architecture=Architecture(4), sparse=Filter("F1", 50))
