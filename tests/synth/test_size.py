"""Sizing: a core against brute force over its timing."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from tests.marks import long
from tfra.hdl.cores import microarchitecture
from tfra.model.choices import VECTOR_WORDS, Architecture, Search
from tfra.model.fixed.design import Design
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.sensor import SensorArray
from tfra.synth import size as module
from tfra.synth.size import Bounds, Speed, size, speed
from tfra.synth.targets import find

DESIGN = TfraDesign(SensorArray(3, 4, 4e-3, 2e-3, 3e-3), search=Search(12), architecture=Architecture(4))
TARGET = find("ecp5-85")


def test_choices() -> None:
    assert microarchitecture(DESIGN).lane_choices == (4, 8, 12, 16)
    for lanes in microarchitecture(DESIGN).lane_choices:
        replace(DESIGN, architecture=Architecture(lanes))


@pytest.fixture
def cheap(monkeypatch: pytest.MonkeyPatch) -> None:
    """Prices without elaborating any core: 100 lookup tables a lane, 10 a word, and block memories that lanes share."""

    def cost(design: Design, family: object) -> Any:
        class Total:
            total = {  # noqa: RUF012  # a stand-in for an Estimate
                **dict.fromkeys(("FF", "DSP"), 1),
                "BRAM": 40 // design.architecture.mac_lanes,
                "LUT": 100 * design.architecture.mac_lanes + 10 * design.architecture.vector_words,
            }

        return Total

    monkeypatch.setattr(module, "estimate", cost)


@pytest.mark.parametrize(("fps", "latency"), [(5e4, 30.0), *long((1e3, 1e4), (1e5, 1e3), (1e3, 11.0), (1.5e5, 12.0))])
def test_the_cheapest_core(cheap: None, fps: float, latency: float) -> None:
    bounds = Bounds(100.0, fps, latency)
    every = [Architecture(lanes, words) for lanes in microarchitecture(DESIGN).lane_choices for words in VECTOR_WORDS]
    reached = {architecture: speed(replace(DESIGN, architecture=architecture)) for architecture in every}
    fast = [architecture for architecture, found in reached.items() if not found.misses(bounds)]
    if not fast:
        with pytest.raises(ValueError, match="is the best"):
            size(DESIGN, TARGET, bounds)
        return
    found = size(DESIGN, TARGET, bounds)
    cheapest = min(fast, key=lambda architecture: (architecture.mac_lanes, architecture.vector_words))
    assert (found.architecture, found.speed) == (cheapest, reached[cheapest])


def test_bounds_out_of_reach(cheap: None) -> None:
    best, lanes = r"[\d.]+ is the best", "at 100 MHz with 16 MAC lanes"
    with pytest.raises(ValueError, match=rf"^frames_per_second: 1e\+09 are wanted, {best}, {lanes}$"):
        size(DESIGN, TARGET, Bounds(100.0, 1e9, 1e3))
    with pytest.raises(ValueError, match=rf"^latency_us: 0.1 is wanted, {best}, {lanes}$"):
        size(DESIGN, TARGET, Bounds(100.0, 1.0, 0.1))


def test_nothing_fits(cheap: None) -> None:
    tiny = replace(TARGET, name="tiny", available={"LUT": 90, "DSP": 1})
    with pytest.raises(ValueError, match=r"^LUT: about 410 are needed, tiny has 90, for the smallest core"):
        size(DESIGN, tiny, Bounds(100.0, 1.0, 1e6))


@pytest.mark.long
def test_more_lanes_for_fewer_memories(cheap: None) -> None:
    shallow = replace(TARGET, name="shallow", available={"LUT": 1000, "BRAM": 5})
    assert size(DESIGN, shallow, Bounds(100.0, 1.0, 1e6)).architecture.mac_lanes == 8
    both = replace(TARGET, name="both", available={"LUT": 500, "BRAM": 5})
    with pytest.raises(ValueError, match=r"^BRAM: about 10 are needed, both has 5, for the smallest core"):
        size(DESIGN, both, Bounds(100.0, 1.0, 1e6))


def test_misses() -> None:
    found = Speed(interval=1000, frame_latency=2000)
    assert found.misses(Bounds(100.0, 1e5, 20.0)) == []
    assert found.misses(Bounds(100.0, 100001, 19.9)) == [
        "frames_per_second: 100001 are wanted, 100000.0 is the best",
        "latency_us: 19.9 is wanted, 20.000 is the best",
    ]
