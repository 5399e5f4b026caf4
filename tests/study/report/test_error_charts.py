"""Charts of variations, from tables whose numbers are literal."""

from typing import Any

import polars as pl

from tfra.study.report import error_charts

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
