"""Plumbing between blocks: streams of ``amaranth.lib.stream`` are split, merged and routed here.

Per-frame facts travel as streams with one transfer a frame.  A block may look at such a transfer for as long as
it needs it and takes it (``ready``) in the last cycle of use, so the sender holds it and no block keeps a copy.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from amaranth import Cat, Elaboratable, Module, Mux, Shape, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.fifo import SyncFIFOBuffered
from amaranth.lib.wiring import In, Out

from tfra.hdl.arithmetic import count


class Router(wiring.Component):
    """Send the transfers of a frame to the sinks that a static table names.

    Arguments:
        table: pairs ``(transfers, sinks)`` in order; a frame is all of them, then the table starts anew.
        ways: number of sinks.

    Members: ``i``: stream in; ``o``: ``ways`` streams out.  Combinational; each sink takes a transfer at its own
    time, and the transfer ends with the last of them.
    """

    def __init__(self, shape: Any, table: Sequence[tuple[int, Sequence[int]]], ways: int) -> None:
        self._table, self._ways = [(n, tuple(sinks)) for n, sinks in table], ways
        super().__init__({"i": In(stream.Signature(shape)), "o": Out(stream.Signature(shape)).array(ways)})

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.turn = turn = _Turn([n for n, _ in self._table])
        sinks, taken, done = (Signal(self._ways, name=name) for name in ("sinks", "taken", "done"))
        with m.Switch(turn.step):
            for number, (_, names) in enumerate(self._table):
                with m.Case(number):
                    m.d.comb += sinks.eq(sum(1 << way for way in names))
        for way, o in enumerate(self.o):
            m.d.comb += [
                o.payload.eq(self.i.payload),
                o.valid.eq(self.i.valid & sinks[way] & ~taken[way]),
                done[way].eq(taken[way] | o.ready | ~sinks[way]),
            ]
        m.d.comb += [self.i.ready.eq(done.all()), turn.transfer.eq(self.i.valid & self.i.ready)]
        with m.If(self.i.valid):
            m.d.sync += taken.eq(Mux(done.all(), 0, done & sinks))
        return m


class Fork(Router):
    """Hand every transfer to all of ``ways`` sinks, each at its own time.

    Members: ``i``: stream in; ``o``: ``ways`` streams out.  Combinational from valid to valid; a transfer ends
    when the last sink has taken it.
    """

    def __init__(self, shape: Any, ways: int) -> None:
        super().__init__(shape, [(1, range(ways))], ways)


class Merge(wiring.Component):
    """Take ``n`` transfers from input ``way`` for each ``(n, way)`` of ``order`` in turn, over and over.

    Members: ``i``: streams in; ``o``: stream out.  Combinational.
    """

    def __init__(self, shape: Any, order: Sequence[tuple[int, int]], ways: int) -> None:
        self._order = list(order)
        super().__init__({"i": In(stream.Signature(shape)).array(ways), "o": Out(stream.Signature(shape))})

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.turn = turn = _Turn([n for n, _ in self._order])
        with m.Switch(turn.step):
            for number, (_, way) in enumerate(self._order):
                with m.Case(number):
                    m.d.comb += [
                        self.o.payload.eq(self.i[way].payload),
                        self.o.valid.eq(self.i[way].valid),
                        self.i[way].ready.eq(self.o.ready),
                    ]
        m.d.comb += turn.transfer.eq(self.o.valid & self.o.ready)
        return m


class _Turn(Elaboratable):
    """Which entry of a cyclic table of transfer counts it is the turn of."""

    def __init__(self, counts: Sequence[int]) -> None:
        self._counts = list(counts)
        self.transfer = Signal()
        self.step = Signal(count(len(counts) - 1))

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        done = Signal(count(max(self._counts) - 1))
        with m.If(self.transfer):
            m.d.sync += done.eq(done + 1)
            with m.Switch(self.step):
                for number, transfers in enumerate(self._counts):
                    with m.Case(number), m.If(done == transfers - 1):
                        m.d.sync += [done.eq(0), self.step.eq((number + 1) % len(self._counts))]
        return m


class Buffer(wiring.Component):
    """Hold one transfer, so that its sender is free while the sink still needs it.

    Members: ``i``: stream in; ``o``: stream out, registered.  A new transfer enters when the last one has left:
    meant for per-frame facts, not for full throughput.  ``latency`` is one cycle.
    """

    latency = 1

    def __init__(self, shape: Any) -> None:
        super().__init__({"i": In(stream.Signature(shape)), "o": Out(stream.Signature(shape))})

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        payload = Signal(self.i.payload.shape(), reset_less=True)
        full = Signal()
        m.d.comb += [self.i.ready.eq(~full), self.o.valid.eq(full), self.o.payload.eq(payload)]
        with m.If(~full):
            m.d.sync += [full.eq(self.i.valid), payload.eq(self.i.payload)]
        with m.Elif(self.o.ready):
            m.d.sync += full.eq(0)
        return m


class Spare(wiring.Component):
    """Stream register with a spare place: neither ``i.ready`` nor ``o.valid`` depends on an input.

    Members: ``i``: stream in; ``o``: stream out, a cycle later.
    """

    def __init__(self, shape: Any) -> None:
        super().__init__({"i": In(stream.Signature(shape)), "o": Out(stream.Signature(shape))})

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        used, kept = Signal(), Signal.like(self.i.p, reset_less=True)
        m.d.comb += self.i.ready.eq(~used)
        with m.If(~self.o.valid | self.o.ready):
            m.d.sync += [self.o.valid.eq(self.i.valid | used), used.eq(0), self.o.p.eq(Mux(used, kept, self.i.p))]
        with m.Elif(~used):
            m.d.sync += [used.eq(self.i.valid), kept.eq(self.i.p)]
        return m


def one_at_a_time(m: Module, enter: Any, facts: Iterable[Any], leave: Any, last: int) -> tuple[Signal, Signal]:
    """Cycle of a block that works on one transfer at a time, and whether it has one.

    ``enter`` is taken while the block is not busy; cycle 0 lasts until all streams of ``facts`` are valid; behind
    cycle ``last`` stream ``leave`` is valid until it is taken.
    """
    busy, valid, cycle = Signal(), Signal(), Signal(count(last))
    m.d.comb += [enter.ready.eq(~busy), leave.valid.eq(valid)]
    with m.If(~busy):
        m.d.sync += busy.eq(enter.valid)
    with m.Elif(cycle == last):
        m.d.sync += [cycle.eq(0), valid.eq(1)]
    with m.Elif(cycle != 0):
        m.d.sync += cycle.eq(cycle + 1)
    with m.Elif(~valid):
        m.d.sync += cycle.eq(Cat(fact.valid for fact in facts).all())
    with m.Elif(leave.ready):
        m.d.sync += [busy.eq(0), valid.eq(0)]
    return cycle, busy


class Queue(wiring.Component):
    """First in, first out, ``depth`` transfers long, in block memory.

    Members: ``i``: stream in; ``o``: stream out.  ``latency``: cycles through an empty queue; full throughput.
    """

    latency = 2

    def __init__(self, shape: Any, depth: int) -> None:
        self._depth = depth
        super().__init__({"i": In(stream.Signature(shape)), "o": Out(stream.Signature(shape))})

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.fifo = fifo = SyncFIFOBuffered(width=Shape.cast(self.i.payload.shape()).width, depth=self._depth)
        m.d.comb += [
            fifo.w_data.eq(self.i.payload),
            fifo.w_en.eq(self.i.valid),
            self.i.ready.eq(fifo.w_rdy),
            self.o.payload.eq(fifo.r_data),
            self.o.valid.eq(fifo.r_rdy),
            fifo.r_en.eq(self.o.ready),
        ]
        return m
