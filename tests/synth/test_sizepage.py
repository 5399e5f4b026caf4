"""A sizing as text, in JSON and as a page, from candidates that are made up."""

import re
import tomllib
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from tests.accessibility import faults_at_all_widths
from tests.browser import browser
from tfra.families import FAMILIES, find
from tfra.families.family import PRICED
from tfra.model.choices import SERIAL, Architecture
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.sensor import SensorArray
from tfra.synth.candidates import Bounds, Candidate, Sizing, Speed
from tfra.synth.estimate import at_most, basis, prices
from tfra.synth.power import power
from tfra.synth.sizepage import config, facts, lines, page

DESIGN = TfraDesign(SensorArray(3, 4, 4e-3, 2e-3, 3e-3), target="ice40")


def candidate(architecture: Architecture, interval: int, lut: int = 0, *objections: str) -> Candidate:
    used = {"LUT": lut, "FF": 90, "DSP": 7, "BRAM": 3} if lut else None
    one = replace(DESIGN, architecture=architecture, target="portable")
    return Candidate(architecture, one, Speed(interval, interval + 500, 100.0), used, objections)


SIZING = Sizing(
    DESIGN,
    find("ecp5-25"),
    Bounds(100.0, 1e5, 20.0),
    (
        Candidate(SERIAL, None, None, None, ("architecture.kind: too large",)),
        candidate(Architecture(4, 1), 1500, 0, "too slow: 66,666.7 frames/s, 100,000 are wanted"),
        candidate(Architecture(8, 1), 1000, 1100),
        candidate(Architecture(4, 2), 900, 1050, "BRAM: about 60 are needed, ecp5-25-6 has 56"),
        candidate(Architecture(8, 2), 800, 1200),
        candidate(Architecture(4, 4), 1600, 0, "too slow: 62,500.0 frames/s, 100,000 are wanted"),
        candidate(Architecture(8, 4), 1001, 0, "too slow: 99,900.1 frames/s, 100,000 are wanted"),
    ),
)


USED = {"LUT": 1100, "FF": 90, "DSP": 7, "BRAM": 3}


def test_lines() -> None:
    off = ", ".join(f"{100 * error:.1f} % ({name})" for name, error in prices().error.items())
    fitted = f"fitted to syntheses of parallel cores for ECP5, off by up to {off}"
    watts = power(USED, "parallel", 100.0, SIZING.target)
    most = at_most(USED, SIZING.target.family, "parallel")
    found = list(lines(SIZING))
    assert tomllib.loads("\n".join(found)) == config(SIZING)
    assert found == [
        "[architecture]",
        'kind = "parallel"',
        "mac_lanes = 8",
        "vector_words = 1",
        "[target]",
        'name = "portable"',
        "# ecp5-25-6 at 100 MHz: 100,000 frames/s, 15.000 us from last taxel to last word",
        "# estimated: 1,100 of 24,288 LUT (5%), 90 of 24,288 FF (0%), 7 of 28 DSP (25%), 3 of 56 BRAM (5%)",
        f"# at most, if as short as any estimate was: {most['LUT']:,} LUT, {most['FF']:,} FF",
        f"# a LUT is a LUT4 of ECP5; {fitted}",
        f"# power, an estimate: {watts}; logic, multipliers and memories come on top",
        f"# ecp5-25: 10 to 30 EUR a piece ({PRICED})",
        "# not chosen:",
        "#   serial: architecture.kind: too large",
        "#   parallel, 8 lanes, 2 words: larger: 1,200 LUT, 9.1% more",
        "#   parallel, 8 lanes, 4 words: too slow: 99,900.1 frames/s, 100,000 are wanted",
    ]


def test_facts_say_the_same() -> None:
    found = facts(SIZING)
    assert (found["kind"], found["mac_lanes"], found["estimated"]["LUT"]) == ("parallel", 8, 1100)
    assert (found["frames_per_second"], found["latency_us"], found["interval"]) == (1e5, 15.0, 1000)
    assert found["available"] == find("ecp5-25").available
    assert found["at_most"] == at_most(USED, SIZING.target.family, "parallel")
    assert (found["price_class_eur"], found["least_power"]["rest_mw"]) == ("10 to 30", pytest.approx(84.7))
    assert (found["fitted_to"], found["relative_error"]) == ("ecp5", prices().error)
    assert [each["why"] for each in found["others"]] == [why for _, why in SIZING.others]
    assert found["others"][0]["frames_per_second"] is None


