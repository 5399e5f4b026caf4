"""Sizings on many parts as text, in JSON and as a page whose bars can be compared, from candidates that are made up."""

import re
from dataclasses import replace
from pathlib import Path

from tests.accessibility import faults_at_all_widths
from tests.browser import browser
from tests.synth.test_sizepage import SIZING, candidate
from tfra.families import find
from tfra.families.family import PRICED
from tfra.model.choices import SERIAL, Architecture
from tfra.synth.candidates import Bounds, Sizing
from tfra.synth.estimate import at_most
from tfra.synth.partspage import GUESS, all_facts, page, table, text
from tfra.synth.sizepage import facts

BOUNDS = Bounds(None, 1e3, 2e3)


def sizing(part: str, lut: int, *objections: str) -> Sizing:
    """One of a serial core alone."""
    return replace(SIZING, target=find(part), bounds=BOUNDS, candidates=(candidate(SERIAL, 1000, lut, *objections),))


SMALL, LARGE, NONE = sizing("ice40up5k", 4224), sizing("ecp5-85", 4224), sizing("ecp5-25", 30_000, "LUT: too many")
FAMILY = replace(SIZING, target=find("xc7"), bounds=BOUNDS, candidates=(candidate(Architecture(4, 1), 1000, 8364),))
PARTS = [SMALL, LARGE, NONE, FAMILY]
WHY = "ecp5-25-6: LUT: too many, for the smallest core that is fast enough (serial)"


def test_table() -> None:
    kinds = [each.candidates[0].architecture.kind for each in PARTS]
    pairs = zip(PARTS, kinds, strict=True)
    most = [f"at most {at_most({'LUT': part.fast[0].luts}, part.target.family, kind)['LUT']:,}" for part, kind in pairs]
    found = table(PARTS)
    assert found.header == ["part", "core", "MHz", "frames/s", "last word / µs", "LUT", "FF", "DSP", "BRAM"]
    assert found.rows == [
        ["ice40up5k,\nunder 10 EUR", "serial", "100", "100,000", "15.0", f"4,224, 80%,\n{most[0]}", "90", "88%", "10%"],
        ["ecp5-85-6,\n30 to 100 EUR", "serial", "100*", "100,000", "15.0", f"4,224, 5%,\n{most[1]}", "0%", "4%", "1%"],
        ["ecp5-25-6,\n10 to 30 EUR", "none", *[None] * 7],
        ["xc7", "parallel, 4 lanes, 1 word", "100*", "100,000", "15.0", f"8,364,\n{most[3]}", "90", "7", "3"],
    ]
    assert text(PARTS).endswith(f"\n{GUESS}\nEUR: {PRICED}\n{WHY}")


def test_a_clock_that_is_given_is_no_guess() -> None:
    assert table([replace(LARGE, bounds=Bounds(100.0, 1e3, 2e3))]).rows[0][2] == "100"


def test_json() -> None:
    small, large, none, _ = all_facts(PARTS)["parts"]
    assert (small, large) == (facts(SMALL), facts(LARGE))
    assert (small["clock_measured"], large["clock_measured"]) == (True, False)
    assert none == {"target": "ecp5-25-6", "why": WHY.partition(": ")[2]}


def test_page(tmp_path: Path) -> None:
    """Equal cores have equal bars, whatever their parts; the parts' are as long as the parts are large."""
    (tmp_path / "page.html").write_text(page(PARTS))
    with browser(tmp_path) as tab:
        tab.open(tmp_path / "page.html", 390)
        assert tab.evaluate("document.documentElement.scrollWidth") == 390
        said = tab.evaluate("document.body.innerText")
        bars = tab.evaluate("[...document.querySelectorAll('.bar span')].map(b => b.getBoundingClientRect().width)")
        wholes = tab.evaluate("[...document.querySelectorAll('.bar')].map(b => b.style.backgroundSize)")
        assert faults_at_all_widths(tab) == []
        assert (tab.messages, tab.requests) == ([], [])
    assert bars[0] == bars[1] > 0
    assert bars[2] == 0
    assert abs(bars[3] / bars[0] - 8364 / 4224) < 0.03
    assert [float(re.match(r"[\d.]+", each)[0]) for each in wholes] == [6.3, 100.0, 29.0, 0.0]  # type: ignore[index]
    assert "3 of 4 parts have a core for 1,000 frames/s and 2,000 µs" in said
    assert "4,224 of 5,280 LUT (80%): serial" in said
    assert WHY in said
