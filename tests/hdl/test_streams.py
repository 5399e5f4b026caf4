"""Fork, Router, Merge and the spare register keep order and lose nothing under any stalls."""

from __future__ import annotations

import pytest
from amaranth import unsigned

from tests.hdl.harness import PATTERNS, run
from tfra.hdl.streams import Fork, Merge, Router, Spare


@pytest.mark.parametrize("stall_in", PATTERNS)
@pytest.mark.parametrize("stall_out", PATTERNS)
def test_every_sink_of_a_fork_sees_everything(stall_in, stall_out):
    values = list(range(60))
    seen = run(
        Fork(unsigned(8), 3), {"i": values}, {f"o.{k}": 60 for k in range(3)}, stall_in=stall_in, stall_out=stall_out
    )
    assert all(seen.values[f"o.{k}"] == values for k in range(3))


@pytest.mark.parametrize("stall_out", PATTERNS)
def test_router_follows_its_table_over_frames(stall_out):
    router = Router(unsigned(8), [(2, [0]), (1, [0, 1]), (3, [1])], 2)
    seen = run(router, {"i": list(range(12))}, {"o.0": 6, "o.1": 8}, stall_out=stall_out)
    assert seen.values["o.0"] == [0, 1, 2, 6, 7, 8]
    assert seen.values["o.1"] == [2, 3, 4, 5, 8, 9, 10, 11]


@pytest.mark.parametrize("stall_in", PATTERNS)
def test_merge_takes_turns_as_told(stall_in):
    merge = Merge(unsigned(8), [(1, 1), (2, 0)], 2)
    seen = run(merge, {"i.0": [1, 2, 3, 4], "i.1": [11, 12]}, {"o": 6}, stall_in=stall_in)
    assert seen.values["o"] == [11, 1, 2, 12, 3, 4]


@pytest.mark.parametrize("stall_in", PATTERNS)
@pytest.mark.parametrize("stall_out", PATTERNS)
def test_a_spare_place_keeps_order_under_stalls(stall_in, stall_out):
    values = list(range(60))
    seen = run(Spare(unsigned(8)), {"i": values}, {"o": 60}, stall_in=stall_in, stall_out=stall_out)
    assert seen.values["o"] == values


def test_a_spare_place_costs_a_cycle_and_no_throughput():
    seen = run(Spare(unsigned(8)), {"i": list(range(20))}, {"o": 20})
    assert [o - i for i, o in zip(seen.cycles["i"], seen.cycles["o"], strict=True)] == [1] * 20
