"""Tables against NumPy and formulas by hand, on rows that were made up."""

import math
from itertools import product

import numpy as np
import polars as pl
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.study.definitions import definition, design
from tfra.model.tfra import OF_CORES, Status
from tfra.study.errors.cascade import DECISIONS, SIGNED, Cascade, Step, View, decision_column, error_column
from tfra.study.errors.statistics import errors, flagged, flips, unflagged
from tfra.study.frames.block import Part


def made_up(count: int, seed: int = 0) -> pl.DataFrame:
    """Rows of frames that nothing is wrong with."""
    rng = np.random.default_rng(seed)
    columns = {"frame": np.arange(count) + 1000}
    for (key, signed), step, view in product(SIGNED.items(), Step, View):
        values = rng.normal(size=count) ** 3 if signed else rng.exponential(size=count)
        columns[error_column(key, step, view)] = values.astype("f4")
    for (key, kind), step in product(DECISIONS.items(), Step):
        columns[decision_column(key, step)] = np.zeros(count, dtype=bool if kind is pl.Boolean else np.int16)
    return pl.DataFrame(columns)


def changed(scores: pl.DataFrame, column: str, values: dict[int, object]) -> pl.DataFrame:
    """The same with some values of a column replaced."""
    new = scores[column].to_list()
    for row, value in values.items():
        new[row] = value
    return scores.with_columns(pl.Series(column, new, dtype=scores[column].dtype))


def row(table: pl.DataFrame, **where: str) -> dict[str, object]:
    (found,) = table.filter(pl.all_horizontal(*(pl.col(key) == value for key, value in where.items()))).rows(named=True)
    return found


def test_a_row_each_quantity_step_and_view():
    table = errors(made_up(30))
    assert table.select("quantity", "step", "view").rows() == [(q, s, v) for q in SIGNED for s in Step for v in View]
    assert all(name == "mu" or name.endswith(("_deg", "_n", "_force", "_forces")) for name in SIGNED)


@settings(max_examples=8, deadline=None)
@given(st.integers(20, 400), st.integers(0, 5))
def test_quantiles_are_those_of_all_blocks_together(count, seed):
    blocks = [made_up(count, seed), made_up(11, seed + 1), made_up(count, seed + 2)]
    table = errors(pl.concat(blocks))
    for quantity, signed in SIGNED.items():
        found = row(table, quantity=quantity, step="noise", view="own")
        values = np.concatenate([each[error_column(quantity, Step.NOISE, View.OWN)].to_numpy() for each in blocks])
        values = values.astype(np.float64)
        assert found["count"] == 2 * count + 11
        assert found["median"] == np.median(np.abs(values))
        if 2 * count + 11 >= 200:
            assert found["p95"] == np.quantile(np.abs(values), 0.95)
        assert found["worst"] == np.abs(values).max()
        assert found["bias"] == (pytest.approx(math.fsum(values) / len(values), rel=1e-9) if signed else None)


@pytest.mark.parametrize(("count", "known"), [(19, 0), (20, 1), (199, 1), (200, 2), (9_999, 2), (10_000, 3)])
def test_a_percentile_without_ten_frames_beyond_it_is_null(count, known):
    names = ["median", "p95", "p99_9"]
    for found in errors(made_up(count)).rows(named=True):
        assert [key for key in names if found[key] is not None] == names[:known]


@pytest.mark.parametrize(("count", "name", "share"), [(20, "median", 0.5), (417, "median", 0.5), (200, "p95", 0.95)])
def test_intervals_hold_the_percentile_with_their_confidence(count, name, share):
    """By the binomial formula: the number of values below a percentile lies between the ranks of the ends."""
    scores = made_up(count)
    found = row(errors(scores), quantity="mu", step="noise", view="own")
    values = np.sort(np.abs(scores[error_column("mu", Step.NOISE, View.OWN)].to_numpy().astype(np.float64))).tolist()
    low, high = (values.index(found[f"{name}_{end}"]) for end in ("low", "high"))

    def chance(first: int, last: int) -> float:
        counts = range(first, last + 1)
        return math.fsum(math.comb(count, k) * share**k * (1 - share) ** (count - k) for k in counts)

    assert low < count * share < high
    assert chance(low + 1, high) >= 0.95
    assert chance(0, low) <= 0.025
    assert chance(high + 1, count) <= 0.025
    assert chance(0, low + 1) > 0.025  # no shorter one does
    assert chance(high, count) > 0.025


def test_unknown_values_are_not_counted():
    column = error_column("phi_deg", Step.METHOD, View.TOTAL)
    scores = changed(made_up(50), column, dict.fromkeys(range(10), math.nan))
    found = row(errors(scores), quantity="phi_deg", step="method", view="total")
    values = scores[column].to_numpy()[10:].astype(np.float64)
    assert found["count"] == 40
    assert found["median"] == np.median(np.abs(values))
    assert found["worst_frame"] == 1010 + np.abs(values).argmax()
    nothing = row(errors(scores.head(10)), quantity="phi_deg", step="method", view="total")
    assert [value for key, value in nothing.items() if key not in ("quantity", "step", "view")] == [0, *[None] * 12]


