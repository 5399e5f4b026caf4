"""Sentences, from tables whose numbers are literal."""

from typing import Any

import polars as pl
import pytest

from tests.study.definitions import design
from tfra.study.report.summary import impossible, notes, sufficient_converter_bits, sufficient_product_bits, summary

PHI, FORCE = "phi_deg", "force_difference_percent_of_true_force"
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


def test_the_summary() -> None:
    tables = {
        "errors": pl.concat([errors(), errors("train").with_columns(pl.col("median") + (pl.col("step") == "x"))]),
        "uniform": uniform({12: 30.0, 14: 6.0, 16: 4.0, 18: 0.0}),
        "converter": converter({8: {0.0: 80.0, 0.01: 2.0}, 12: {0.0: 4.0, 0.01: 1.0}, 14: {0.0: 0.1, 0.01: 0.0}}),
    }
    assert plain(summary(tables, design())) == (
        "12-bit converter: 0.60° and 1.0 % of F; arithmetic `standard`: 0.0020° and 0.0010 % of F; "
        "noise and offset: 0.31° and 0.52 % of F; the method itself: 4.0° and 18 % of F; "
        "all together: 4.2° and 18 % of F. "
        "A 12-bit converter or products of 16×16 bits alone would change the total by less than 5 %."
    )
    assert summary({}, design()) == ""


def test_the_notes() -> None:
    meaning, frames, left_out = notes({"errors": errors(), "flagged": flagged(7)})
    assert meaning.startswith("Amounts are medians of the errors' magnitudes over held-out frames;")
    assert frames == (
        "There are 90 valid frames for φ and 100 valid frames for F: a median needs 20, a 95th percentile 200; "
        "unknown values are left out."
    )
    assert left_out == (
        "7 of 1,200 held-out frames are left out of all errors, since a step flags them; frames that saturate are kept "
        "(most at any one step: no contact in 5 and input saturated in 2)."
    )
    assert notes({"uniform": uniform({12: 0.0})}) == [
        "Designs, converters and variants are compared on training frames."
    ]


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
    text = summary({"errors": errors("train"), "uniform": uniform({12: 9.0, 14: 7.0})}, design())
    assert plain(text).endswith(" No products of 12 to 14 bits would change the total by less than 5 %.")


def test_lengths_that_do_not_fit_are_none() -> None:
    table = uniform({12: 0.0, 14: 0.0, 27: 0.0})
    unknown = {name: pl.when(pl.col("bits") == 14).then(name) for name in ("median", "p95")}
    reason = pl.when(pl.col("bits") != 14).then(pl.lit("operand: 13 to 16 bits are supported, got 12"))
    table = table.with_columns(**unknown, reason=reason)
    assert sufficient_product_bits({"errors": errors("train"), "uniform": table}) == 14
    assert " Products of 14×14 bits alone" in summary({"errors": errors("train"), "uniform": table}, design())


def nulls(table: pl.DataFrame, *names: str) -> pl.DataFrame:
    return table.with_columns(pl.lit(None, dtype=pl.Float64).alias(name) for name in names)


def test_of_few_frames_nothing_is_claimed() -> None:
    tables = {"errors": errors(), "uniform": uniform({12: 0.0}), "converter": converter({8: {0.0: 80.0}})}
    tables = {name: nulls(table, "median", "p95") for name, table in tables.items()}
    assert summary(tables, design()) == "There are too few frames to split the error into steps."


def test_without_the_tail_of_one_quantity_nothing_is_claimed() -> None:
    """That of φ, of which fewer frames count."""
    tail = pl.when(pl.col("quantity") != PHI).then("p95")
    tables = {"errors": errors("train"), "uniform": uniform({12: 0.0})}
    assert "products" in summary(tables, design()).lower()
    tables = {name: table.with_columns(p95=tail) for name, table in tables.items()}
    assert "products" not in summary(tables, design()).lower()


def test_what_does_not_fit_has_its_reason() -> None:
    need = "signals.cordic: at least 18 bits are needed beside the 18 of scalar"
    shorter = [(1, f"{need}, got 17"), (4, f"{need}, got 14")]
    rows: list[dict[str, Any]] = [
        {"signal": "cordic", "bits": 18 - less, "shorter": less, "quantity": quantity, "reason": reason}
        for less, reason in shorter
        for quantity in (PHI, FORCE)
    ]
    rows.append({"signal": "scalar", "bits": 17, "shorter": 1, "quantity": PHI, "reason": None})
    assert impossible({"sensitivity": pl.DataFrame(rows)}, "sensitivity") == (
        f"Impossible, hence without numbers: `cordic` of 17 bits and 14 bits ({need})."
    )
    lengths = [{"bits": bits, "reason": f"operand: 10 to 27 bits are supported, got {bits}"} for bits in (8, 9)]
    assert impossible({"uniform": pl.DataFrame(lengths)}, "uniform") == (
        "Impossible, hence without numbers: 8 bits and 9 bits (operand: 10 to 27 bits are supported)."
    )
    variant = {"variant": "plateau_tolerance", "steps": 100, "plateau_tolerance_lsb": 0.5, "rounding": "half_up"}
    assert impossible({"variants": pl.DataFrame([variant | {"reason": "no"}])}, "variants") == (
        "Impossible, hence without numbers: plateau tolerance / LSB: 0.5 (no)."
    )
    assert impossible({"uniform": uniform({12: 0.0})}, "uniform") == ""
