"""A function for each chart of errors and ranges: from tables to a figure, whose numbers are those of the tables.

Arithmetic alone is blue, totals are vermilion; series that differ in colour also differ in shape or dash.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import plotly.graph_objects as go
import polars as pl

from tfra.report.colours import BLACK, BLUE, GREEN, ORANGE, PURPLE, VERMILION
from tfra.study.errors.cascade import Step, View
from tfra.study.report.figure import GREY, PALE, ROW, Dot, Rows, Scale, add_dots, add_unfit, figure, say, wrapped
from tfra.study.report.words import (
    QUANTITIES,
    STATISTICS,
    STEPS,
    VARIANTS,
    Tables,
    amount,
    listed,
    number,
    setting,
    trained,
)

VIEWS = {View.OWN: ("its own share", BLUE, "circle"), View.TOTAL: ("total", VERMILION, "diamond")}

FLIPS = {
    "status": "status flags",
    "quadrant": "quadrant of φ",
    "swept_variable": "swept variable",
    "sweep_index_off_by_one": "index off by one",
    "sweep_index_off_by_more": "index off by more",
}
"""Decisions whose rate is that of a change, and their labels."""


def cascade(tables: Tables, quantity: str, part: str) -> go.Figure:
    """Median and 95th percentile of each step's own share and of the total after it."""
    rows = tables["errors"].filter(pl.col("quantity") == quantity, pl.col("part") == part)
    order = {str(step): place for place, step in enumerate(Step)}
    labels = tuple(STEPS[step] for step in Step)
    return _spread(rows, [order[step] for step in rows["step"]], Rows(labels, tuple(order.values())), quantity, 62)


def variants(tables: Tables, quantity: str, view: str) -> go.Figure:
    """One view of the arithmetic's errors, for each variant of the design."""
    wanted = pl.col("quantity") == quantity, pl.col("step") == Step.ARITHMETIC, pl.col("view") == view
    rows = tables["variants"].filter(*wanted)
    settings = [(row["variant"], row[VARIANTS[row["variant"]][0]]) for row in rows.iter_rows(named=True)]
    named = list(dict.fromkeys(settings))
    lines = Rows.of([VARIANTS[variant][1] for variant, _ in named], [setting(value) for _, value in named])
    places = dict(zip(named, lines.places, strict=True))
    return _spread(rows, [places[key] for key in settings], lines, quantity, 24)


def _spread(rows: pl.DataFrame, places: list[int], lines: Rows, quantity: str, height: int) -> go.Figure:
    """The errors of every row, at its place; where there are both views, beside each other."""
    kind, scale = QUANTITIES[quantity], Scale.of([*rows["median"], *rows["p95"]])
    shown = figure(
        len(lines.labels) * height + 95,
        scale.axis(f"error of {kind.axis}"),
        lines.axis(),
    )
    views = [view for view in VIEWS if view in set(rows["view"])]
    for view, offset in zip(views, (-0.15, 0.15) if len(views) > 1 else (0.0,), strict=True):
        name, colour, symbol = VIEWS[view]
        dots = [
            Dot(
                place + offset,
                row["median"],
                row["median"],
                row["p95"] or row["median"],
                _error_text(row, name, *_variant(row)),
            )
            for place, row in zip(places, rows.iter_rows(named=True), strict=True)
            if row["view"] == view and row["median"] is not None
        ]
        add_dots(shown, scale, name, colour, symbol, dots)
    unfit = [(place, row) for place, row in zip(places, rows.iter_rows(named=True), strict=True) if _is_unfit(row)]
    add_unfit(shown, [(scale.low, place, _unfit_text(row)) for place, row in unfit])
    return shown if rows["median"].count() else say(shown, "too few frames")


def _variant(row: dict[str, Any]) -> list[str]:
    """What was changed, of a row of variants."""
    if "variant" not in row:
        return []
    column, label = VARIANTS[row["variant"]]
    return [f"{label}: {setting(row[column])}"]


def _is_unfit(row: dict[str, Any]) -> bool:
    """Whether a variation has no numbers, since its choices do not fit together."""
    return row.get("reason") is not None


