"""Fork, Router, FIFOs, tokens and the skid buffer keep order and lose nothing under any stalls."""

from functools import partial
from itertools import pairwise

import pytest
from amaranth import Module, signed, unsigned
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from tests.marks import STALLS
from tfra.hdl.lib.streams import TOKEN, Fifo, Fork, PerFrameFifo, Router, SkidBuffer, Tokens
from tfra.sim.harness import PATTERNS, run


@pytest.mark.parametrize(("stall_in", "stall_out"), STALLS)
def test_every_sink_of_a_fork_sees_everything(stall_in, stall_out):
    values = list(range(60))
    seen = run(
        Fork(unsigned(8), 3), {"i": values}, {f"o.{k}": 60 for k in range(3)}, stall_in=stall_in, stall_out=stall_out
    )
    assert all(seen.values[f"o.{k}"] == values for k in range(3))


@pytest.mark.parametrize("stall_in", PATTERNS)
def test_router_sends_every_kind_where_its_table_says(stall_in):
    router = Router(data.StructLayout({"words": unsigned(8), "kind": unsigned(3)}), [[0], [0, 1], [1]], 2)
    quads = [{"words": number, "kind": 1 << number % 3} for number in range(12)]
    seen = run(router, {"i": quads}, {"o.0": 8, "o.1": 8}, stall_in=stall_in)
    assert seen.values["o.0"] == [n for n in range(12) if n % 3 != 2]
    assert seen.values["o.1"] == [n for n in range(12) if n % 3 != 0]
    assert seen.cycles["o.0"] == [cycle + Router.latency for n, cycle in enumerate(seen.cycles["i"]) if n % 3 != 2]


QUEUES = {
    "skid": (partial(SkidBuffer, unsigned(12)), 1, 1),
    "facts": (partial(PerFrameFifo, unsigned(12), (), 3), PerFrameFifo.latency, 1),
    **{f"{parts} parts": (partial(Fifo, unsigned(12), 5, parts), Fifo.latency, parts) for parts in (1, 2, 4)},
}
"""What gives out what it takes, its latency and its interval."""


@pytest.mark.parametrize("queue", QUEUES)
@pytest.mark.parametrize(("stall_in", "stall_out"), STALLS)
def test_queues_keep_order(queue, stall_in, stall_out):
    values = [number * 2654435761 % 4096 for number in range(40)]
    seen = run(QUEUES[queue][0](), {"i": values}, {"o": 40}, stall_in=stall_in, stall_out=stall_out)
    assert seen.values["o"] == values


@pytest.mark.parametrize("queue", QUEUES)
def test_cycles_of_queues(queue):
    make, latency, interval = QUEUES[queue]
    seen = run(make(), {"i": list(range(9))}, {"o": 9})
    assert seen.cycles["o"] == [cycle + latency for cycle in seen.cycles["i"]]
    assert [b - a for a, b in pairwise(seen.cycles["i"])] == [interval] * 8


@pytest.mark.parametrize(("stall_in", "stall_out"), STALLS)
def test_facts_keep_order_and_only_their_fields(stall_in, stall_out):
    shape = data.StructLayout({"mu": signed(7), "flag": 1, "rest": 5})
    values = [{"mu": number - 20, "flag": number & 1, "rest": number % 32} for number in range(40)]
    facts = PerFrameFifo(shape, ("mu", "flag"), 4)
    seen = run(facts, {"i": values}, {"o": 40}, stall_in=stall_in, stall_out=stall_out)
    assert seen.values["o"] == [value | {"rest": 0} for value in values]


def test_tokens_are_as_many_as_were_given():
    """Three at first; two pulses make one; no more than three are kept."""

    class Taken(wiring.Component):
        def __init__(self):
            self.tokens = Tokens(3, every=2)
            super().__init__({"give": In(stream.Signature(1)), "o": Out(stream.Signature(TOKEN))})

        def elaborate(self, platform):
            m = Module()
            m.submodules.tokens = self.tokens
            m.d.comb += [self.give.ready.eq(1), self.tokens.give.eq(self.give.valid)]
            wiring.connect(m, self.tokens.o, wiring.flipped(self.o))
            return m

    assert len(run(Taken(), {"give": [1] * 8}, {"o": 7}).values["o"]) == 7
    with pytest.raises(AssertionError, match="no end"):
        run(Taken(), {"give": [1] * 8}, {"o": 8}, limit=200)
    with pytest.raises(AssertionError, match="no end"):
        run(Taken(), {}, {"o": 4}, limit=200)
