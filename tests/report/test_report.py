"""Pages print symbols and everything else as it is; a table says the same in HTML, Markdown and text."""

import json
import re

import pytest

from tfra.report.html import Section, bars, contents, data_script, page, text
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


# Pages


@pytest.mark.parametrize(
    ("words", "shown"),
    [
        ("B^z and B^xy", "B<sup>z</sup> and B<sup>xy</sup>"),
        ("φ_ref = 45°, |F_z|", "φ<sub>ref</sub> = 45°, |F<sub>z</sub>|"),
        ("μ_ind, q_t", "μ<sub>ind</sub>, q<sub>t</sub>"),
        ("f_max / MHz", "f<sub>max</sub> / MHz"),
        ("mac_io, e_Fx_percent, load_data, h_c_x, a_long", "mac_io, e_Fx_percent, load_data, h_c_x, a_long"),
        ("<b> & F_x", "&lt;b&gt; &amp; F<sub>x</sub>"),
        ("`F_x < 0` is F_x", "<code>F_x &lt; 0</code> is F<sub>x</sub>"),
        ("one ` is none", "one ` is none"),
    ],
)
def test_symbols(words: str, shown: str) -> None:
    assert text(words) == shown


def test_contents_of_nothing() -> None:
    assert contents({}) == ""
    assert '<li><a href="#fig4">B<sup>z</sup></a></li>' in contents({"fig4": "B^z"})


def test_bars_stay_within_their_width() -> None:
    drawn = bars("Share", [("LUT", 0.5, "50 %"), ("FF", 1.2, "120 %"), ("DSP", -1, "0")])
    assert re.findall(r'style="width:([\d.]+)%"', drawn) == ["50.0", "100.0", "0.0"]
    assert re.findall(r'style="background-size:([\d.]+)%', drawn) == ["100.0"] * 3


def test_bars_of_wholes_of_different_widths() -> None:
    drawn = bars("Share", [("small", 0.1, "all of it"), ("large", 0.1, "a tenth")], [0.1, 1.0])
    assert re.findall(r'"(?:width|background-size):([\d.]+)%', drawn) == ["10.0", "10.0", "100.0", "10.0"]


def test_contents_link_to_every_section() -> None:
    sections = [Section("used", "Used", ["<p>1</p>", "<p>2</p>"]), Section("field", "B^z", [])]
    drawn = page("A < B", ["<p>Opening</p>"], sections)
    assert "<title>A &lt; B</title>" in drawn
    assert re.findall('href="#([a-z]+)"', drawn) == re.findall('<h2 id="([a-z]+)"', drawn) == ["used", "field"]
    order = ["<h1>", "Opening", "<nav", "<section", "<p>1</p>\n<p>2</p>"]
    assert [drawn.index(part) for part in order] == sorted(drawn.index(part) for part in order)


def test_data_cannot_end_its_script() -> None:
    drawn = data_script("data", {"name": "</script><b>µ"})
    assert drawn.count("<") == 2
    assert json.loads(drawn.partition(">")[2].rpartition("<")[0]) == {"name": "</script><b>µ"}
