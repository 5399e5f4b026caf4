"""The campaign behind AXI: what it sends, what it expects, and that it notices what is wrong."""

import re
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from bench.exactness.axi import differences, run, traffic, verilog
from bench.exactness.designs import untrained
from bench.publish import ROOT
from tfra.codegen.config.read import load
from tfra.codegen.verilog.wrapper import module_name
from tfra.hdl.cores import microarchitecture
from tfra.hdl.ip.wrapper import cut_through, latencies
from tfra.model.choices import Architecture, Bus
from tfra.model.fixed.design import Design

Texts = dict[str, str]


@cache
def small(per_beat: int = 1) -> Design:
    return untrained(4, 4, (6, 4), architecture=Architecture(16), bus=Bus(per_beat))


@cache
def texts(per_beat: int = 1) -> Texts:
    return verilog(small(per_beat))


@pytest.mark.parametrize("per_beat", [1, 4])
def test_traffic_has_every_kind_of_frame(per_beat: int) -> None:
    design = small(per_beat)
    frames, whole = traffic(design, 300, 3), 16 // per_beat
    lengths = np.array([len(beats) for _, beats in frames.sent])
    assert min((lengths == 1).sum(), (lengths < whole).sum(), (lengths > whole).sum()) > 10
    assert frames.counters["FRAMES_IN"] == (lengths == whole).sum() == len(frames.answers)
    assert frames.counters["FRAMES_DROPPED"] == (lengths != whole).sum()
    heads = np.array([answer[:2] for answer in frames.answers])
    assert (heads[:, 0] & 0xFFFF).tolist() == np.flatnonzero(lengths == whole).tolist()
    assert all((heads[:, 1] >> bit & 1).any() for bit in (2, 5, 8))


def outcome(change: Callable[[Texts], Texts], count: int, cut: bool, simulator: str = "icarus") -> list[str]:
    frames = traffic(small(), count, 7)
    return differences(frames, run(small(), frames, simulator, change(texts()), 7, cut_through=cut))


@pytest.mark.long
@pytest.mark.parametrize(("count", "cut", "simulator"), [(100, False, "icarus"), (1000, True, "verilator")])
def test_all_words_and_counters(count: int, cut: bool, simulator: str) -> None:
    assert outcome(lambda given: given, count, cut, simulator) == []


@pytest.mark.long
@pytest.mark.parametrize(
    ("name", "cut"), [("small", False), ("balanced", True), ("learned_small", True), ("learned_fast", False)]
)
def test_a_frame_takes_the_stated_cycles(name: str, cut: bool) -> None:
    """Behind AXI: from the first taxel of a frame that is alone to its last result word."""
    design = replace(load(ROOT / "examples" / f"{name}.toml").design, target="portable")
    core, frames = microarchitecture(design), traffic(design, 1, 1, malformed=0)
    simulator = "icarus" if core.loaded is None else "verilator"
    found = run(design, frames, simulator, verilog(design), pauses=False, cut_through=cut)
    assert differences(frames, found) == []
    stated = (cut_through(core) if cut else latencies(core))[1]
    assert found["states"]["FRAME_CYCLES"] == design.sensor.taxels - 1 + stated


def in_wrapper(pattern: str, other: str) -> Callable[[Texts], Texts]:
    """A change of the first place in the wrapper that has the ``pattern``."""

    def change(given: Texts) -> Texts:
        name = f"{module_name(small())}.v"
        text, found = re.subn(pattern, other, given[name], count=1)
        assert found
        return given | {name: text}

    return change


@pytest.mark.long
@pytest.mark.parametrize(
    ("pattern", "other", "seen", "cut"),
    [
        (r"assign m_axis_tdata = (.*);", r"assign m_axis_tdata = \1 ^ (\1 == 32'd3);", "words, differing at", False),
        (r"(\.events__dropped\()[^)]*", r"\g<1>1'b0", "FRAMES_DROPPED is 0", False),
        (r"word <= \{ \w+, (\w+\[63:0\]) \};", r"word <= { 1'h0, \1 };", "frames came back", True),
    ],
)
def test_a_planted_error_is_noticed(pattern: str, other: str, seen: str, cut: bool) -> None:
    """The last one: the results of bad frames that were cut through are not marked."""
    found: Any = outcome(in_wrapper(pattern, other), 40, cut)
    assert any(seen in line for line in found), found
