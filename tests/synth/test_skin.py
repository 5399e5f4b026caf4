"""Sizes, estimates and reports of skins: those of the window's core, and of what is around it."""

from dataclasses import replace

import pytest

from tests.hdl.skin.skins import learned_window, skin_of, small_window
from tfra.families import find
from tfra.hdl.cores import microarchitecture
from tfra.hdl.ip.wrapper import skin_interval, skin_latencies
from tfra.hdl.skin.timing import SkinTiming
from tfra.model.choices import SERIAL
from tfra.synth.candidates import Bounds, Speed
from tfra.synth.estimate import estimate
from tfra.synth.flow import CriticalPath, Route, Synthesis
from tfra.synth.page import page, render
from tfra.synth.report import report
from tfra.synth.size import size

SKIN = skin_of(12, 20, small_window(), most=3)
PART = find("ecp5-45")


@pytest.mark.parametrize("window", [small_window(), replace(small_window(), architecture=SERIAL)])
def test_an_estimate_has_the_core_and_more(window) -> None:
    """Blocks of the window's core cost what they cost alone."""
    whole, alone = estimate(skin_of(12, 20, window, most=3), PART.family), estimate(window, PART.family)
    for block in alone.blocks.keys() - {"top"}:
        assert whole.blocks[block] == alone.blocks[block], block
    more = whole.blocks.keys() - alone.blocks.keys()
    assert {"windows", "records", "smoothing", "peaks", "finding", "places"} <= more
    assert all(whole.total[name] > alone.total[name] for name in ("LUT", "FF", "BRAM"))


def test_times_follow_from_taxels_finding_or_forces() -> None:
    small = SkinTiming.of(SKIN)
    assert small.interval == max(240, small.finding, small.forces)
    wide = SkinTiming.of(replace(SKIN, sensor=replace(SKIN.sensor, rows=128, columns=128)))
    assert wide.interval == 128 * 128
    slow = SkinTiming.of(skin_of(12, 20, replace(small_window(), architecture=SERIAL), most=3))
    assert slow.interval == slow.forces == 3 * slow.core.initiation_interval
    assert slow.frame_latency == slow.peaks + slow.finding + slow.forces + slow.core.frame_latency


@pytest.mark.long
def test_the_smallest_that_is_fast_enough() -> None:
    """Twice as many contacts need a faster core of the window."""
    few, many = skin_of(32, 32, learned_window(), most=4), skin_of(32, 32, learned_window(), most=8)
    bounds = Bounds(100.0, 10_000.0, 1e4)
    found = [size(skin, PART, bounds).chosen for skin in (few, many)]
    for skin, core in zip((few, many), found, strict=True):
        assert core.design
        assert core.speed == Speed.of(microarchitecture(core.design), 100.0, skin)
        assert core.speed.frames_per_second >= 10_000
        assert core.resources == estimate(replace(skin, window=core.design), PART.family).total
    assert found[1].architecture.mac_lanes > found[0].architecture.mac_lanes


@pytest.mark.parametrize("package", [False, True])
def test_the_report_says_what_a_frame_is(package: bool) -> None:
    """Of the core, and behind its buses."""
    cells = dict.fromkeys(PART.family.cells, 1)
    path = CriticalPath("finding", "finding", "core.a", "core.b", 1.0, 2.0)
    routes = [Route(1, 100.0, cells, path)]
    stated = report(
        SKIN,
        PART,
        Synthesis(cells, {"LUT4": 1}, "default"),
        routes,
        estimate(SKIN, PART.family, package=package),
        1,
        package=package,
        netlist="",
        asked_mhz=100.0,
    )
    timing, known = stated["timing"], SkinTiming.of(SKIN)
    assert (timing["contacts"], timing["taxels_of_a_contact"]) == (3, 2)
    cycles = (skin_interval(known), skin_latencies(known)[1]) if package else (known.interval, known.frame_latency)
    assert (timing["interval_cycles"], timing["frame_latency_cycles"]) == cycles
    assert stated["name"].endswith("_axi") == package
    assert ("wrapper" in stated["estimated_blocks"]) == package
    assert timing["frames_per_second"] == pytest.approx(1e8 / cycles[0], abs=0.1)
    assert all("contacts of a frame" in text for text in (render(stated), page(stated)))
