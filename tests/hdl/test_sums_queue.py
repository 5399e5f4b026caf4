"""SumsQueue: two products' quads in the order of their frames, however far one is ahead of the other."""

from __future__ import annotations

import random

import pytest
from amaranth import Module
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out, connect, flipped

from tests.hdl.harness import PATTERNS, run
from tfra.hdl.combine_store import FRAMES
from tfra.hdl.payloads import vector_quad
from tfra.hdl.streams import Router
from tfra.hdl.sums_queue import ROWS, SumsQueue
from tfra.model.design import Architecture, Design
from tfra.model.sensor import SensorArray

DESIGN = Design(SensorArray(2, 3, 4e-3, 2e-3, 3e-3), architecture=Architecture(1))


class Routed(wiring.Component):
    """Both products come one quad at a time, as from the router of the core."""

    def __init__(self):
        shape = data.StructLayout({"words": vector_quad(DESIGN), "kind": 2})
        super().__init__({"i": In(stream.Signature(shape)), "o": Out(stream.Signature(vector_quad(DESIGN)))})

    def elaborate(self, platform):
        m = Module()
        m.submodules.router = router = Router(self.i.payload.shape(), [[0], [1]], 2)
        m.submodules.sums = sums = SumsQueue(DESIGN)
        connect(m, flipped(self.i), router.i)
        connect(m, router.o[0], sums.b)
        connect(m, router.o[1], sums.n)
        connect(m, sums.o, flipped(self.o))
        return m


def order(frames, seed):
    """Kinds of quads: b of a frame before its n, at most ``FRAMES`` frames ahead of what is read."""
    rng, kinds, b, n = random.Random(seed), [], 0, 0
    while n < frames:
        if b < frames and b - n < FRAMES and (b == n or rng.random() < 0.6):
            kinds, b = [*kinds, 0], b + 1
        else:
            kinds, n = [*kinds, *[1] * (ROWS - 1)], n + 1
    return kinds


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("stall_in", PATTERNS)
@pytest.mark.parametrize("stall_out", PATTERNS)
def test_quads_leave_in_the_order_of_their_frames(stall_in, stall_out, seed):
    frames, rng = 20, random.Random(seed)
    kinds = order(frames, seed)
    quads = [{"words": [rng.randrange(-1000, 1000) for _ in range(4)], "kind": 1 << kind} for kind in kinds]
    b, n = ([quad["words"] for quad in quads if quad["kind"] == 1 << kind] for kind in (0, 1))
    want = [quad for k in range(frames) for quad in (b[k], *n[(ROWS - 1) * k : (ROWS - 1) * (k + 1)])]
    seen = run(Routed(), {"i": quads}, {"o": len(want)}, stall_in=stall_in, stall_out=stall_out, seed=seed)
    assert seen.values["o"] == want


def test_latency():
    quads = [{"words": [k] * 4, "kind": 1 << kind} for k, kind in enumerate([0, 1, 1, 1] * 5)]
    cycles = run(Routed(), {"i": quads}, {"o": len(quads)}).cycles
    assert {out - into for into, out in zip(cycles["i"], cycles["o"], strict=True)} == {SumsQueue.latency}


def test_there_is_room_for_the_frames_in_flight_and_no_more():
    """Without the other product nothing leaves but what the output holds."""
    b, n = ({"words": [kind] * 4, "kind": 1 << kind} for kind in (0, 1))
    assert len(run(Routed(), {"i": [*[b] * (FRAMES + 1), *[n] * 3]}, {"o": 5}).values["o"]) == 5
    with pytest.raises(AssertionError, match="no end"):
        run(Routed(), {"i": [*[b] * (FRAMES + 2), *[n] * 3]}, {"o": 5}, limit=200)
