"""Charts, and labels of columns and costs, from tables whose numbers are literal."""

from typing import Any

import polars as pl
import pytest

from tests.study.report.search_tables import baseline, designs, trials
from tfra.study.report import error_charts, trial_charts
from tfra.study.report.labels import column_label, cost_amount
from tfra.study.search.evaluate import CHANGE

SETTINGS: list[dict[str, Any]] = [
    {"variant": "steps", "steps": 50, "plateau_tolerance_lsb": 0.0, "rounding": "half_up"},
    {"variant": "steps", "steps": 100, "plateau_tolerance_lsb": 0.0, "rounding": "half_up"},
    {"variant": "plateau_tolerance", "steps": 100, "plateau_tolerance_lsb": 0.5, "rounding": "half_up"},
    {"variant": "rounding", "steps": 100, "plateau_tolerance_lsb": 0.0, "rounding": "half_even"},
]


def variants() -> pl.DataFrame:
    """Errors of mu; the first does not fit."""
    known = {"count": 300, "median": 0.1, "p95": 0.3, "p99_9": None, "worst": 0.5, "reason": None}
    reason = dict.fromkeys(known) | {"reason": "words could overflow"}
    of = {"quantity": "mu", "step": "arithmetic"}
    rows = [
        row | of | {"view": view} | (known if n else reason)
        for n, row in enumerate(SETTINGS)
        for view in ("own", "total")
    ]
    return pl.DataFrame(rows, infer_schema_length=None)


def test_variants_name_their_changes_and_which_do_not_fit() -> None:
    tables = {"variants": variants()}
    chart = error_charts.variants(tables, "mu", "total")
    named = {trace.name: trace for trace in chart.data}
    cross, dots, labels = named["does not fit"], named["total"], chart.layout.yaxis.ticktext
    assert [labels[int(place)] for place in cross.y] == ["50"]
    assert cross.hovertext[0].endswith("; reason: words could<br>overflow")
    assert [labels[int(place)] for place in dots.y] == ["100", "0.5", "half even"]
    assert dots.x == (0.1, 0.1, 0.1)
    assert dots.hovertext[1].replace("<br>", " ") == (
        "<b>total</b> variant: plateau_tolerance; steps: 100; plateau tolerance / LSB: 0.5; rounding: half_up; "
        "quantity: μ; step: arithmetic; view: total; count: 300; median: 0.1; 95th percentile: 0.3; worst: 0.5"
    )


def tables() -> dict[str, pl.DataFrame]:
    return {"trials": trials(), "baseline": baseline(), "designs": designs(uniform=140.0, mixed=110.0)}


def series(tables: dict[str, pl.DataFrame], cost: str) -> dict[str, Any]:
    return {trace.name: trace for trace in trial_charts.trials(tables, cost).data}


def test_lines_are_the_least_error_that_a_cost_buys() -> None:
    found = series(tables(), "coefficient_kbit")
    least, random = found["least error"], found["least error, random choice"]
    assert (least.x, least.y) == ((80, 120, 180, 180), (50, 4, 0, 0))
    assert (random.x, random.y) == ((100, 160, 180), (20, 2, 2))
    assert random.line.dash == "dash"
    assert (least.line.shape, random.line.shape) == ("hv", "hv")
    assert random.hovertext[0].startswith("<b>least error, random choice</b><br>number: 0;")
    assert "coefficient: 10; " in random.hovertext[0]
    assert found["trials"].x == (140,)
    assert found["Pareto front"].x == (80, 120, 180)


def test_placed_designs_stand_at_their_estimate_with_a_line_to_the_measured() -> None:
    found = series(tables(), "LUT")
    star, square = found["designs placed and routed"], found["designs"]
    assert (star.x, star.y, star.text, star.marker.symbol) == ((10_500,), (1.0,), ("mixed",), "star-open")
    assert (square.x, square.text) == ((10_500,), ("uniform",))
    assert (star.error_x.array, star.error_x.arrayminus) == ((2_000,), (0,))
    assert " LUT, placed: 12,500; " in star.hovertext[0].replace("<br>", " ")
    assert series(tables(), "coefficient_kbit")["designs placed and routed"].error_x.array == (0,)


def test_synthesised_designs_have_their_own_mark() -> None:
    table = designs(uniform=200.0, mixed=150.0).with_columns(
        part=pl.lit("ecp5-45"), synthesised_LUT=pl.when(pl.col("name") == "uniform").then(9_500.0)
    )
    found = series(tables() | {"designs": table}, "LUT")
    diamond = found["designs synthesised"]
    assert (diamond.text, diamond.marker.symbol) == (("uniform",), "diamond-open")
    assert (diamond.error_x.array, diamond.error_x.arrayminus) == ((0,), (1_000,))
    assert found["designs placed and routed"].text == ("mixed",)


def test_what_is_missing_is_not_drawn() -> None:
    alone = series({"trials": trials()}, "LUT")
    assert set(alone) == {"least error", "trials", "Pareto front"}
    without = {"trials": trials(), "designs": designs(mixed=1.0).drop(CHANGE)}
    assert set(series(without, "LUT")) == set(alone)
    none = {"trials": trials([]), "designs": designs()}
    assert "no trial is complete" in [note.text for note in trial_charts.trials(none, "LUT").layout.annotations]


@pytest.mark.parametrize(
    ("cost", "value", "text"),
    [
        ("coefficient_kbit", 48.24, "48.2 kbit of coefficients"),
        ("coefficient_kbit", 1048.24, "1,048 kbit of coefficients"),
        ("latency_cycles", 0.0, "0 cycles of latency"),
    ],
)
def test_costs(cost: str, value: float, text: str) -> None:
    assert cost_amount(cost, value).replace("\N{NO-BREAK SPACE}", " ") == text


@pytest.mark.parametrize(
    ("column", "label"),
    [
        ("phi_deg", "95th percentile of the error of φ / °"),
        ("mu_held_out", "95th percentile of the error of μ, held-out frames"),
        ("total_change_percent_held_out", "growth of the total error over float’s / %, held-out frames"),
        ("placed_BRAM", "BRAM, placed"),
        ("sqnr_db", "SQNR / dB"),
        ("some_words", "some words"),
    ],
)
def test_columns(column: str, label: str) -> None:
    assert column_label(column) == label