def test_frames_that_one_step_flags_are_left_out_of_all():
    scores = changed(made_up(60), decision_column("status", Step.NOISE), {3: Status.COMPRESSION_ONLY.value})
    scores = changed(scores, decision_column("status", Step.ARITHMETIC), {4: 1, 5: 16 | 32, 6: 32, 7: 64})
    assert [i for i, good in enumerate(unflagged(scores)) if not good] == [3, 4, 5]
    assert set(errors(scores)["count"]) == {57}
    rest = scores.filter(~pl.col("frame").is_in([1003, 1004, 1005]))
    assert errors(scores).equals(errors(rest))
    counts = {(r["step"], r["status"]): r["frames"] for r in flagged(scores).rows(named=True) if r["frames"]}
    assert counts == {
        ("noise", "compression_only"): 1,
        ("arithmetic", "no_contact"): 1,
        ("arithmetic", "dependent_out_of_range"): 1,
        ("arithmetic", "input_saturated"): 2,
        ("arithmetic", "output_saturated"): 1,
        ("any", "left_out"): 3,
    }
    assert set(flagged(scores)["of"]) == {60}
    assert len(flagged(scores)) == len(Step) * len(OF_CORES) + 1


def test_flips_are_counted_where_they_can_be_compared():
    scores = changed(made_up(100), decision_column("quadrant", Step.CONVERTER), {0: 1, 1: 3})
    scores = changed(scores, decision_column("sweep_y", Step.CONVERTER), {1: True, 2: True})
    scores = changed(scores, decision_column("negative", Step.CONVERTER), {3: True})
    scores = changed(scores, decision_column("sweep_index", Step.CONVERTER), {1: 90, 3: 90, 4: 1, 5: -1, 6: 2, 7: 50})
    scores = changed(scores, decision_column("status", Step.CONVERTER), {8: 32, 9: 2})
    table = flips(scores)
    assert table["step"].unique(maintain_order=True).to_list() == ["noise", "converter", "arithmetic"]
    counts = {r["decision"]: (r["frames"], r["of"]) for r in table.filter(step="converter").rows(named=True)}
    assert counts == {
        "status": (1, 100),
        "quadrant": (2, 99),
        "swept_variable": (2, 99),
        "sweep_index_equal": (92, 96),
        "sweep_index_off_by_one": (2, 96),
        "sweep_index_off_by_more": (2, 96),
    }
    assert set(table.filter(step="noise", decision="quadrant")["frames"]) == {0}
    assert row(table, step="arithmetic", decision="sweep_index_off_by_more")["frames"] == 2  # and back again


@pytest.mark.parametrize("count", [0, 1, 7, 100])
def test_intervals_are_wilsons(count):
    scores = changed(made_up(100), decision_column("quadrant", Step.NOISE), dict.fromkeys(range(count), 2))
    found = row(flips(scores), step="noise", decision="quadrant")
    z, n, p = 1.959963984540054, 100, count / 100
    middle, half = p + z * z / (2 * n), z * math.sqrt(p * (1 - p) / n + z * z / (4 * n * n))
    assert found["rate"] == p
    assert found["rate_low"] == pytest.approx(max(0, (middle - half) / (1 + z * z / n)), abs=1e-12)
    assert found["rate_high"] == pytest.approx(min(1, (middle + half) / (1 + z * z / n)), abs=1e-12)


def test_no_frames_have_no_rate():
    scores = made_up(5).with_columns(pl.lit(1, dtype=pl.Int16).alias(decision_column("status", Step.METHOD)))
    found = row(flips(scores), step="noise", decision="quadrant")
    assert (found["frames"], found["of"], found["rate"], found["rate_low"]) == (0, 0, None, None)
    assert row(flips(scores), step="noise", decision="status")["rate"] == 1
    assert set(errors(scores)["count"]) == {0}


def test_tables_of_a_cascade_are_whole():
    """Real rows: the method is what errs most."""
    scores = Cascade(definition(train=600).make(Part.TRAIN, 0))(design())
    table = errors(scores)
    assert table.schema == errors(made_up(1)).schema
    size = {step: row(table, quantity="force_difference_percent_of_true_force", step=step, view="own") for step in Step}
    assert size["method"]["median"] > size["converter"]["median"] > size["arithmetic"]["median"] > 0
    left_out = row(flagged(scores), step="any", status="left_out")["frames"]
    assert 0 < left_out < 600
    assert row(table, quantity="mu", step="method", view="total")["count"] == 600 - left_out