def _unfit_text(row: dict[str, Any]) -> str:
    return f"<b>does not fit</b><br>{wrapped(row['reason'])}"


def _error_text(row: dict[str, Any], *lines: str) -> str:
    kind = QUANTITIES[row["quantity"]]
    amounts = {"median": "median", "p95": "95th percentile", "p99_9": "99.9th percentile", "worst": "worst"}
    shown = [f"{name}: {kind.amount(row[key], 3)}" for key, name in amounts.items() if row.get(key) is not None]
    heading = f"<b>{STEPS[row['step']]}, {lines[0]}</b>"
    return "<br>".join([heading, *shown, f"{row['count']:,} frames", *lines[1:]])


def flips(tables: Tables, part: str) -> go.Figure:
    """How often each step's decision differs from that of the step before, with its interval."""
    known = pl.col("part") == part, pl.col("rate").is_not_null(), pl.col("decision").is_in(list(FLIPS))
    rows = tables["flips"].filter(*known)
    scale = Scale.of([100 * rate for name in ("rate", "rate_low", "rate_high") for rate in rows[name]])
    lines = Rows(tuple(FLIPS.values()), tuple(range(len(FLIPS))))
    shown = figure(
        len(FLIPS) * 54 + 95,
        scale.axis("frames that flip / %"),
        lines.axis(),
    )
    series = {Step.NOISE: (PURPLE, "square"), Step.CONVERTER: (GREEN, "diamond"), Step.ARITHMETIC: (BLUE, "circle")}
    order = list(FLIPS)
    for n, (step, (colour, symbol)) in enumerate(series.items()):
        dots = []
        for row in rows.filter(pl.col("step") == step).iter_rows(named=True):
            rate, low, high = (100 * row[name] for name in ("rate", "rate_low", "rate_high"))
            dots.append(Dot(order.index(row["decision"]) + 0.24 * (n - 1), rate, low, high, _flip_text(row)))
        add_dots(shown, scale, STEPS[step], colour, symbol, dots)
    return shown if len(rows) else say(shown, "no frames to compare")


def _flip_text(row: dict[str, Any]) -> str:
    low, rate, high = (number(100 * row[name]) for name in ("rate_low", "rate", "rate_high"))
    return (
        f"<b>{FLIPS[row['decision']]}, {STEPS[row['step']]}</b><br>{row['frames']:,} of {row['of']:,} frames: {rate} %"
        f"<br>95 % confidence: {low} to {high} %"
    )


def ranges(tables: Tables) -> go.Figure:
    """Bits that the words seen need, in words of their length, with what the proven bound needs."""
    table = tables["ranges"]
    rows = table.to_dicts()
    lines = Rows.of([row["stage"] for row in rows], [row["signal"] for row in rows])
    bits = {
        "title": {"text": "bits"},
        "range": [0, 1.03 * max(row["bits"] for row in rows)],
        "dtick": 8,
    }
    shown = figure(
        len(lines.labels) * ROW + 95,
        bits,
        lines.axis(),
        barmode="overlay",
        bargap=0,
    )
    texts = [_range_text(row) for row in rows]
    bars = (("word", "bits", PALE, 0.86), ("needed for what was seen", "bits_needed", BLUE, 0.5))
    for name, column, colour, width in bars:
        shown.add_bar(
            x=table[column].to_list(), y=lines.places, name=name, orientation="h", width=width,
            marker={"color": colour}, hovertext=texts, hoverinfo="text",
        )  # fmt: skip
    tick = {"symbol": "line-ns-open", "size": 7, "color": BLACK, "line": {"width": 2}}
    proven = [
        (_bits_of_bound(row), place, text)
        for row, place, text in zip(rows, lines.places, texts, strict=True)
        if row["proven"]
    ]
    limited = [
        (row["bits"], place, text)
        for row, place, text in zip(rows, lines.places, texts, strict=True)
        if row["saturated"]
    ]
    star = {"symbol": "x", "size": 8, "color": VERMILION}
    for name, marks, marker in (("needed for the proven bound", proven, tick), ("some were limited", limited, star)):
        if marks:
            x, y, text = zip(*marks, strict=True)
            shown.add_scatter(x=x, y=y, mode="markers", name=name, marker=marker, hovertext=text, hoverinfo="text")
    return shown


