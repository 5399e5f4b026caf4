"""Matrix-vector products on L lanes: block-normalised operands times folded coefficients.

A frame is the products of ``design.products``, and for each of them

    result[i, p] = round(2^-shift * sum_j rows[i, p, j] * operand[j, s]),    s = p ^ flip,
    shift = fraction + operand - 1 - significant[s]

as :mod:`tfra.model.fixed.matvec` has it.  Row (i, p) is known by its slot ``s``, so that lane ``l`` always works on
word ``l % 4`` of the operand quad, and the operator's ``flip`` permutes nothing but finished results.

    source -> bank or two -.
    source -> bank or two -+-> align -> round to operand bits -> four words, broadcast
       ... -> bank or two -'                                      |
        |  magnitudes                                             v
        v                                  coefficient memory -> multiply -> accumulate    (L times)
      headroom by pass                                                           |
        |                                              capture in the drain register, W words a cycle
        +------------------------------------------------> shift -> round, permute -> result

The :class:`tfra.hdl.parallel.matvec.plan.Plan` of an estimator names the sources and what their products wait for.
A *pass* reads the quads of a bank once and adds L exact sums to what the lanes have; rows ``t L ... t L + L - 1``
are pass ``t``.
Lanes never freeze.  A pass is launched as many cycles after the one before as it takes to read the operand, or to
empty the drain register, and only when the pass before the last has left that.

Products of several frames interleave, as :class:`tfra.hdl.parallel.matvec.schedule.Schedule` chooses them, so that
lanes work on one frame while another one's operand is being made.  The results of a product have a reserved place
before it begins, so nothing after the lanes waits: products take tokens for places in the blocks that follow, and
for the banks that their results will need as operands.
"""

from functools import reduce
from operator import and_
from typing import Any

from amaranth import Array, Cat, Elaboratable, Module, Mux, Signal, Value, signed
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.pipeline import READ, delayed, register, wrapping_counter
from tfra.hdl.lib.streams import TOKEN, Tokens, always_ready_stream
from tfra.hdl.parallel.matvec.drain import Drain
from tfra.hdl.parallel.matvec.images import depth, lane_images, low_bits, tail
from tfra.hdl.parallel.matvec.operand import PREPARE, OperandBuffer, headroom_quad, lengths_differ, prepared
from tfra.hdl.parallel.matvec.passes import CAPTURE
from tfra.hdl.parallel.matvec.plan import Plan, Source, stack_number
from tfra.hdl.parallel.matvec.schedule import Schedule
from tfra.hdl.parallel.payloads import product, vector_quad
from tfra.hdl.primitives import Multiplier, Rom
from tfra.model.fixed.design import Design

_FOLLOWING = 2
"""Products of a stack that may have begun while those that follow them wait; each has a bank for its operand."""
_ADDRESS = PREPARE + 2
"""Stages from a buffer address to the coefficient address of the same quad, so that both words meet in the lane."""


