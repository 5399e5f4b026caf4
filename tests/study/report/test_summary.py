"""Sentences, from tables whose numbers are literal."""

from typing import Any

import polars as pl
import pytest

from tests.study.definitions import design
from tests.study.report.search_tables import FORCE, PHI, baseline, designs, trials
from tfra.report.table import number
from tfra.study.report.summary import (
    cheapest_trials,
    notes,
    sufficient_converter_bits,
    sufficient_product_bits,
    summary,
)

OWN = {"method": (4.0, 18.0), "noise": (0.31, 0.52), "converter": (0.6, 1.0), "arithmetic": (0.002, 0.001)}
TOTAL = {"method": (4.0, 18.0), "noise": (4.1, 18.2), "converter": (4.2, 18.4), "arithmetic": (4.2, 18.4)}


def row(step: str, view: str, quantity: str, median: float, **more: Any) -> dict[str, Any]:
    count = 90 if quantity == PHI else 100
    return {
        "quantity": quantity,
        "step": step,
        "view": view,
        "count": count,
        "median": median,
        "p95": 3 * median,
        "reason": None,
    } | more


def errors(part: str = "held_out") -> pl.DataFrame:
    return pl.DataFrame(
        [
            row(step, view, quantity, value, part=part)
            for view, steps in (("own", OWN), ("total", TOTAL))
            for step, values in steps.items()
            for quantity, value in zip((PHI, FORCE), values, strict=True)
        ]
    )


def uniform(changes: dict[int, float]) -> pl.DataFrame:
    """Totals that are so many percent above those without arithmetic."""
    return pl.DataFrame(
        [
            row("arithmetic", "total", quantity, value * (1 + change / 100), bits=bits)
            for bits, change in changes.items()
            for quantity, value in zip((PHI, FORCE), TOTAL["converter"], strict=True)
        ]
    )


def converter(changes: dict[int, dict[float, float]]) -> pl.DataFrame:
    """The same of converters at some noise, above the total without one."""
    return pl.DataFrame(
        [
            row(step, "total", quantity, 5.0 * above, bits=bits, noise_share_of_peak=noise)
            for bits, by_noise in changes.items()
            for noise, change in by_noise.items()
            for quantity in (PHI, FORCE)
            for step, above in (("noise", 1.0), ("converter", 1 + change / 100))
        ]
    )


def flagged(left_out: int) -> pl.DataFrame:
    rows = [("method", "no_contact", 3), ("noise", "no_contact", 5), ("converter", "input_saturated", 2)]
    rows += [("arithmetic", "compression_only", 0), ("any", "left_out", left_out)]
    return pl.DataFrame([{"part": "held_out", "step": s, "status": n, "frames": f, "of": 1200} for s, n, f in rows])


def plain(text: str) -> str:
    return text.replace("\N{NO-BREAK SPACE}", " ")


def enough(tables: dict[str, pl.DataFrame]) -> str:
    """The line about sufficient lengths."""
    (line,) = (line for line in summary(tables, design()) if line.startswith("Enough: "))
    return line


def test_the_summary() -> None:
    tables = {
        "errors": pl.concat([errors(), errors("train").with_columns(pl.col("median") + (pl.col("step") == "x"))]),
        "uniform": uniform({12: 30.0, 14: 6.0, 16: 4.0, 18: 0.0}),
        "converter": converter({8: {0.0: 80.0, 0.01: 2.0}, 12: {0.0: 4.0, 0.01: 1.0}, 14: {0.0: 0.1, 0.01: 0.0}}),
    }
    tables["designs"] = designs(base=400.0, uniform=265.4, mixed=199.2)
    assert plain("\n".join(summary(tables, design()))).splitlines() == [
        "Asked: how many bits does `tfra` need (6×8 taxels, 12-bit converter, arithmetic `standard`), "
        "if its error may change by 5 %?",
        "Limit: the method itself, 4.0° and 18 % of F; 12-bit converter, 0.60° and 1.0 % of F; "
        "noise and offset, 0.31° and 0.52 % of F; arithmetic `standard`, 0.0020° and 0.0010 % of F; "
        "all together, 4.2° and 18 % of F.",
        "Enough: a 12-bit converter or products of 16×16 bits alone would change the total by less than 5 %.",
        "Saved: the smallest design within 5 % of float's total is `mixed` (199 kbit of coefficients, "
        "25 % less than the best uniform one, `uniform` and 50 % less than that of CONFIG, `base`).",
        "Measured: placed and routed, estimates are off by up to 16 % (LUT).",
        "Next: generate the core of `designs/mixed.toml`; the method errs most, so more bits gain little: "
        "choose contacts that suit it, another estimator, or one that is trained longer.",
    ]
    assert summary({}, design()) == []