def _bits_of_bound(row: dict[str, Any]) -> int:
    """A signed word has one more negative than positive value."""
    bound = int(row["bound"])
    return (bound - 1).bit_length() + 1 if row["signed"] else bound.bit_length()


def _range_text(row: dict[str, Any]) -> str:
    rounded = "" if row["rounded"] is None else f"<br>rounded: {100 * row['rounded'] / row['words']:.3g} %"
    sign = "signed" if row["signed"] else "unsigned"
    return (
        f"<b>{row['signal']}</b> of {row['stage']}<br>word: {row['bits']} bits, {sign}"
        f"<br>seen: {row['minimum']:,} to {row['maximum']:,}, {row['bits_needed']} bits"
        f"<br>bound: ±{row['bound']:,}{', proven' if row['proven'] else ', the format’s'}"
        f"<br>reached: {number(100 * row['share'])} % of it<br>headroom: {row['headroom_bits']} bits"
        f"{rounded}<br>limited: {row['saturated']:,} of {row['words']:,} words"
    )


def stages(tables: Tables) -> go.Figure:
    """SQNR of every signal: from the codes on, and of its stage alone."""
    table = tables["stages"]
    signals = table.select("stage", "signal").unique(maintain_order=True)
    lines = Rows.of(signals["stage"].to_list(), signals["signal"].to_list())
    place = dict(zip(signals["signal"], lines.places, strict=True))
    known = [value for value in table["sqnr_db"] if value is not None]
    low, high = (math.floor(min(known, default=0) / 10) * 10 - 5, max(known, default=0) + 12)
    axis = {"title": {"text": "signal to rounding error / dB"}, "range": [low, high]}
    shown = figure(len(lines.labels) * ROW + 95, axis, lines.axis())
    series = {
        "codes": ("from the converter codes on", VERMILION, "diamond"),
        "inputs": ("this stage alone", BLUE, "circle-open"),
    }
    for reference, (name, colour, symbol) in series.items():
        rows = table.filter(pl.col("reference") == reference, ~pl.col("exact")).to_dicts()
        shown.add_scatter(
            x=[row["sqnr_db"] for row in rows], y=[place[row["signal"]] for row in rows], mode="markers", name=name,
            marker={"color": colour, "symbol": symbol, "size": 9, "line": {"width": 2, "color": colour}},
            hovertext=[_stage_text(row, name) for row in rows], hoverinfo="text",
        )  # fmt: skip
    exact = table.filter(pl.col("exact")).group_by("signal", maintain_order=True).agg("reference")
    for signal, references in exact.iter_rows():
        text = "exact" if len(references) > 1 else "stage exact"
        shown.add_annotation(
            x=high, y=place[signal], text=text, showarrow=False, xanchor="right", font={"size": 11, "color": GREY}
        )
    return shown


def _stage_text(row: dict[str, Any], name: str) -> str:
    return (
        f"<b>{row['signal']}</b> of {row['stage']}, {name}<br>SQNR: {row['sqnr_db']:.1f} dB<br>errors in last bits: "
        f"rms {number(row['rms_error_lsb'])}, worst {number(row['max_error_lsb'])}, bias {number(row['bias_lsb'])}"
        f"<br>{row['words']:,} words"
    )


