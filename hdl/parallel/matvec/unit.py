"""Matrix-vector products on L lanes: block-normalised operands times folded coefficients.

A frame is the products of ``design.products``, and for each of them

    result[i, p] = round(2^-shift * sum_j rows[i, p, j] * operand[j, s]),    s = p ^ flip,
    shift = fraction + operand - 1 - significant[s]

as :mod:`tfra.model.fixed.matvec` has it.  Row (i, p) is known by its slot ``s``, so that lane ``l`` always works on
word ``l % 4`` of the operand quad, and the operator's ``flip`` permutes nothing but finished results.

    b      -> bank      -.
    n      -> two banks -+-> align -> round to operand bits -> four words, broadcast
    vector -> two banks -'                                        |
        |  magnitudes                                             v
        v                                  coefficient memory -> multiply -> accumulate    (L times)
      headroom by pass                                                           |
        |                                              capture in the drain register, W words a cycle
        +------------------------------------------------> shift -> round, permute -> result

A *pass* reads the Q quads of a bank once and adds L exact sums to what the lanes have; rows ``t L ... t L + L - 1``
are pass ``t``.
Lanes never freeze.  A pass is launched as many cycles after the one before as it takes to read the operand, or to
empty the drain register, and only when the pass before the last has left that.

Products of several frames interleave, as :class:`tfra.hdl.parallel.matvec.schedule.Schedule` chooses them, so that
lanes work on one frame while another one's operand is being made.  The results of a product have a reserved place
before it begins, so nothing after the lanes waits: contact and force products take a token each, of a frame's place in
all that follows and of planes of forces, and contact one of a bank that its n will need.
"""

from __future__ import annotations

from typing import Any

from amaranth import Array, Cat, Elaboratable, Module, Mux, Signal, Value, signed
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.arithmetic import quad
from tfra.hdl.lib.pipeline import READ, delayed, register
from tfra.hdl.lib.streams import TOKEN, Tokens, always_ready_stream
from tfra.hdl.parallel.matvec.drain import Drain, drain_latency
from tfra.hdl.parallel.matvec.drain_register import drain_steps
from tfra.hdl.parallel.matvec.images import busy_cycles, depth, lane_images, low_bits, passes, tail
from tfra.hdl.parallel.matvec.loader import Loader
from tfra.hdl.parallel.matvec.operand import (
    MEASURE,
    PREPARE,
    OperandBuffer,
    Prepare,
    codes_fit,
    headroom_quad,
    lengths_differ,
)
from tfra.hdl.parallel.matvec.schedule import SOURCES, Schedule, spacing
from tfra.hdl.parallel.payloads import operand, product, vector_quad
from tfra.hdl.primitives import Multiplier, Rom
from tfra.model.fixed.design import Design


def full(design: Design, stack: str) -> int:
    """:data:`FULL` for the operand of ``stack``; b is found by its first quad, if codes fit an operand."""
    return 2 - design.quads if stack == "contact" and codes_fit(design) else FULL


BANKS = {"b": 1, "n": 2, "vector": 2}
FULL = MEASURE + 1
"""Cycles from the last operand quad's transfer to the choice that finds it."""
CHOICE = 1
"""Cycles from there to the launch."""
_ADDRESS = PREPARE + 2
"""Stages from a buffer address to the coefficient address of the same quad, so that both words meet in the lane."""
CAPTURE = PREPARE + 7
"""Cycles from a quad's read to sums that hold its products."""