class MatVec(wiring.Component):
    """All matrix-vector products of a frame.

    Resources: L multipliers (coefficient x operand) with registers on both sides, a read-only memory of L words by
    ``depth`` with output registers, the banks of the sources, 2 W barrel shifters.
    """

    def __init__(self, design: Design, plan: Plan) -> None:
        self._design, self._plan = design, plan
        super().__init__({
            # Quads of parities for each operand.  Those of folded codes come in every cycle once a frame's first was
            # taken, if they are ``flowing``.
            **{source.name: In(self._operand(source)) for source in reversed(plan.sources)},
            # The result quads of a product's stack, operator by operator.
            "result": Out(always_ready_stream(product(design))),
            **{name: In(stream.Signature(TOKEN)) for name in plan.tokens_in},  # taken at the launch of a product
            **{name: Out(stream.Signature(TOKEN)) for name in plan.tokens_out},  # one for each free bank of a source
            **(self._load_ports() if design.images == "load" else {}),
        })

    def _operand(self, source: Source) -> stream.Signature:
        """The stream of a source's operands."""
        if source.token:
            return always_ready_stream(source.payload(self._design))
        return stream.Signature(source.words(self._design))

    def _load_ports(self) -> dict[str, Any]:
        coefficient = signed(self._design.coefficient_word)
        return {
            "load": In(stream.Signature(coefficient)),  # the coefficients after a reset
            "loading": Out(1),  # high until all have arrived; no frame may come before
        }

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        design = self._design
        buffers = self._buffers(m)
        m.submodules.schedule = schedule = Schedule(design, self._plan)
        m.submodules.drain = drain = Drain(design)
        wiring.connect(m, wiring.flipped(self.result), drain.result)
        self._wire_tokens(m, buffers, schedule)
        words = self._wire_passes(m, buffers, schedule, drain)
        self._wire_lanes(m, schedule, words, drain)
        return m

    def _wire_lanes(self, m: Module, schedule: Schedule, words: Any, drain: Drain) -> None:
        """Coefficients and operand words meet in the lanes, whose sums go to the drain."""
        valid = delayed(m, schedule.reading, CAPTURE - 1, "valid", control=True)
        m.d.comb += drain.completing.eq(delayed(m, schedule.last, CAPTURE - 1, "last", control=True))
        coefficients = self._coefficients(m, schedule)
        # TIMING: operand words -> lanes
        words = [delayed(m, word, 2, f"word{number}") for number, word in enumerate(words)]
        for number, coefficient in enumerate(coefficients):
            m.submodules[f"lane{number}"] = lane = _Lane(self._design)
            m.d.comb += [
                lane.coefficient.eq(coefficient),
                lane.word.eq(words[number % 4]),
                lane.valid.eq(valid),
                drain.sums[number].eq(lane.sum),
            ]

    def _coefficients(self, m: Module, schedule: Schedule) -> list[Value]:
        """The lanes' memories, and what fills them after a reset."""
        design, loaded, cut = self._design, self._design.images == "load", tail(self._design)
        images, bits = lane_images(design), design.coefficient_word - cut.bits
        m.submodules.rom = rom = Rom(images >> cut.bits, bits, design.target, loaded=loaded)
        address = delayed(m, schedule.address, _ADDRESS - 1, "address")
        if loaded:
            write, address, data = self._load(m, address)
            m.d.comb += [
                rom.write.eq(write),
                rom.data.eq(data[cut.bits :] if cut.bits else data),
            ]
        # TIMING: schedule, loader -> memories of all lanes
        m.d.comb += rom.address.eq(register(m, address, "address"))
        if not cut.bits:
            return list(rom.words)
        lowest = low_bits(images[:, : cut.depth], cut.bits)
        m.submodules.tail = low = Rom(lowest, cut.bits, design.target, loaded=loaded)
        has_tail = rom.address < cut.depth
        m.d.comb += low.address.eq(rom.address)
        if loaded:
            m.d.comb += low.write.eq(write & has_tail.replicate(len(write)))
            m.d.comb += low.data.eq(data[: cut.bits])
        with_tail = delayed(m, has_tail, Rom.latency, "tail_valid")
        pairs = zip(rom.words, low.words, strict=True)
        return [Cat(Mux(with_tail, short, 0)[: cut.bits], long).as_signed() for long, short in pairs]

    def _load(self, m: Module, address: Value) -> tuple[Value, Value, Value]:
        """The stream of coefficients, lane by lane, each lane's in the order in which it reads them.

        A bit for each lane that is written, the address, which is that of reads once all have been written, and data.
        """
        loading = Signal(init=1)  # high until all have arrived
        taken = Signal()
        place, last = wrapping_counter(m, taken, depth(self._design), "place")
        lane = Signal(self._design.architecture.mac_lanes, init=1)  # one bit, of the lane whose turn it is
        m.d.comb += [
            self.load.ready.eq(loading),
            self.loading.eq(loading),
            taken.eq(self.load.valid & loading),
        ]
        with m.If(taken & last):
            m.d.sync += lane.eq(lane << 1)
            m.d.sync += loading.eq(~lane[-1])
        writing = Signal(init=1)
        m.d.sync += writing.eq(loading)
        write = delayed(m, lane & taken.replicate(len(lane)), 2, "write", control=True)
        data = register(m, register(m, self.load.payload, "loaded", control=True), "data")
        return write, Mux(writing, register(m, place, "write_address", control=True), address), data

    def _buffers(self, m: Module) -> dict[str, OperandBuffer]:
        """One buffer for each source, so that no operand waits for another's transfers."""
        buffers = {source.name: OperandBuffer(self._design, source) for source in self._plan.sources}
        for name, buffer in buffers.items():
            m.submodules[name] = buffer
        for source in reversed(self._plan.sources):
            port, buffer = getattr(self, source.name), buffers[source.name]
            if not source.token:
                wiring.connect(m, wiring.flipped(port), buffer.operand)
                continue
            words = port.payload.words if source.stacks[1:] else port.payload
            m.d.comb += buffer.operand.valid.eq(port.valid)
            m.d.comb += buffer.operand.payload.eq(words)
        return buffers

    def _wire_tokens(self, m: Module, buffers: dict[str, OperandBuffer], schedule: Schedule) -> None:
        """Operands that may be multiplied, because their results have a place."""
        plan = self._plan
        tokens = {name: getattr(self, name) for name in plan.tokens_in}
        banks = {source.name: Tokens(source.banks) for source in plan.sources if source.token}
        for source in plan.sources:
            if source.token:
                m.submodules[f"{source.token}s"] = banks[source.name]
                tokens[source.token] = banks[source.name].o
        following = {name: Tokens(_FOLLOWING, full=False) for name in plan.follows}
        for name, begun in following.items():
            m.submodules[f"{name}s"] = begun
            tokens[name] = begun.o
        for name in plan.tokens_out:
            wiring.connect(m, tokens[name], wiring.flipped(getattr(self, name)))
        wanted = [self._wanted(m, source, buffers[source.name], tokens, schedule) for source in plan.sources]
        start = schedule.launch & schedule.new
        # TIMING: launch -> tokens; in time for the next choice
        starts = {
            name: register(m, start & (schedule.stack == n), f"starts_{name}", control=True)
            for n, name in enumerate(self._design.stacks)
        }
        m.d.comb += schedule.wanted.eq(sum(each << place for place, each in enumerate(wanted)))
        for stack, names in plan.needs.items():
            m.d.comb += (tokens[name].ready.eq(starts[stack]) for name in names)
        for name, free in reversed(banks.items()):
            m.d.comb += free.give.eq(buffers[name].free)
        for name, begun in following.items():
            m.d.comb += begun.give.eq(starts[plan.follows[name]])
        for place, source in enumerate(plan.sources):
            m.d.comb += buffers[source.name].free.eq(schedule.free[place])

    def _wanted(
        self, m: Module, source: Source, buffer: OperandBuffer, tokens: dict[str, Any], schedule: Schedule
    ) -> Value:
        """Whether the first operand of ``source`` may be multiplied: it is there, and so are its product's tokens."""
        first, *second = (self._plan.needs.get(stack, ()) for stack in source.stacks)
        wanted: Value = buffer.full
        if not second:
            return reduce(and_, (tokens[name].valid for name in first), wanted)
        is_second = self._is_second(m, source, buffer)
        m.d.comb += getattr(schedule, source.stacks[1]).eq(is_second)
        wanted = reduce(and_, (is_second | tokens[name].valid for name in first), wanted)
        return reduce(and_, (~is_second | tokens[name].valid for name in second[0]), wanted)

    def _is_second(self, m: Module, source: Source, buffer: OperandBuffer) -> Value:
        """Whether the first operand of ``source`` is for its second stack."""
        name, port = source.stacks[1], getattr(self, source.name)
        marks = Signal(source.banks, name=name)
        with m.If(port.valid):
            m.d.sync += marks.bit_select(buffer.filling, 1).eq(port.payload[name])
        return marks.bit_select(buffer.head, 1)

    def _wire_passes(self, m: Module, buffers: dict[str, OperandBuffer], schedule: Schedule, drain: Drain) -> Any:
        """Facts of the two passes in flight, for the operand path and the drain; returns the operand words.

        A launch stores them by the parity of the pass.  Each user then looks at the pass that it works on:

        ============ ========================== =====================================
        user         looks at                   parity of its pass
        ============ ========================== =====================================
        operand      ``headroom``, ``stack``    ``read_parity``, ``READ`` cycles later
        placement    ``new``, ``stack``         ``captured``: passes captured so far
        drain        ``headroom``               ``oldest``: the pass that drains next
        ============ ========================== =====================================
        """
        design = self._design
        facts = data.StructLayout({"headroom": headroom_quad(design), "new": 1, "stack": stack_number(design)})
        passes_in_flight = Signal(data.ArrayLayout(facts, 2), reset_less=True)

        def fact(name: str, parity: Value) -> Value:
            return Array(Value.cast(one[name]) for one in passes_in_flight)[parity]

        sources = list(buffers.values())
        headroom = Array(b.headroom.as_value() for b in sources)[schedule.source]
        for parity, facts_of_pass in enumerate(passes_in_flight):
            with m.If(schedule.launch & (schedule.parity == parity)):
                m.d.sync += [
                    facts_of_pass.headroom.eq(headroom),
                    facts_of_pass.new.eq(schedule.new),
                    facts_of_pass.stack.eq(schedule.stack),
                ]
        bank = Signal()
        with m.If(schedule.launch):
            m.d.sync += bank.eq(Array(b.head for b in sources)[schedule.source])
        captured = Signal()
        m.d.sync += captured.eq(captured ^ drain.complete)
        source = delayed(m, schedule.read_source, READ, "source")
        read_parity = delayed(m, schedule.read_parity, READ, "read_parity")
        for buffer in sources:
            m.d.comb += buffer.read.eq(Cat(schedule.quad[: len(buffer.read) - 1], bank))
        quad = Signal(vector_quad(design))
        shifts = Signal(headroom_quad(design))
        m.d.comb += [
            schedule.drained.eq(drain.drained),
            quad.eq(Array(b.quad.as_value() for b in sources)[source]),
            shifts.eq(fact("headroom", read_parity)),
            drain.headroom.eq(fact("headroom", schedule.oldest)),
            drain.new.eq(fact("new", captured)),
            drain.stack.eq(fact("stack", captured)),
        ]
        return prepared(m, design, quad, shifts, fact("stack", read_parity) if lengths_differ(design) else None)


class _Lane(Elaboratable):
    """Multiplier and accumulator: of ``coefficient``, ``word`` and ``valid`` the running ``sum``.

        coefficient, word -> multiply -> product -> + -> sum

    The sum accumulates from pass to pass, modulo its word, which saves a multiplexer a bit and a reset: the drain
    subtracts the sum of the previous pass.
    """

    def __init__(self, design: Design) -> None:
        self._design = design
        self.coefficient = Signal(signed(design.coefficient_word))
        self.word = Signal(signed(design.operand_word))  # in the same cycle as ``coefficient``
        self.valid = Signal()  # two cycles after the factors: their product counts
        self.sum = Signal(signed(design.widths.accumulator), reset_less=True)  # a cycle after ``valid``

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.multiplier = multiplier = Multiplier(len(self.coefficient), len(self.word), self._design.target)
        m.d.comb += multiplier.a.eq(self.coefficient)
        m.d.comb += multiplier.b.eq(self.word)
        with m.If(self.valid):
            m.d.sync += self.sum.eq(multiplier.product + self.sum)
        return m
