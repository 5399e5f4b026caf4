"""Text of pages: symbols as they are printed, everything else as it is."""

from __future__ import annotations

import re

import pytest

from tfra.report.html import bars, contents, text


@pytest.mark.parametrize(
    ("words", "shown"),
    [
        ("B^z and B^xy", "B<sup>z</sup> and B<sup>xy</sup>"),
        ("φ_ref = 45°, |F_z|", "φ<sub>ref</sub> = 45°, |F<sub>z</sub>|"),
        ("μ_ind, q_t", "μ<sub>ind</sub>, q<sub>t</sub>"),
        ("f_max / MHz", "f<sub>max</sub> / MHz"),
        ("mac_io, e_Fx_percent, load_data, h_c_x, a_long", "mac_io, e_Fx_percent, load_data, h_c_x, a_long"),
        ("<b> & F_x", "&lt;b&gt; &amp; F<sub>x</sub>"),
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
