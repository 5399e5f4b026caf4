"""SumsQueue: two products' quads in the order of their frames, however far one is ahead of the other."""

import itertools
import random

import numpy as np
import pytest
from amaranth.lib import data

from tests.hdl.parallel.designs import Joined, make
from tests.marks import STALLS
from tfra.hdl.lib.streams import Router
from tfra.hdl.parallel.payloads import vector_quad
from tfra.hdl.parallel.tfra.combine.store import FRAMES
from tfra.hdl.parallel.tfra.sums_queue import ROWS, SumsQueue
from tfra.sim.harness import run

DESIGN = make(2, 3)


def routed():
    """Both products come one quad at a time, as from the router of the core."""
    shape = data.StructLayout({"words": vector_quad(DESIGN), "kind": 2})
    wires = [("router.o.0", "sums.b"), ("router.o.1", "sums.n")]
    return Joined(wires, router=Router(shape, [[0], [1]], 2), sums=SumsQueue(DESIGN))


def order(frames, seed):
    """Kinds of quads: b of a frame before its n, at most ``FRAMES`` frames ahead."""
    rng, kinds, b, n = random.Random(seed), [], 0, 0
    while n < frames:
        if b < frames and b - n < FRAMES and (b == n or rng.random() < 0.6):
            kinds, b = [*kinds, 0], b + 1
        else:
            kinds, n = [*kinds, *[1] * (ROWS - 1)], n + 1
    return kinds


def in_flight(kinds):
    """Leave to send: the frame's place has been read to its end."""
    seen = [0, 0]
    frames = []
    for kind in kinds:
        frames.append(seen[kind] // (ROWS - 1 if kind else 1))
        seen[kind] += 1
    return lambda number, record, cycle: len(record.cycles["sums.o"]) // ROWS > frames[number] - FRAMES


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(("stall_in", "stall_out"), STALLS)
def test_quads_leave_in_the_order_of_their_frames(stall_in, stall_out, seed):
    frames, rng = 20, random.Random(seed)
    kinds = order(frames, seed)
    quads = [{"words": [rng.randrange(-1000, 1000) for _ in range(4)], "kind": 1 << kind} for kind in kinds]
    b, n = ([quad["words"] for quad in quads if quad["kind"] == 1 << kind] for kind in (0, 1))
    want = [quad for k in range(frames) for quad in (b[k], *n[(ROWS - 1) * k : (ROWS - 1) * (k + 1)])]
    how = {"stall_in": stall_in, "stall_out": stall_out, "seed": seed, "leave": {"router.i": in_flight(kinds)}}
    seen = run(routed(), {"router.i": quads}, {"sums.o": len(want)}, **how)
    assert seen.values["sums.o"] == want


def test_latency():
    quads = [{"words": [k] * 4, "kind": 1 << kind} for k, kind in enumerate([0, 1, 1, 1] * FRAMES)]
    latency = Router.latency + SumsQueue.latency
    at_once = run(routed(), {"router.i": quads}, {"sums.o": len(quads)}).cycles
    assert at_once["sums.o"][0] - at_once["router.i"][0] == latency
    assert set(np.diff(at_once["sums.o"])) == {SumsQueue.interval}

    def apart(_):
        while True:
            yield from [False, *[True] * SumsQueue.interval]

    cycles = run(routed(), {"router.i": quads}, {"sums.o": len(quads)}, stall_in=apart).cycles
    assert {out - into for into, out in zip(cycles["router.i"], cycles["sums.o"], strict=True)} == {latency}


def test_there_is_room_for_the_frames_in_flight():
    """All of them come before the first is read."""

    def late(_):
        yield from [True] * 100
        yield from itertools.repeat(False)

    kinds = [0, 1, 1, 1] * FRAMES
    quads = [{"words": [k] * 4, "kind": 1 << kind} for k, kind in enumerate(kinds)]
    seen = run(routed(), {"router.i": quads}, {"sums.o": len(quads)}, stall_out=late)
    assert seen.cycles["router.i"][-1] < 100 < seen.cycles["sums.o"][0]
    assert seen.values["sums.o"] == [quad["words"] for quad in quads]
