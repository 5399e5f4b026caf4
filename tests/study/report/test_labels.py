"""Labels of columns and costs."""

import pytest

from tfra.study.report.labels import column_label, cost_amount


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