def uniform(tables: Tables, quantity: str, statistic: str) -> go.Figure:
    """Error against the bits of uniform designs, with what is left without arithmetic, and with the method alone."""
    table = tables["uniform"].filter(pl.col("quantity") == quantity, pl.col("step") == Step.ARITHMETIC).sort("bits")
    kind, name = QUANTITIES[quantity], STATISTICS[statistic]
    bits = tables["uniform"]["bits"].to_list()
    ends = [min(bits) - 0.5, max(bits) + 0.5]
    floors = _floors(tables, quantity, statistic)
    scale = Scale.of([*table[statistic], *(row[statistic] for *_, row in floors)])
    without = table.filter(pl.col("view") == View.TOTAL, pl.col("reason").is_not_null()).to_dicts()
    x = {"title": {"text": "bits of coefficients and operands"}, "range": ends, "dtick": 2}
    shown = figure(430, x, scale.axis(f"{name} of the error of {kind.axis}"))
    for view, said in ((View.OWN, "arithmetic alone"), (View.TOTAL, "total")):
        rows = table.filter(pl.col("view") == view, pl.col(statistic).is_not_null()).to_dicts()
        _, colour, symbol = VIEWS[view]
        shown.add_scatter(
            x=[row["bits"] for row in rows], y=[scale.place(row[statistic]) for row in rows], mode="lines+markers",
            name=said, line={"color": colour}, marker={"symbol": symbol, "size": 9}, hoverinfo="text",
            hovertext=[_error_text(row, said, _cost_text(row)) for row in rows],
        )  # fmt: skip
    for said, colour, dash, floor in floors:
        shown.add_scatter(
            x=ends, y=[scale.place(floor[statistic])] * 2, mode="lines", name=said,
            line={"color": colour, "dash": dash}, hovertext=_error_text(floor, "total"), hoverinfo="text",
        )  # fmt: skip
    add_unfit(shown, [(row["bits"], scale.low, _unfit_text(row)) for row in without])
    return shown if table[statistic].count() else say(shown, "too few frames")


def _floors(tables: Tables, quantity: str, statistic: str) -> list[tuple[str, str, str, dict[str, Any]]]:
    """Lower limits of the error for any word length: name, colour, dash and row of errors of each line."""
    if "errors" not in tables:
        return []
    steps = {Step.CONVERTER: ("without arithmetic", BLACK, "dash"), Step.METHOD: ("the method itself", GREEN, "dot")}
    rows = trained(tables["errors"], View.TOTAL).filter(pl.col("quantity") == quantity, pl.col(statistic).is_not_null())
    return [(*looks, row) for step, looks in steps.items() for row in rows.filter(pl.col("step") == step).to_dicts()]


def _cost_text(row: dict[str, Any]) -> str:
    costs = [amount(name, row[name]) for name in ("coefficient_kbit", "dsp")]
    return f"{row['bits']}×{row['bits']} bits: {listed(costs)}"


def converter(tables: Tables, quantity: str, statistic: str, view: str) -> go.Figure:
    """Heat map of the error after the converter, over its bits and the noise before it."""
    table = tables["converter"].filter(
        pl.col("quantity") == quantity, pl.col("step") == Step.CONVERTER, pl.col("view") == view
    )
    kind, said = QUANTITIES[quantity], VIEWS[View(view)][0]
    noises, bits = (sorted(table[name].unique()) for name in ("noise_share_of_peak", "bits"))
    by_place = {(row["noise_share_of_peak"], row["bits"]): row for row in table.iter_rows(named=True)}
    rows = [[by_place.get((noise, b), {}) for b in bits] for noise in noises]
    values = [[row.get(statistic) for row in line] for line in rows]
    scale = Scale.of([value for line in values for value in line])
    place = (lambda v: math.log10(scale.place(v))) if scale.log else (lambda v: v)
    columns, lines = [str(b) for b in bits], [f"{100 * noise:g}" for noise in noises]
    axes = _categories("bits of the converter", columns), _categories("noise / % of the peak", lines)
    shown = figure(max(3, len(noises)) * 44 + 95, *axes)
    shown.add_heatmap(
        x=columns, y=lines,
        z=[[None if v is None else place(v) for v in line] for line in values],
        text=[["" if v is None else number(v, 2) for v in line] for line in values], texttemplate="%{text}",
        hovertext=[[_cell_text(row, said) for row in line] for line in rows], hoverinfo="text",
        colorscale="Cividis", reversescale=True, showscale=False, xgap=2, ygap=2, name=f"{kind.axis}, {said}",
    )  # fmt: skip
    # On an axis of categories a place is a number.
    for y_place, line in enumerate(rows):
        for x_place, row in enumerate(line):
            if row and row[statistic] is None:
                text, place_of = "×" if _is_unfit(row) else "few", {"x": x_place, "y": y_place}
                shown.add_annotation(text=text, showarrow=False, font={"color": GREY, "size": 11}, **place_of)
    return shown


