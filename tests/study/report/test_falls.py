"""Totals that fall with fewer bits: which, and their reasons, from tables whose numbers are literal."""

from typing import Any

import polars as pl
import pytest

from tests.study.report.search_tables import FORCE
from tfra.study.report import error_charts
from tfra.study.report.falls import fall_sentences, falls


def converter(totals: dict[int, float], noise: float, before: float, spread: float, left_out: int = 9) -> pl.DataFrame:
    """Totals by bits; ``before`` is that without the 10-bit converter, intervals reach ``spread`` to both sides."""
    rows: list[dict[str, Any]] = []
    for bits, total in totals.items():
        frames = {"noise_share_of_peak": noise, "bits": bits, "quantity": FORCE, "count": 1400}
        frames |= {"left_out": left_out if bits == 10 else 9, "reason": None}
        for step, view, value in (
            ("noise", "total", before if bits == 10 else 47.0),
            ("converter", "own", 3.0),
            ("converter", "total", total),
        ):
            rows.append(frames | {"step": step, "view": view})
            for name in ("median", "p95"):
                rows[-1] |= {name: value, f"{name}_low": value - spread, f"{name}_high": value + spread}
    return pl.DataFrame(rows)


@pytest.mark.parametrize(
    ("noise", "before", "spread", "left_out", "reason"),
    [
        (0.001, 47.0, 2.5, 9, "They overlap: among 1,400 frames this may be chance."),
        (0.001, 47.0, 1.0, 9, "Without the converter the same frames have 47.0 %: its steps round noise away."),
        (0.0, 47.0, 1.0, 9, "Without the converter the same frames have 47.0 %: "
                            "its share, 3.00 %, cancels a part of that."),
        (0.001, 42.0, 1.0, 70, "The frames are others: 70 are left out, with 16 bits 9; "
                               "without the converter those that remain have 42.0 %."),
    ],
)  # fmt: skip
def test_the_sentence_and_its_reason(noise: float, before: float, spread: float, left_out: int, reason: str) -> None:
    table = converter({10: 43.0, 12: 46.6, 16: 47.0}, noise, before, spread, left_out)
    sentences = fall_sentences({"converter": table})
    assert list(sentences) == [(FORCE, "p95"), (FORCE, "median")]
    assert sentences[FORCE, "p95"].replace("\N{NO-BREAK SPACE}", " ") == (
        f"Smaller with fewer bits: at a noise of {100 * noise:g} % of the peak, the 95th percentile of the total is "
        f"43.0 % ({43 - spread} to {43 + spread}) with 10 bits and 47.0 % ({47 - spread} to {47 + spread}) with 16; "
        f"in brackets are 95 % intervals. {reason}"
    )


def test_only_what_a_reader_sees_falls() -> None:
    """46.6 is shown as 47; 12 bits are more than 10, and still less than 16."""
    table = converter({8: 50.0, 10: 43.0, 11: 46.6, 12: 44.0, 16: 47.0}, 0.001, 47.0, 1.0)
    assert list(falls(table, FORCE, "p95")) == [(0.001, 10), (0.001, 12)]
    (heat,) = error_charts.converter({"converter": table}, FORCE, "p95", "total").data
    assert list(map(list, heat.text)) == [["50", "43<br>42 to 44", "47", "44<br>43 to 45", "47"]]
    (own,) = error_charts.converter({"converter": table}, FORCE, "p95", "own").data
    assert set(own.text[0]) == {"3.0"}
    assert fall_sentences({"converter": table.filter(pl.col("bits") != 10).filter(pl.col("bits") < 12)}) == {}