@pytest.mark.parametrize("render", [facts, page, lambda sizing: list(lines(sizing))])
def test_nothing_chosen(render: Callable[[Sizing], object]) -> None:
    with pytest.raises(ValueError, match=r"^frames_per_second: 100000 are wanted, 66666\.7 is the best"):
        render(replace(SIZING, candidates=SIZING.candidates[:2]))


def test_a_family_of_any_size() -> None:
    found = list(lines(replace(SIZING, target=find("xc7"))))
    assert "# estimated: 1,100 LUT, 90 FF, 7 DSP, 3 BRAM" in found
    assert "# xc7 stands for a whole family: the size of a part is not checked" in found


@pytest.mark.parametrize(
    ("kind", "family", "said"),
    [
        ("parallel", "gowin", "LUT4 of ECP5, the family of the fitted parallel cores; GW2A has LUT4s, so this"),
        ("serial", "xilinx", "logic cell of iCE40, the family of the fitted serial cores; 7 series has LUT6s, so"),
        ("serial", "ice40", "logic cell of iCE40; fitted to syntheses of serial cores for iCE40, off by up to"),
        ("serial", "ecp5", "LUT4 of ECP5; fitted to syntheses of serial cores for ECP5, off by up to"),
        (
            *("serial", "gatemate"),
            "logic cell of iCE40, the family of the fitted serial cores; GateMate has half CPEs, "
            "so this is only a guide: a core took 42% more",
        ),
    ],
)
def test_whose_lookup_tables(kind: str, family: str, said: str) -> None:
    assert basis(kind, FAMILIES[family]).startswith(f"a LUT is a {said}")


def test_page(tmp_path: Path) -> None:
    slow, small, large = SIZING.candidates[0], SIZING.candidates[2], SIZING.candidates[3]
    (tmp_path / "page.html").write_text(page(replace(SIZING, candidates=(slow, small, large))))
    with browser(tmp_path) as tab:
        tab.open(tmp_path / "page.html", 390)
        assert tab.evaluate("document.documentElement.scrollWidth") == 390
        said = tab.evaluate("document.body.innerText")
        rows = tab.evaluate("[...document.querySelectorAll('.wide tbody tr')].map(r => r.innerText.split('\\t'))")
        bars = tab.evaluate("[...document.querySelectorAll('.bar span')].map(b => parseFloat(b.style.width))")
        assert faults_at_all_widths(tab) == []
        assert (tab.messages, tab.requests) == ([], [])
    assert "Parallel, 8 lanes, 1 word: 100,000 frames/s and 15.000 µs" in said
    assert 'kind = "parallel"\nmac_lanes = 8\nvector_words = 1\n' in said
    assert rows == [
        ["serial", "–", "–", "–", "–", "–", "–", slow.objections[0]],
        ["parallel, 8 lanes, 1 word", "100,000", "15.000", "1,100", "90", "7", "3", "chosen"],
        ["parallel, 4 lanes, 2 words", "111,111", "14.000", "1,050", "90", "7", "3", large.objections[0]],
    ]
    assert bars == [pytest.approx(100 * luts / 24_288, abs=0.1) for luts in (1050, 1100)]


def test_bars_longer_than_the_part() -> None:
    """Cores over the part differ in their bars, too, and the part's is as much shorter."""
    over = [candidate(Architecture(4, words), 900, luts, "LUT: too many") for words, luts in ((1, 48_576), (2, 36_432))]
    drawn = page(replace(SIZING, candidates=(SIZING.candidates[2], *over)))
    assert re.findall(r'"width:([\d.]+)%', drawn) == ["2.3", "75.0", "100.0"]
    assert re.findall(r'"background-size:([\d.]+)%', drawn) == ["50.0"] * 3