def _categories(title: str, labels: Sequence[str]) -> dict[str, Any]:
    """An axis that has all its cells even if there is nothing in them."""
    return {"title": {"text": title}, "type": "category", "ticks": "", "showgrid": False} | {
        "range": [-0.5, len(labels) - 0.5], "tickvals": list(range(len(labels))), "ticktext": list(labels),
    }  # fmt: skip


def _cell_text(row: dict[str, Any], said: str) -> str:
    if not row:
        return ""
    return (
        _unfit_text(row)
        if _is_unfit(row)
        else _error_text(row, said, f"{row['bits']}-bit converter, noise {100 * row['noise_share_of_peak']:g} %")
    )


def sensitivity(tables: Tables, quantity: str, statistic: str, view: str) -> go.Figure:
    """Change of the arithmetic's error with one bit less of each signal, the largest change on top."""
    rows = with_change(tables).filter(pl.col("quantity") == quantity, pl.col("step") == Step.ARITHMETIC)
    own = rows.filter(pl.col("view") == View.OWN, pl.col("shorter") == 1)
    names = own.sort(f"{statistic}_change", "signal", descending=[True, False], nulls_last=True)["signal"].to_list()
    place = {name: n for n, name in enumerate(names)}
    rows = rows.filter(pl.col("view") == view, pl.col("signal").is_in(names))
    axis = {"title": {"text": f"change of the {STATISTICS[statistic]} / %"}, "zeroline": True}
    lines = Rows(tuple(names), tuple(range(len(names))))
    shown = figure(len(names) * ROW + 95, axis, lines.axis(), barmode="group", bargap=0.25)
    colours = {1: VIEWS[View(view)][1], 2: ORANGE, 4: PURPLE}
    for (less,), some in rows.group_by("shorter", maintain_order=True):
        fit, unfit = (
            some.filter(known).to_dicts() for known in (pl.col("reason").is_null(), ~pl.col("reason").is_null())
        )
        group: dict[str, Any] = {"legendgroup": str(less), "visible": True if less == 1 else "legendonly"}
        shown.add_bar(
            x=[row[f"{statistic}_change"] for row in fit], y=[place[row["signal"]] for row in fit], orientation="h",
            name=f"{less} bit{'s' if less != 1 else ''} less", marker={"color": colours.get(less, GREY)},
            hovertext=[_change_text(row, view, statistic) for row in fit], hoverinfo="text", **group,
        )  # fmt: skip
        crosses = [(0.0, place[row["signal"]], f"{_length_text(row)}<br>{_unfit_text(row)}") for row in unfit]
        add_unfit(shown, crosses, showlegend=False, **group)
    return shown if rows[f"{statistic}_change"].count() else say(shown, "too few frames")


def with_change(tables: Tables) -> pl.DataFrame:
    """The table of sensitivities with ``NAME_change`` for each of ``STATISTICS``: percent of the design as it is."""
    base = tables["errors"].filter(pl.col("part") == "train").select("quantity", "step", "view", *STATISTICS)
    joined = tables["sensitivity"].join(
        base, on=["quantity", "step", "view"], how="left", suffix="_base", maintain_order="left"
    )
    known = {s: pl.when(pl.col(f"{s}_base") > 0).then(pl.col(f"{s}_base")) for s in STATISTICS}
    changes = [(100 * (pl.col(s) / base - 1)).alias(f"{s}_change") for s, base in known.items()]
    return joined.with_columns(changes).drop(f"{s}_base" for s in STATISTICS)


def _change_text(row: dict[str, Any], view: str, statistic: str) -> str:
    change, equal = row[f"{statistic}_change"], row["sweep_index_equal"]
    said = [_length_text(row), "change unknown" if change is None else f"{change:+.3g} %"]
    said += [] if equal is None else [f"sweep index as float’s: {number(100 * equal)} %"]
    return _error_text(row, VIEWS[View(view)][0], *said)


def _length_text(row: dict[str, Any]) -> str:
    """The bits that a signal is left."""
    return f"<b>{row['signal']}</b>: {row['bits']} of {row['bits'] + row['shorter']} bits ({row['shorter']} fewer)"
