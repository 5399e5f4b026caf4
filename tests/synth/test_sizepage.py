"""The page of a sizing, by cores made up."""

from pathlib import Path

import pytest

from tests.accessibility import faults_at_all_widths
from tests.browser import browser
from tfra.families import find
from tfra.model.choices import SERIAL, Architecture
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.sensor import SensorArray
from tfra.synth.candidates import Bounds, Candidate, Sizing, Speed
from tfra.synth.sizepage import page

DESIGN = TfraDesign(SensorArray(3, 3, 4e-3, 2e-3, 3e-3), name="skin", architecture=Architecture(4))
SMALL, LARGE = {"LUT": 10_000, "FF": 9, "DSP": 7, "BRAM": 14}, {"LUT": 25_000, "FF": 9, "DSP": 7, "BRAM": 14}
CORES = (
    Candidate(SERIAL, DESIGN, Speed(50_000, 20_000), None, ("too slow: 2,000.0 frames/s, 10,000 are wanted",)),
    Candidate(Architecture(4, 1), DESIGN, Speed(1000, 2000), SMALL, ()),
    Candidate(Architecture(4, 4), DESIGN, Speed(1000, 1500), LARGE, ("LUT: about 25,000 are needed",)),
)


def sizing(*cores: Candidate) -> Sizing:
    return Sizing(DESIGN, find("ecp5-25"), Bounds(100.0, 1e4, 100.0), cores)


def test_page(tmp_path: Path) -> None:
    (tmp_path / "page.html").write_text(page(sizing(*CORES)))
    with browser(tmp_path) as tab:
        tab.open(tmp_path / "page.html")
        said = tab.evaluate("document.body.innerText")
        rows = tab.evaluate("[...document.querySelectorAll('.wide tbody tr')].map(r => r.innerText.split('\\t'))")
        bars = tab.evaluate("[...document.querySelectorAll('.bar span')].map(b => parseFloat(b.style.width))")
        assert faults_at_all_widths(tab) == []
        assert (tab.messages, tab.requests) == ([], [])
        for width in (390, 600):
            tab.open(tmp_path / "page.html", width)
            assert tab.evaluate("document.documentElement.scrollWidth") == width
    assert "Parallel, 4 lanes, 1 word: 100,000 frames/s and 20.000 µs" in said
    assert 'kind = "parallel"\nmac_lanes = 4\nvector_words = 1\n' in said
    assert rows == [
        ["serial", "2,000", "200.000", "–", "–", "–", "–", CORES[0].objections[0]],
        ["parallel, 4 lanes, 1 word", "100,000", "20.000", "10,000", "9", "7", "14", "chosen"],
        ["parallel, 4 lanes, 4 words", "100,000", "15.000", "25,000", "9", "7", "14", CORES[2].objections[0]],
    ]
    assert bars == [pytest.approx(100 * 10_000 / 24_288, abs=0.1), 100.0]


def test_no_page_without_an_answer() -> None:
    with pytest.raises(ValueError, match="frames_per_second: 10000 are wanted"):
        page(sizing(CORES[0]))