@pytest.mark.parametrize(
    ("step", "advice"),
    [
        ("noise", "noise and offset err most, so more bits gain little: lower them, or average frames."),
        ("converter", "the converter errs most: take one with more bits, or a smaller full scale."),
        ("arithmetic", "arithmetic errs most: lengthen the words of the signals that need their bits."),
    ],
)
def test_the_largest_share_decides_what_to_do(step: str, advice: str) -> None:
    table = errors().with_columns(
        median=pl.col("median") + 50.0 * ((pl.col("step") == step) & (pl.col("view") == "own"))
    )
    *_, limit, last = summary({"errors": table}, design())
    assert limit.startswith(f"Limit: {'12-bit ' if step == 'converter' else ''}{step}")
    assert last == f"Next: {advice}"


def test_the_notes() -> None:
    meaning, frames, left_out = notes({"errors": errors(), "flagged": flagged(7)})
    assert "over held-out frames;" in meaning
    assert "90 valid frames for φ and 100 valid frames for F: a median needs 20, a 95th percentile 200;" in frames
    assert left_out.startswith("7 of 1,200 held-out frames are left out of all errors")
    assert "no contact in 5 and input saturated in 2" in left_out
    assert len(notes({"uniform": uniform({12: 0.0})})) == 1


@pytest.mark.parametrize(
    ("changes", "fewest"),
    [
        ({12: 4.9, 14: 0.0}, 12),
        ({12: 4.0, 14: 5.1, 16: 4.0}, 16),
        ({12: -5.1, 14: -4.0}, 14),
        ({14: 4.0, 16: 6.0}, None),
    ],
)
def test_from_there_on_all_are_close(changes: dict[int, float], fewest: int | None) -> None:
    assert sufficient_product_bits({"errors": errors("train"), "uniform": uniform(changes)}) == fewest
    at_one_noise = {bits: {0.0: change, 0.01: 0.0} for bits, change in changes.items()}
    assert sufficient_converter_bits({"converter": converter(at_one_noise)}) == fewest


def test_the_tail_counts_too_and_an_unknown_one_is_not_close() -> None:
    table = uniform({12: 0.0, 14: 0.0})
    for p95 in (
        pl.col("p95") * pl.when(pl.col("bits") == 12).then(1.06).otherwise(1.0),
        pl.when(pl.col("bits") > 12).then("p95"),
    ):
        assert sufficient_product_bits({"errors": errors("train"), "uniform": table.with_columns(p95=p95)}) == 14
    text = enough({"errors": errors("train"), "uniform": uniform({12: 9.0, 14: 7.0})})
    assert plain(text).endswith(" no products of 12 to 14 bits would change the total by less than 5 %.")


def test_lengths_that_do_not_fit_are_none() -> None:
    table = uniform({12: 0.0, 14: 0.0, 27: 0.0})
    unknown = {name: pl.when(pl.col("bits") == 14).then(name) for name in ("median", "p95")}
    reason = pl.when(pl.col("bits") != 14).then(pl.lit("operand: 13 to 16 bits are supported, got 12"))
    table = table.with_columns(**unknown, reason=reason)
    assert sufficient_product_bits({"errors": errors("train"), "uniform": table}) == 14
    assert " products of 14×14 bits alone" in enough({"errors": errors("train"), "uniform": table})


