"""Results of a search in sentences, from tables whose numbers are literal."""

import polars as pl
import pytest

from tests.study.report.search_tables import FORCE, PHI, baseline, designs, trials
from tfra.study.report.results import cheapest_trials, costs_of, errors_of, smallest_design


def plain(text: str) -> str:
    return text.replace("\N{NO-BREAK SPACE}", " ")


@pytest.mark.parametrize(
    ("kbit", "end"),
    [
        (
            {"uniform": 265.4, "mixed": 199.2},
            "within 5 % of float's total: `mixed` (199 kbit of coefficients, "
            "25 % less than the best uniform one, `uniform`).",
        ),
        ({"uniform": 199.2, "mixed": 265.4}, "within 5 % of float's total: `uniform` (199 kbit of coefficients)."),
        ({"mixed": 199.2, "tiny": -90.0}, "within 5 % of float's total: `mixed` (199 kbit of coefficients)."),
        (
            {"uniform": -100.0, "mixed": 110.0},
            "within 5 % of float's total: `mixed` (110 kbit of coefficients, "
            "10 % more than the best uniform one, `uniform`).",
        ),
    ],
)
def test_the_smallest_design(kbit: dict[str, float], end: str) -> None:
    assert plain(smallest_design({"designs": designs(**kbit)})) == f"The smallest design {end}"


def test_no_design_is_small_and_good() -> None:
    bad = smallest_design({"designs": designs(mixed=-100.0)})
    assert plain(bad) == "No design of the table is within 5 % of float's total."
    assert smallest_design({"designs": designs()}) == ""
    unknown = designs(mixed=1.0).with_columns(within=pl.lit(None))
    assert smallest_design({"designs": unknown}) == ""
    assert smallest_design({}) == ""


def test_columns_by_their_names() -> None:
    assert errors_of(trials()) == [FORCE, PHI] == errors_of(designs(mixed=1.0))
    assert costs_of(trials()) == ["coefficient_kbit", "LUT"]


def test_the_cheapest_within_the_tolerance() -> None:
    """Trial 1 has 4 % more error than float in F and none in phi; trial 2 has 10 % more in phi."""
    tables = {"trials": trials(), "baseline": baseline(), "designs": designs(mixed=1.0)}
    assert {cost: plain(text) for cost, text in cheapest_trials(tables).items()} == {
        "coefficient_kbit": "Cheapest within 5 % of float's errors: 120 kbit of coefficients (trial 1 of 5); "
        "by random choice: 160 kbit of coefficients (trial 1 of 3).",
        "LUT": "Cheapest within 5 % of float's errors: 10,000 LUT (trial 1 of 5); "
        "by random choice: 12,000 LUT (trial 1 of 3).",
    }
    for few in (baseline().head(1), trials([])):
        assert cheapest_trials(tables | {"baseline": few})["LUT"].endswith("; by random choice: none of 1 trials.")
    del tables["baseline"]
    assert plain(cheapest_trials(tables)["LUT"]) == "Cheapest within 5 % of float's errors: 10,000 LUT (trial 1 of 5)."
