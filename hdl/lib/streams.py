"""Components between streams: fork, router, buffer, FIFO, tokens and skid buffer.

Per-frame facts travel as streams with one transfer a frame.  A block reads such a transfer while it needs it and
accepts it (``ready``) in the last cycle of use, so the sender keeps the payload and no block stores a copy.
"""

from collections.abc import Iterable, Sequence
from typing import Any

from amaranth import Cat, Const, Module, Mux, Signal, Value, unsigned
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.arithmetic import counter_shape, nth_slice
from tfra.hdl.lib.pipeline import occupancy, occupancy_flags, register, wrapping_counter
from tfra.hdl.lib.ram import Ram

TOKEN = unsigned(1)
"""Payload of a token, without meaning; words without bits would not be portable Verilog."""


def always_ready_stream(shape: Any) -> stream.Signature:
    """A stream without backpressure: its sender takes a token for the place of each result before it starts.

    No pipeline on its path needs an enable, which would have to drive all its registers.  Where a quad is processed in
    beats, transfers are that many cycles apart, and payloads are held until then: see :mod:`tfra.hdl.parallel.beats`.
    """
    return stream.Signature(shape, always_ready=True)


class Fork(wiring.Component):
    """Copy every transfer to each of several sinks, which take it at their own times.

    Combinational from valid to valid; a transfer ends when the last sink has taken it.
    """

    def __init__(self, shape: Any, ways: int) -> None:
        super().__init__({"i": In(stream.Signature(shape)), "o": Out(stream.Signature(shape)).array(ways)})

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        taken = Signal(len(self.o))
        done = Signal(len(self.o))  # taken, or taken in this cycle
        for way, o in enumerate(self.o):
            m.d.comb += [
                o.payload.eq(self.i.payload),
                o.valid.eq(self.i.valid & ~taken[way]),
                done[way].eq(taken[way] | o.ready),
            ]
        m.d.comb += self.i.ready.eq(done.all())
        with m.If(self.i.valid):
            m.d.sync += taken.eq(Mux(done.all(), 0, done))
        return m


class Router(wiring.Component):
    """Route the ``words`` of every transfer to the sinks that ``table`` has for its ``kind``, without backpressure.

    ``kind`` is one-hot, since its decoding is on a critical path.  Each sink has its own register for ``valid``, since
    sinks are far apart.
    """

    latency = 1

    def __init__(self, shape: data.StructLayout, table: Sequence[Sequence[int]], ways: int) -> None:
        self._kinds = [[kind for kind, sinks in enumerate(table) if way in sinks] for way in range(ways)]
        words = always_ready_stream(shape.members["words"])
        super().__init__({"i": In(always_ready_stream(shape)), "o": Out(words).array(ways)})

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        words = register(m, self.i.payload.words, "words")
        for o, kinds in zip(self.o, self._kinds, strict=True):
            selected = Cat(self.i.payload.kind[kind] for kind in kinds).any()
            m.d.comb += [
                o.payload.eq(words),
                o.valid.eq(register(m, self.i.valid & selected, control=True)),
            ]
        return m


class Queue(wiring.Component):
    """What leaves at ``o``, which is registered, is what entered at ``i``, ``latency`` cycles later at the earliest."""

    latency = 1

    def __init__(self, shape: Any) -> None:
        super().__init__({"i": In(stream.Signature(shape)), "o": Out(stream.Signature(shape))})


class Buffer(Queue):
    """Store one transfer, so that its sender can continue while the sink still needs it.

    A new transfer enters when the last one has left: for per-frame facts, not for full throughput.
    """

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        payload = Signal(self.i.payload.shape(), reset_less=True)
        full = Signal()
        m.d.comb += [
            self.i.ready.eq(~full),
            self.o.valid.eq(full),
            self.o.payload.eq(payload),
        ]
        with m.If(~full):
            m.d.sync += full.eq(self.i.valid)
            m.d.sync += payload.eq(self.i.payload)
        with m.Elif(self.o.ready):
            m.d.sync += full.eq(0)
        return m


class SkidBuffer(Queue):
    """Cut the combinational path of ``ready``: neither ``i.ready`` nor ``o.valid`` depends on an input.

    Full throughput.
    """

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        ready = Signal(init=1)
        full = Signal()  # not ``ready``: its own register, since the enable of a pipeline has a high fan-out
        out = Signal.like(self.i.p, reset_less=True)
        skid = Signal.like(self.i.p, reset_less=True)  # the transfer that came while ``out`` did not move
        m.d.comb += self.i.ready.eq(ready)
        m.d.comb += self.o.p.eq(out)
        with m.If(ready):
            m.d.sync += skid.eq(self.i.p)
        with m.If(~self.o.valid | self.o.ready):
            m.d.sync += [
                self.o.valid.eq(self.i.valid | full),
                out.eq(Mux(full, skid, self.i.p)),
                full.eq(0),
                ready.eq(1),
            ]
        with m.Elif(ready):
            m.d.sync += full.eq(self.i.valid)
            m.d.sync += ready.eq(~self.i.valid)
        return m


