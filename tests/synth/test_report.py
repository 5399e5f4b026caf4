"""The report: arithmetic by hand, and a text that shows it."""

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from tests.accessibility import faults_at_all_widths
from tests.browser import browser
from tfra.families import find
from tfra.hdl.parallel.tfra.core import TfraParallel
from tfra.model.choices import Architecture
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.sensor import SensorArray
from tfra.report.table import WIDTH
from tfra.synth.estimate import Estimate
from tfra.synth.flow import CriticalPath, Route, Synthesis
from tfra.synth.page import fmax, page, render
from tfra.synth.report import median_route, report

DESIGN = TfraDesign(SensorArray(3, 3, 4e-3, 2e-3, 3e-3), name="skin", architecture=Architecture(4))
PATH = CriticalPath("sweep", "matvec", "core.sweep.a", "core.matvec.b", 3.25, 6.75)
USED = {"LUT": 12144, "FF": 6000, "DSP": 7, "BRAM": 14}
ROUTES = [Route(seed, mhz, USED, PATH) for seed, mhz in ((1, 100.0), (2, 90.0), (3, 125.0))]
SYNTHESIS = Synthesis({"LUT": 12000, "FF": 6000, "DSP": 7, "BRAM": 14}, {"LUT4": 12000}, "default")
ESTIMATED = Estimate(
    {
        "matvec": {"LUT": 4000.4, "FF": 5000, "DSP": 5, "BRAM": 14},
        "sweep": {"LUT": 7000, "FF": 1100, "DSP": 2, "BRAM": 0},
    },
    0,
)


STATED: Any = {"package": False, "netlist": "0123", "asked_mhz": 130.0}


def made(routes: Sequence[Route] = ROUTES, seeds: int = 3) -> dict[str, Any]:
    return report(DESIGN, find("ecp5-25"), SYNTHESIS, routes, ESTIMATED, seeds, **STATED)


def test_numbers() -> None:
    found = made()
    assert json.loads(json.dumps(found, allow_nan=False)) == found
    assert found["resources"]["LUT"] == {"used": 12144, "available": 24288, "percent": 50.0, "estimated": 11000}
    assert found["resources"]["DSP"]["percent"] == 25.0
    clock, times, cycles = found["clock"], found["timing"], TfraParallel(DESIGN)
    assert (clock["lowest_mhz"], clock["median_mhz"], clock["highest_mhz"]) == (90.0, 100.0, 125.0)
    assert clock["critical_path"]["begin"] == "sweep"
    assert times["latency_cycles"] == cycles.latency
    assert times["frame_latency_us"] == pytest.approx(cycles.frame_latency / 100)
    assert times["frames_per_second"] == pytest.approx(1e8 / cycles.initiation_interval, abs=0.1)
    assert times["mac_utilisation"] == pytest.approx(DESIGN.multiplications / 4 / cycles.initiation_interval, abs=1e-4)


def test_the_median_is_a_seed() -> None:
    assert median_route(ROUTES).seed == 1
    assert median_route(ROUTES[:2]).seed == 2
    assert median_route([replace(ROUTES[0], seed=9)]).seed == 9


def test_text() -> None:
    text = render(made())
    shown = "100.0 MHz (median of 3 seeds, 90.0 to 125.0)"
    for part in ("skin on ecp5-25-6", "12,144", "24,288", "50.0", shown, "sweep to matvec"):
        assert part in text
    assert "ABC9" not in text
    assert max(map(len, text.splitlines())) <= WIDTH


def test_counts_alone() -> None:
    found = report(DESIGN, find("xc7"), replace(SYNTHESIS, mapper="abc"), [], ESTIMATED, 0, **STATED)
    assert found["clock"] is None
    assert "frames_per_second" not in found["timing"]
    assert found["resources"]["LUT"]["available"] is None
    text = render(found)
    assert "no Fmax: only yosys runs" in text
    assert "ABC9 aborted" in text


def test_one_seed_is_no_range() -> None:
    found = made(ROUTES[2:], 1)
    assert fmax(found["clock"]) == "125.0 MHz (seed 3 alone)"
    assert " to 125.0" not in render(found)


def test_what_is_not_finished_says_so() -> None:
    for text in (render, page):
        for done in (0, 2):
            found = made(ROUTES[:done])
            assert not found["complete"]
            assert f"ot finished: yosys and {done} of 3 seeds are done" in text(found)
        assert "ot finished" not in text(made())


def test_page(tmp_path: Path) -> None:
    found = made()
    (tmp_path / "page.html").write_text(page(found))
    with browser(tmp_path) as tab:
        tab.open(tmp_path / "page.html", 390)
        assert tab.evaluate("document.documentElement.scrollWidth") == 390
        said = tab.evaluate("document.body.innerText")
        assert (tab.messages, tab.requests) == ([], [])
        assert faults_at_all_widths(tab) == []
    for part in ("100.0 MHz (median of 3 seeds, 90.0 to 125.0)", "12,144 LUT (50.0 %)", "seed 2", "90.0 MHz"):
        assert part in said
    assert said.index("sweep\t7,000") < said.index("matvec\t4,000")
