"""Text of pages: symbols as they are printed, everything else as it is."""

import json
import re

import pytest

from tfra.report.html import Section, bars, contents, data_script, page, text


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