class MatVec(wiring.Component):
    """All matrix-vector products of a frame.

    Latency: see :meth:`latency` and :meth:`duration`; throughput: :attr:`busy_cycles`.

    Resources: L multipliers (coefficient x operand) with registers on both sides, a read-only memory of L words by
    ``depth`` with output registers, a memory of 2 Q quads, 2 W barrel shifters.

    Members:
        b, n, vector: streams in, Q quads of parities for each operand: folded stress in converter codes, weights,
            and residuals, d among them.  Quads of b come in every cycle once a frame's first was taken, if codes fit
            an operand.
        result: stream out, the result quads of a product's stack, operator by operator.
        frame_token: tokens, one taken at the launch of each contact product.
        plane_token: tokens, one taken at the launch of each force product.
        bank_token: tokens out, one for each bank of ``vector`` that is free.
        load: stream in, the coefficients after a reset, if ``design.images`` is "load".
        loading: high until all have arrived; no frame may come before.
    """

    def __init__(self, design: Design) -> None:
        self._design = design
        self._lanes = design.architecture.mac_lanes
        self._drain_steps = drain_steps(design)
        super().__init__(
            {
                "b": In(stream.Signature(quad(design.adc.bits + 2))),
                "n": In(always_ready_stream(vector_quad(design))),
                "vector": In(always_ready_stream(operand(design))),
                "result": Out(always_ready_stream(product(design))),
                "frame_token": In(stream.Signature(TOKEN)),
                "plane_token": In(stream.Signature(TOKEN)),
                "bank_token": Out(stream.Signature(TOKEN)),
                **(self._load_ports() if design.images == "load" else {}),
            }
        )

    def _load_ports(self) -> dict[str, Any]:
        coefficient = signed(self._design.coefficient_word)
        return {"load": In(stream.Signature(coefficient)), "loading": Out(1)}

    @property
    def depth(self) -> int:
        """Coefficients of one lane."""
        return depth(self._design)

    @property
    def pair_interval(self) -> int:
        """Cycles from the launch of a pass to that of the pass after the next.

        The first of the two follows after :func:`tfra.hdl.parallel.matvec.schedule.spacing`.
        """
        return max(2 * spacing(self._design), self._design.quads + CAPTURE + self._drain_steps + 1)

    @property
    def busy_cycles(self) -> int:
        """Cycles of a frame in which the lanes multiply."""
        return busy_cycles(self._design)

    def passes(self, stack: str) -> int:
        """Times the operand of ``stack`` runs past the lanes."""
        return passes(self._design, stack)

    def latency(self, stack: str) -> int:
        """Cycles from the transfer of the last operand quad to the first result of an otherwise idle unit."""
        return self._result_cycle(stack, 0)

    def duration(self, stack: str) -> int:
        """Cycles from the transfer of the last operand quad to the last result of an otherwise idle unit."""
        return self._result_cycle(stack, self._design.stacks[stack].quads - 1)

    def _result_cycle(self, stack: str, number: int) -> int:
        """Cycles from the last operand quad to result quad ``number``: pass, then place in the drain register."""
        turn, row = divmod(4 * number + 3, self._lanes)
        launch = turn // 2 * self.pair_interval + turn % 2 * spacing(self._design)
        leave = row // self._design.architecture.vector_words + drain_latency(self._design)
        found = full(self._design, stack) + CHOICE + 1  # to the first read
        return found + launch + self._design.quads - 1 + CAPTURE + leave

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        design = self._design
        buffers = self._buffers(m)
        m.submodules.schedule = schedule = Schedule(design)
        m.submodules.prepare = prepare = Prepare(design)
        m.submodules.drain = drain = Drain(design)
        wiring.connect(m, wiring.flipped(self.result), drain.result)
        self._wire_tokens(m, buffers, schedule)
        self._wire_passes(m, buffers, schedule, prepare, drain)
        self._wire_lanes(m, schedule, prepare, drain)
        return m

    def _wire_lanes(self, m: Module, schedule: Schedule, prepare: Prepare, drain: Drain) -> None:
        """Coefficients and operand words meet in the lanes, whose sums go to the drain."""
        valid = delayed(m, schedule.reading, CAPTURE - 1, "valid", control=True)
        m.d.comb += drain.completing.eq(delayed(m, schedule.last, CAPTURE - 1, "last", control=True))
        coefficients = self._coefficients(m, schedule)
        # TIMING: operand words -> lanes
        words = [delayed(m, word, 2, f"word{number}") for number, word in enumerate(prepare.words)]
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
            m.submodules.loader = loader = Loader(design)
            wiring.connect(m, wiring.flipped(self.load), loader.load)
            address = Mux(loader.writing, loader.address, address)
            write, data = register(m, loader.write, "write", control=True), register(m, loader.data, "data")
            m.d.comb += [
                self.loading.eq(loader.loading),
                rom.write.eq(write),
                rom.data.eq(data[cut.bits :] if cut.bits else data),
            ]
        # TIMING: schedule, loader -> memories of all lanes
        m.d.comb += rom.address.eq(register(m, address, "address"))
        if not cut.bits:
            return list(rom.words)
        lowest = low_bits(images[:, : cut.depth], cut.bits)
        m.submodules.tail = low = Rom(lowest, cut.bits, design.target, loaded=loaded)
        there = rom.address < cut.depth
        m.d.comb += low.address.eq(rom.address)
        if loaded:
            m.d.comb += [low.write.eq(write & there.replicate(len(write))), low.data.eq(data[: cut.bits])]
        found = delayed(m, there, Rom.latency, "tail_there")
        pairs = zip(rom.words, low.words, strict=True)
        return [Cat(Mux(found, short, 0)[: cut.bits], long).as_signed() for long, short in pairs]

    def _buffers(self, m: Module) -> dict[str, OperandBuffer]:
        """One buffer for each source, so that no operand waits for another's transfers."""
        design, vector = self._design, signed(self._design.widths.vector)
        code, fraction = signed(design.adc.bits + 2), design.formats.vector_fraction
        buffers = {
            "vector": OperandBuffer(design, vector, banks=BANKS["vector"]),
            "n": OperandBuffer(design, vector, banks=BANKS["n"]),
            "b": OperandBuffer(design, code, fraction, banks=BANKS["b"], flowing=codes_fit(design)),
        }
        for name, buffer in buffers.items():
            m.submodules[name] = buffer
        wiring.connect(m, wiring.flipped(self.b), buffers["b"].operand)
        for name, port, words in (("n", self.n, self.n.payload), ("vector", self.vector, self.vector.payload.words)):
            m.d.comb += [buffers[name].operand.valid.eq(port.valid), buffers[name].operand.payload.eq(words)]
        return buffers

    def _wire_tokens(self, m: Module, buffers: dict[str, OperandBuffer], schedule: Schedule) -> None:
        """Operands that may be multiplied, because their results have a place."""
        m.submodules.bank_tokens = bank_tokens = Tokens(BANKS["vector"])
        m.submodules.weight_tokens = weight_tokens = Tokens(BANKS["n"])
        wiring.connect(m, bank_tokens.o, wiring.flipped(self.bank_token))
        is_force = self._is_force(m, buffers["vector"])
        start = schedule.launch & schedule.new
        # TIMING: launch -> tokens; in time for the next choice
        starts = {
            name: register(m, start & (schedule.stack == n), f"starts_{name}", control=True)
            for n, name in enumerate(self._design.stacks)
        }
        wanted = {
            "vector": buffers["vector"].full & (~is_force | self.plane_token.valid),
            "n": buffers["n"].full,
            "b": buffers["b"].full & self.frame_token.valid & weight_tokens.o.valid,
        }
        m.d.comb += [
            schedule.force.eq(is_force),
            schedule.wanted.eq(sum(wanted[name] << place for place, name in enumerate(SOURCES))),
            self.plane_token.ready.eq(starts["force"]),
            self.frame_token.ready.eq(starts["contact"]),
            weight_tokens.o.ready.eq(starts["contact"]),
            weight_tokens.give.eq(buffers["n"].free),
            bank_tokens.give.eq(buffers["vector"].free),
            *(buffers[name].free.eq(schedule.free[place]) for place, name in enumerate(SOURCES)),
        ]

    def _is_force(self, m: Module, buffer: OperandBuffer) -> Value:
        """Whether the first vector of the queue is d."""
        force = Signal(BANKS["vector"])  # by bank
        with m.If(self.vector.valid):
            m.d.sync += force.bit_select(buffer.filling, 1).eq(self.vector.payload.force)
        return force.bit_select(buffer.head, 1)

    def _wire_passes(
        self, m: Module, buffers: dict[str, OperandBuffer], schedule: Schedule, prepare: Prepare, drain: Drain
    ) -> None:
        """State of a pass for the operand path and the drain, by the parity of its number, from launch until it has
        drained."""
        facts = data.StructLayout({"headroom": headroom_quad(self._design), "new": 1, "stack": 2})
        passes_in_flight = Signal(data.ArrayLayout(facts, 2), reset_less=True)
        sources = [buffers[name] for name in SOURCES]
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
        captured = Signal()  # passes, modulo two
        m.d.sync += captured.eq(captured ^ drain.complete)
        source = delayed(m, schedule.read_source, READ, "found_source")
        parity_found = delayed(m, schedule.read_parity, READ, "found_parity")
        headrooms = [each.headroom.as_value() for each in passes_in_flight]
        m.d.comb += [
            *(b.read.eq(Cat(schedule.quad, bank)) for b in sources),
            schedule.drained.eq(drain.drained),
            prepare.quad.eq(Array(b.quad.as_value() for b in sources)[source]),
            prepare.headroom.eq(Array(headrooms)[parity_found]),
            drain.headroom.eq(Array(headrooms)[schedule.oldest]),
            drain.new.eq(Array(each.new for each in passes_in_flight)[captured]),
            drain.stack.eq(Array(each.stack for each in passes_in_flight)[captured]),
        ]
        if lengths_differ(self._design):
            m.d.comb += prepare.stack.eq(Array(each.stack for each in passes_in_flight)[parity_found])


class _Lane(Elaboratable):
    """Multiplier and accumulator.

        coefficient, word -> multiply -> product -> + -> sum

    The sum accumulates from pass to pass, modulo its word, which saves a multiplexer a bit and a reset: the drain
    subtracts the sum of the previous pass.

    Members:
        coefficient: in.
        word: in, in the same cycle as ``coefficient``.
        valid: in, two cycles after the factors: their product counts.
        sum: out, a cycle after ``valid``.
    """

    def __init__(self, design: Design) -> None:
        self._design = design
        self.coefficient = Signal(signed(design.coefficient_word))
        self.word = Signal(signed(design.operand_word))
        self.valid = Signal()
        self.sum = Signal(signed(design.widths.accumulator), reset_less=True)

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.multiplier = multiplier = Multiplier(len(self.coefficient), len(self.word), self._design.target)
        m.d.comb += [multiplier.a.eq(self.coefficient), multiplier.b.eq(self.word)]
        with m.If(self.valid):
            m.d.sync += self.sum.eq(multiplier.product + self.sum)
        return m
