"""A table says the same in HTML, Markdown and text; numbers have the digits that are asked for."""

import re

import pytest

from tfra.report.table import Table, cell, listed, number

ROWS = [("LUT", 1200, 0.5, "a<b"), ("DSP", None, -1.0, "")]
TABLE = Table("Resources", ("", "used", "F_x / N", "note"), ROWS, words={0, 3})


def test_markdown() -> None:
    assert TABLE.markdown().splitlines() == [
        "|  | used | F_x / N | note |",
        "|---|---:|---:|---|",
        "| LUT | 1,200 | 0.5 | a<b |",
        "| DSP | – | -1 |  |",
    ]


def test_html() -> None:
    drawn = TABLE.html()
    assert 'aria-label="Resources"' in drawn
    assert re.findall(r"<t[hd]\b[^>]*>(.*?)</t[hd]>", drawn) == [
        *("", "used", "F<sub>x</sub> /&nbsp;N", "note"),
        *("LUT", "1,200", "0.5", "a&lt;b"),
        *("DSP", "–", "-1", ""),
    ]
    assert re.findall(r'<t[hd]\b[^>]*class="name">([^<]*)', drawn) == ["", "note", "LUT", "a&lt;b", "DSP", ""]


def test_text() -> None:
    lines = TABLE.text(60).splitlines()
    assert lines[0].strip() == "Resources"
    rows = [re.split(" *│ *", line.strip("│┃ ")) for line in lines if "LUT" in line or "DSP" in line]
    assert [row[:3] for row in rows] == [["LUT", "1,200", "0.5"], ["DSP", "–", "-1"]]
    assert max(map(len, lines)) <= 60


def test_text_without_a_header() -> None:
    drawn = Table("", ("", ""), [("frames", "12")], {0, 1}).text()
    assert "frames" in drawn
    assert "━" not in drawn


@pytest.mark.parametrize(
    ("value", "digits", "words"),
    [
        (0.0, 3, "0"), (1234.5, 3, "1,230"), (1234.5, 5, "1,234.5"), (0.04567, 2, "0.046"), (-0.5, 1, "-0.5"),
        (9.996, 3, "10.0"), (1.5e-7, 2, "1.5×10⁻⁷"), (-2e-5, 1, "-2×10⁻⁵"), (-1e-300, 1, "-1×10⁻³⁰⁰"),
    ],
)  # fmt: skip
def test_significant_digits(value: float, digits: int, words: str) -> None:
    assert number(value, digits) == words


@pytest.mark.parametrize(
    ("value", "words"),
    [(None, "–"), (True, "yes"), (1234567, "1,234,567"), (1234.56789, "1,234.57"), (float("nan"), "nan"), ("1", "1")],
)
def test_cells(value: object, words: str) -> None:
    assert cell(value) == words


def test_lists() -> None:
    assert [listed(["a", "b", "c"][:n]) for n in range(4)] == ["", "a", "a and b", "a, b and c"]
