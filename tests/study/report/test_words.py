"""Numbers and lists as words."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tfra.study.report.words import amount, listed, number


@given(st.floats(1e-12, 1e12), st.integers(1, 5))
def test_numbers_keep_their_digits(value: float, digits: int) -> None:
    text = number(value, digits).replace(",", "")
    mantissa, _, power = text.partition("×10")
    raised = int(power.translate(str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")) or 0)
    found = float(mantissa) * 10.0**raised
    assert found == float(f"{value:.{digits - 1}e}") or math.isclose(found, float(f"{value:.{digits - 1}e}"))


@pytest.mark.parametrize(
    ("value", "text"),
    [(0, "0"), (-0.0, "0"), (1234.5, "1,230"), (0.00099996, "0.00100"), (-2.5e-7, "-2.50×10⁻⁷"), (99.96, "100")],
)
def test_numbers_literally(value: float, text: str) -> None:
    assert number(value) == text


def test_lists() -> None:
    assert [listed(["a", "b", "c"][:n]) for n in range(4)] == ["", "a", "a and b", "a, b and c"]


@pytest.mark.parametrize(
    ("cost", "value", "text"),
    [
        ("coefficient_kbit", 48.24, "48.2 kbit of coefficients"),
        ("coefficient_kbit", 1048.24, "1,048 kbit of coefficients"),
        ("LUT", 23456.0, "23,456 LUT"),
        ("dsp", 17, "17 DSP"),
        ("latency_cycles", 0.0, "0 cycles of latency"),
    ],
)
def test_costs_literally(cost: str, value: float, text: str) -> None:
    assert amount(cost, value).replace("\N{NO-BREAK SPACE}", " ") == text