def test_without_the_tail_of_one_quantity_nothing_is_claimed() -> None:
    """That of φ, of which fewer frames count."""
    tail = pl.when(pl.col("quantity") != PHI).then("p95")
    tables = {"errors": errors("train"), "uniform": uniform({12: 0.0})}
    assert "products" in " ".join(summary(tables, design())).lower()
    tables = {name: table.with_columns(p95=tail) for name, table in tables.items()}
    assert "products" not in " ".join(summary(tables, design())).lower()


@pytest.mark.parametrize(
    ("kbit", "end"),
    [
        ({"uniform": 265.4, "mixed": 199.2}, "`mixed` (199 kbit, 25 % less than the best uniform one, `uniform`)."),
        ({"uniform": 199.2, "mixed": 265.4}, "`uniform` (199 kbit)."),
        ({"mixed": 199.2, "tiny": -90.0}, "`mixed` (199 kbit)."),
        ({"uniform": -100.0, "mixed": 110.0}, "`mixed` (110 kbit, 10 % more than the best uniform one, `uniform`)."),
    ],
)
def test_the_smallest_design(kbit: dict[str, float], end: str) -> None:
    _, saved, *_ = map(plain, summary({"designs": designs(**kbit)}, design()))
    start = "Saved: the smallest design within 5 % of float's total is "
    assert saved.replace(" of coefficients", "") == f"{start}{end}"


def test_no_design_is_small_and_good() -> None:
    _, bad, *_ = summary({"designs": designs(mixed=-100.0)}, design())
    assert plain(bad) == "Saved: nothing; no design of the table is within 5 % of float's total."
    unknown = designs(mixed=1.0).with_columns(within=pl.lit(None))
    for table in (designs(), unknown):
        assert summary({"designs": table}, design()) == []


def test_the_cheapest_within_the_tolerance() -> None:
    """Trial 1 has 4 % more error than float in F and none in phi; trial 2 has 10 % more in phi."""
    tables = {"trials": trials(), "baseline": baseline(), "designs": designs(mixed=1.0)}
    start = "Cheapest within 5 % of float's errors: "
    assert {cost: plain(text).removeprefix(start) for (cost,), text in cheapest_trials(tables).items()} == {
        "coefficient_kbit": "120 kbit of coefficients (trial 1 of 5); "
        "by random choice: 160 kbit of coefficients (trial 1 of 3).",
        "LUT": "10,000 LUT (trial 1 of 5); by random choice: 12,000 LUT (trial 1 of 3).",
    }
    for few in (baseline().head(1), trials([])):
        assert cheapest_trials(tables | {"baseline": few})["LUT",].endswith("; by random choice: none of 1 trials.")
    del tables["baseline"]
    assert plain(cheapest_trials(tables)["LUT",]) == f"{start}10,000 LUT (trial 1 of 5)."


@pytest.mark.parametrize(
    ("lut", "line"),
    [
        ({"uniform": 10_000, "mixed": 7_700}, "`mixed` takes 23\N{NO-BREAK SPACE}% less LUT than `uniform`; "),
        ({"uniform": 10_000, "mixed": 9_600, "front_1": 9_000},
         "no mixed design takes 20\N{NO-BREAK SPACE}% less of a resource than `uniform`: "
         "most is 10\N{NO-BREAK SPACE}% of LUT; "),
        ({"mixed": 9_600}, ""),
        ({"uniform": 10_000, "far": 5_000}, ""),
    ],
)  # fmt: skip
def test_what_a_mixed_design_saves_is_measured(lut: dict[str, float], line: str) -> None:
    """Of designs within the tolerance; those that were not synthesised do not count."""
    table = designs(uniform=200.0, mixed=150.0, front_1=140.0, far=-100.0).drop("placed_LUT")
    measured = pl.DataFrame({"name": list(lut), "synthesised_LUT": [float(used) for used in lut.values()]})
    tables = {"designs": table.join(measured, on="name", how="left", maintain_order="left"), "errors": errors()}
    off = max(abs(10_500 / used - 1) for used in lut.values())
    (found,) = (text for text in summary(tables, design()) if text.startswith("Measured: "))
    end = f"estimates are off by up to {number(100 * off, 2)}\N{NO-BREAK SPACE}% (LUT)."
    assert found == f"Measured: by synthesis, {line}{end}"
