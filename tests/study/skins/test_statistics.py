"""Tables of contacts: which are in which group, what the rates are of, and whose errors count."""

import math

import numpy as np
import polars as pl
import pytest

from tfra.study.errors.cascade import Step, View, error_column
from tfra.study.skins.cascade import SIGNED
from tfra.study.skins.statistics import by_group, errors, finding, groups, marked

COUNT = [1, 2, 2, 3, 3, 3]
GAP = [math.inf, 0.5, 0.5, 2.0, 2.0, 7.0]


@pytest.fixture
def scores() -> pl.DataFrame:
    """Six contacts of three frames: the third is missed at all steps, the fifth at the last one and is merged."""
    lost = [0, 0, 1, 0, 0, 0]
    columns: dict[str, object] = {"frame": [4, 5, 5, 6, 6, 6], "contacts": COUNT, "gap_pitches": GAP}
    for step in Step:
        last = step is Step.ARITHMETIC
        missed = np.array(lost) + np.array([0, 0, 0, 0, last, 0])
        columns |= {
            f"missed.{step}": missed > 0,
            f"merged.{step}": np.array([0, 0, 0, 0, last, 0]) > 0,
            f"status.{step}": [0, 256, 0, 1024, 0, 256],
            f"seen.{step}": [2, 1, 0, 3 - last, 0, 0],
            f"invented.{step}": [1, 0, 0, 0, 0, 0],
        }
        for view in View:
            for key in SIGNED:
                columns[error_column(key, step, view)] = [1.0, -2.0, math.nan, 3.0, math.nan, 10.0]
    return pl.DataFrame(columns)


def test_groups_are_by_number_and_by_gap(scores: pl.DataFrame) -> None:
    found = [(split, name, len(rows)) for split, name, rows in groups(scores)]
    assert found == [
        ("all", "all", 6),
        ("contacts", "1", 1),
        ("contacts", "2", 2),
        ("contacts", "3–4", 3),
        ("gap", "0–1", 2),
        ("gap", "2–3", 2),
        ("gap", "4 or more", 1),
        ("gap", "alone", 1),
    ]


def test_rates_are_of_those_there_and_of_those_found(scores: pl.DataFrame) -> None:
    table = finding(scores)

    def row(group: str, step: Step, kind: str) -> tuple[int, int]:
        ((count, of),) = table.filter(group=group, step=step, kind=kind).select("count", "of").rows()
        return count, of

    assert row("all", Step.METHOD, "missed") == (1, 6)
    assert row("all", Step.ARITHMETIC, "missed") == (2, 6)
    assert row("all", Step.ARITHMETIC, "merged") == (1, 6)
    assert row("all", Step.METHOD, "invented") == (1, 6)
    assert row("all", Step.ARITHMETIC, "invented") == (1, 5)
    assert row("1", Step.METHOD, "invented") == (1, 2)
    assert row("3–4", Step.METHOD, "invented") == (0, 3)
    assert row("0–1", Step.METHOD, "missed") == (1, 2)
    assert not len(table.filter(split="gap", kind="invented"))
    half = table.filter(group="0–1", step=Step.METHOD, kind="missed").row(0, named=True)
    z = 1.959963984540054  # Wilson's interval of one of two is symmetric
    width = z * math.sqrt(0.25 / 2 + z * z / 16) / (1 + z * z / 2)
    assert (half["rate_low"], half["rate_high"]) == pytest.approx((0.5 - width, 0.5 + width))


def test_errors_are_those_of_known_contacts(scores: pl.DataFrame) -> None:
    row = errors(scores).filter(quantity="mu", step=Step.NOISE, view=View.OWN).row(0, named=True)
    assert (row["count"], row["worst"], row["worst_frame"], row["bias"]) == (4, 10.0, 6, 3.0)
    assert row["median"] is None  # too few
    split = by_group(scores).filter(quantity="mu", step=Step.NOISE, view=View.OWN)
    assert dict(split.select("group", "worst").iter_rows()) == {
        "1": 1.0, "2": 2.0, "3–4": 10.0, "0–1": 2.0, "2–3": 3.0, "4 or more": 10.0, "alone": 1.0,
    }  # fmt: skip


def test_marks_are_those_of_contacts_found(scores: pl.DataFrame) -> None:
    rows = marked(scores).filter(step=Step.ARITHMETIC).select("status", "contacts", "of").rows()
    assert rows == [("edge", 2, 4), ("touching", 1, 4)]
