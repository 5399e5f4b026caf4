"""Sizing: the staircase against every pair, and a core against brute force over its timing."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tfra.model.design import Architecture, Design, Search
from tfra.model.sensor import SensorArray
from tfra.synth import size as module
from tfra.synth.size import Bounds, Speed, mac_choices, size, speed, staircase, sweep_choices
from tfra.synth.targets import find

DESIGN = Design(SensorArray(3, 4, 4e-3, 2e-3, 3e-3), search=Search(12), architecture=Architecture(4, 1))
TARGET = find("ecp5-85")


@given(st.lists(st.integers(0, 8), min_size=1, max_size=9))
def test_the_staircase_is_every_smallest_pair(steps: list[int]) -> None:
    """``need[i]`` sweep lanes are enough with MAC lanes ``i``: any falling function of them, down to its end."""
    need = sorted(steps, reverse=True)
    macs, sweeps = list(range(10, 10 + len(need))), list(range(need[-1], 9))
    good = {(mac, s) for mac, low in zip(macs, need, strict=True) for s in sweeps if s >= low}
    corners = {
        (mac, s)
        for mac, s in good
        if not any((a, b) in good and a <= mac and b <= s and (a, b) != (mac, s) for a in macs for b in sweeps)
    }
    found = staircase(macs, sweeps, lambda mac, sweep: (mac, sweep) in good)
    assert {(choice.mac_lanes, choice.sweep_lanes) for choice in found} == corners


def test_choices() -> None:
    assert mac_choices(DESIGN) == [1, 2, 4, 8, 12, 16]
    assert sweep_choices(DESIGN) == [1, 2, 3, 4, 5, 7, 13]  # of 13 candidates: 13, 7, 5, 4, 3, 3, 2 ... passes
    for lanes in mac_choices(DESIGN):
        replace(DESIGN, architecture=Architecture(lanes, 1))


@pytest.fixture
def cheap(monkeypatch: pytest.MonkeyPatch) -> None:
    """Prices of lanes without elaborating any core: 100 and 300 lookup tables."""

    def cost(design: Design, family: object) -> Any:
        class Total:
            total = {  # noqa: RUF012  # a stand-in for an Estimate
                **dict.fromkeys(("FF", "DSP", "BRAM"), 1),
                "LUT": 100 * design.architecture.mac_lanes + 300 * design.architecture.sweep_lanes,
            }

        return Total

    monkeypatch.setattr(module, "estimate", cost)


@pytest.mark.parametrize(("fps", "latency"), [(1e3, 1e4), (5e4, 30.0), (1e5, 1e3), (1e3, 11.0), (1.5e5, 12.0)])
def test_the_cheapest_core(cheap: None, fps: float, latency: float) -> None:
    bounds = Bounds(100.0, fps, latency)
    reached = {
        (mac, sweep): speed(replace(DESIGN, architecture=Architecture(mac, sweep)))
        for mac in mac_choices(DESIGN)
        for sweep in sweep_choices(DESIGN)
    }
    fast = [lanes for lanes, found in reached.items() if not found.misses(bounds)]
    if not fast:
        with pytest.raises(ValueError, match="is the best"):
            size(DESIGN, TARGET, bounds)
        return
    best = min(100 * mac + 300 * sweep for mac, sweep in fast)
    found = size(DESIGN, TARGET, bounds)
    assert found.resources["LUT"] == best
    assert found.speed == reached[found.architecture.mac_lanes, found.architecture.sweep_lanes]


def test_bounds_out_of_reach(cheap: None) -> None:
    best, lanes = r"[\d.]+ is the best", "at 100 MHz with 16 MAC and 13 sweep lanes"
    with pytest.raises(ValueError, match=rf"^frames_per_second: 1e\+09 are wanted, {best}, {lanes}$"):
        size(DESIGN, TARGET, Bounds(100.0, 1e9, 1e3))
    with pytest.raises(ValueError, match=rf"^latency_us: 0.1 is wanted, {best}, {lanes}$"):
        size(DESIGN, TARGET, Bounds(100.0, 1.0, 0.1))


def test_nothing_fits(cheap: None) -> None:
    tiny = replace(TARGET, name="tiny", available={"LUT": 100, "DSP": 1})
    with pytest.raises(ValueError, match=r"^LUT: about 400 are needed, tiny has 100, for the smallest core"):
        size(DESIGN, tiny, Bounds(100.0, 1.0, 1e6))


def test_misses() -> None:
    found = Speed(interval=1000, frame_latency=2000)
    assert found.misses(Bounds(100.0, 1e5, 20.0)) == []
    assert found.misses(Bounds(100.0, 100001, 19.9)) == [
        "frames_per_second: 100001 are wanted, 100000.0 is the best",
        "latency_us: 19.9 is wanted, 20.000 is the best",
    ]
