"""The chart of trials, from tables whose numbers are literal."""

from typing import Any

import polars as pl

from tests.study.report.search_tables import baseline, designs, trials
from tfra.study.report.trial_charts import trials as chart
from tfra.study.search.evaluate import CHANGE


def tables() -> dict[str, pl.DataFrame]:
    return {"trials": trials(), "baseline": baseline(), "designs": designs(uniform=140.0, mixed=110.0)}


def series(tables: dict[str, pl.DataFrame], cost: str) -> dict[str, Any]:
    return {trace.name: trace for trace in chart(tables, cost).data}


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


def test_what_is_missing_is_not_drawn() -> None:
    alone = series({"trials": trials()}, "LUT")
    assert set(alone) == {"least error", "trials", "Pareto front"}
    without = {"trials": trials(), "designs": designs(mixed=1.0).drop(CHANGE)}
    assert set(series(without, "LUT")) == set(alone)
    none = {"trials": trials([]), "designs": designs()}
    assert "no trial is complete" in [note.text for note in chart(none, "LUT").layout.annotations]
