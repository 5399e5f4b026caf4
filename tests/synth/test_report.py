"""The report: arithmetic by hand, and a text that shows it."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest

from tfra.hdl.parallel.tfra.parallel import Parallel
from tfra.hdl.serial.serial import Serial
from tfra.model.choices import SERIAL, Architecture
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.sensor import SensorArray
from tfra.synth.flow import CriticalPath, Route, Synthesis
from tfra.synth.report import WIDTH, median_route, render, report
from tfra.synth.targets import find

DESIGN = TfraDesign(SensorArray(3, 3, 4e-3, 2e-3, 3e-3), name="skin", architecture=Architecture(4))
PATH = CriticalPath("sweep", "matvec", "core.sweep.a", "core.matvec.b", 3.25, 6.75)
USED = {"LUT": 12144, "FF": 6000, "DSP": 7, "BRAM": 14}
ROUTES = [Route(seed, 130.0, mhz, USED, PATH) for seed, mhz in ((1, 100.0), (2, 90.0), (3, 125.0))]
SYNTHESIS = Synthesis({"LUT": 12000, "FF": 6000, "DSP": 7, "BRAM": 14}, {"LUT4": 12000}, "default")
ESTIMATED = {"LUT": 11000, "FF": 6100, "DSP": 7, "BRAM": 14}


def test_numbers() -> None:
    found = report(DESIGN, find("ecp5-25"), SYNTHESIS, ROUTES, ESTIMATED)
    assert json.loads(json.dumps(found, allow_nan=False)) == found
    assert found["resources"]["LUT"] == {"used": 12144, "available": 24288, "percent": 50.0, "estimated": 11000}
    assert found["resources"]["DSP"]["percent"] == 25.0
    clock, times, cycles = found["clock"], found["timing"], Parallel(DESIGN)
    assert (clock["lowest_mhz"], clock["median_mhz"], clock["highest_mhz"]) == (90.0, 100.0, 125.0)
    assert clock["critical_path"]["begin"] == "sweep"
    assert times["latency_cycles"] == cycles.latency
    assert times["frame_latency_us"] == pytest.approx(cycles.frame_latency / 100)
    assert times["frames_per_second"] == pytest.approx(1e8 / cycles.initiation_interval, abs=0.1)
    assert times["mac_utilisation"] == pytest.approx(DESIGN.multiplications / 4 / cycles.initiation_interval, abs=1e-4)


def test_a_serial_core() -> None:
    design = replace(DESIGN, architecture=SERIAL)
    found = report(design, find("ecp5-25"), SYNTHESIS, ROUTES, ESTIMATED)
    cycles = Serial(design)
    assert (found["architecture"]["kind"], found["mac_lanes"]) == ("serial", 3)
    assert found["timing"]["latency_cycles"] == cycles.latency
    assert found["timing"]["frames_per_second"] == pytest.approx(1e8 / cycles.initiation_interval, abs=0.1)
    assert "skin on ecp5-25-6: serial core, 3 MAC lanes" in render(found)


def test_the_median_is_a_seed() -> None:
    assert median_route(ROUTES).seed == 1
    assert median_route(ROUTES[:2]).seed == 2
    assert median_route([replace(ROUTES[0], seed=9)]).seed == 9


def test_text() -> None:
    text = render(report(DESIGN, find("ecp5-25"), SYNTHESIS, ROUTES, ESTIMATED))
    for part in ("skin on ecp5-25-6", "12,144", "24,288", "50.0", "median 100.0 MHz, 90.0 to 125.0", "sweep to matvec"):
        assert part in text
    assert "ABC9" not in text
    assert max(map(len, text.splitlines())) <= WIDTH


def test_counts_alone() -> None:
    found = report(DESIGN, find("xc7"), replace(SYNTHESIS, mapper="abc"), [], ESTIMATED)
    assert found["clock"] is None
    assert "frames_per_second" not in found["timing"]
    assert found["resources"]["LUT"]["available"] is None
    text = render(found)
    assert "only yosys runs" in text
    assert "ABC9 aborted" in text