class Fifo(Queue):
    """First in, first out: ``depth`` transfers in block memory.

    A transfer may pass in several ``beats``, a cycle each, through a memory that is narrower by that factor.  Neither
    ``i.ready`` nor ``o.valid`` depends on an input.  ``latency`` counts from the end of a transfer's last beat.
    """

    latency = 2

    def __init__(self, shape: Any, depth: int, beats: int = 1) -> None:
        self._depth, self._beats = depth, beats
        super().__init__(shape)

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        word_in, word_out = self._stored(self.i.payload), self._stored(self.o.payload)
        size, depth = len(word_in) // self._beats, self._depth * self._beats
        memory = Ram(m, "memory", unsigned(size), depth)
        push = Signal()
        fetch = Signal()  # a beat moves from the memory to the output
        occupied = Signal()  # the output has a beat
        pop = Signal()  # that beat leaves it
        advance = Signal()  # the output is free, or will be
        head, _ = wrapping_counter(m, push, depth, "head")
        tail, _ = wrapping_counter(m, fetch, depth, "tail")
        some, full = occupancy_flags(m, depth - 1, push, fetch)  # the output is the last place
        beat, last_in = self._beat(m, push, "put")
        _, last_out = self._beat(m, pop, "got")
        memory.write(push, head, nth_slice(word_in, beat, self._beats))
        latest = memory.read(tail, fetch)
        earlier = self._earlier_beats(m, pop, latest, len(word_in) - size)
        m.d.comb += [
            self.i.ready.eq(~full & last_in),
            push.eq(self.i.valid & ~full),
            pop.eq(occupied & (self.o.ready | ~last_out)),
            advance.eq(~occupied | pop),
            fetch.eq(advance & some),
            word_out.eq(Cat(earlier, latest)),
            self.o.valid.eq(occupied & last_out),
        ]
        with m.If(advance):
            m.d.sync += occupied.eq(some)
        return m

    @staticmethod
    def _earlier_beats(m: Module, pop: Value, beat: Value, bits: int) -> Value:
        """The beats of a transfer that have left the memory."""
        if not bits:
            return Const(0, 0)
        earlier = Signal(bits, reset_less=True)
        with m.If(pop):
            m.d.sync += earlier.eq(Cat(earlier, beat)[len(beat) :])
        return earlier

    def _beat(self, m: Module, step: Value, name: str) -> tuple[Value, Value]:
        """Number of a transfer's beat, and whether it is the last; no counter for a single one."""
        return wrapping_counter(m, step, self._beats, name) if self._beats > 1 else (Const(0, 0), Const(1))

    def _stored(self, payload: Any) -> Value:
        """The part of a payload that is stored."""
        return Value.cast(payload)


class PerFrameFifo(Fifo):
    """FIFO of per-frame facts for one block, for as many frames, ``depth``, as the core has in progress.

    The block uses and stores the ``fields`` of the structure ``shape``; the others are zero at ``o``.  Without fields,
    all are stored.
    """

    def __init__(self, shape: Any, fields: Sequence[str], depth: int) -> None:
        self._fields = tuple(fields)
        super().__init__(shape, depth)

    def _stored(self, payload: Any) -> Value:
        return Cat(payload[name] for name in self._fields) if self._fields else super()._stored(payload)


class Tokens(wiring.Component):
    """Tokens of a credit scheme: each stands for a free place downstream.

    There are ``number`` of them at most, and at first if ``full``; ``every`` so many pulses of ``give`` make one.
    """

    def __init__(self, number: int, every: int = 1, *, full: bool = True) -> None:
        self._number, self._every, self._full = number, every, full
        super().__init__({
            "give": In(1),  # a place, or a part of it, is returned
            "o": Out(stream.Signature(TOKEN)),  # registered
        })

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        _, completes = wrapping_counter(m, self.give, self._every, "parts")
        left = occupancy(m, self._number, self.give & completes, self.o.valid & self.o.ready, full=self._full)
        m.d.comb += self.o.valid.eq(left[0])
        return m


def broadcast(m: Module, source: Any, *sinks: Any) -> None:
    """Every transfer of ``source`` to all ``sinks``, streams without backpressure, in the same cycle."""
    for sink in sinks:
        m.d.comb += [
            sink.valid.eq(source.valid),
            sink.payload.eq(source.payload),
        ]


def one_at_a_time(m: Module, enter: Any, facts: Iterable[Any], leave: Any, last: int) -> tuple[Signal, Signal]:
    """Cycle counter of a block that works on one transfer at a time, and whether it has one.

    ``enter`` is taken while the block is not busy; cycle 0 lasts until all streams of ``facts`` are valid; after
    cycle ``last`` stream ``leave`` is valid until it is taken.
    """
    busy = Signal()
    valid = Signal()
    cycle = Signal(counter_shape(last))
    m.d.comb += enter.ready.eq(~busy)
    m.d.comb += leave.valid.eq(valid)
    with m.If(~busy):
        m.d.sync += busy.eq(enter.valid)
    with m.Elif(cycle == last):
        m.d.sync += cycle.eq(0)
        m.d.sync += valid.eq(1)
    with m.Elif(cycle != 0):
        m.d.sync += cycle.eq(cycle + 1)
    with m.Elif(~valid):
        m.d.sync += cycle.eq(Cat(fact.valid for fact in facts).all())
    with m.Elif(leave.ready):
        m.d.sync += busy.eq(0)
        m.d.sync += valid.eq(0)
    return cycle, busy
