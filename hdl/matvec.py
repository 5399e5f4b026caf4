"""Matrix-vector products on L lanes: block-normalised operands times folded coefficients.

A frame is the five products of :data:`tfra.model.fixed.coefficients.PRODUCTS`, and for each of them

    result[i, p] = round(2^-shift * sum_j rows[i, p, j] * operand[j, s]),    s = p ^ flip,
    shift = fraction + operand - 1 - significant[s]

as :mod:`tfra.model.fixed.matvec` has it.  Row (i, p) is known by its slot ``s``, so that lane ``l`` always works on
word ``l % 4`` of the operand quad, and the operator's ``flip`` permutes nothing but finished results.

    operand -> two banks of Q quads -> align -> round to operand bits -> W = min(4, L) words, broadcast
                 |  significant bits                                       |
                 v                                  coefficient memory -> multiply -> accumulate    (L times)
               amounts by pass                                                            |
                 |                                              capture in the drain register, W words a cycle
                 +------------------------------------------------> shift -> round, permute -> result

A *pass* reads the Q quads of a bank once and ends with L exact sums; rows ``t L ... t L + L - 1`` are pass ``t``.
Lanes never freeze.  A pass is launched only when the pass before the last has left the drain register: then the
last one finds it free when its sums are complete, or at the latest before the sums are overwritten.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from amaranth import Array, Cat, Const, Elaboratable, Module, Mux, Signal, Value, signed, unsigned
from amaranth.lib import data, stream, wiring
from amaranth.lib.memory import Memory, ReadPort
from amaranth.lib.wiring import In, Out

from tfra.codegen.images import bases, lane_images, passes
from tfra.hdl.arithmetic import count, leading_zeros, magnitude_bits, round_half, round_top, shift_right
from tfra.hdl.payloads import vector_quad
from tfra.model.design import Design
from tfra.model.fixed.coefficients import PRODUCTS, stacks
from tfra.model.fixed.widths import widths

FULL = 2
"""Cycles from the last operand quad's transfer to the launch that finds it: OR of magnitudes, amounts."""
_LOAD = FULL + 1
"""Cycles from there to the first read."""
_ADDRESS = 2
"""Stages from a buffer address to the coefficient address of the same quad, so that both words meet in the lane."""
CAPTURE = 7
"""Cycles from a quad's read to sums that hold its products."""
DRAIN = 5
"""Cycles from the capture of sums to their first result: drain register, amounts, shift, rounding, output."""
_RETURN = 8
"""Cycles between the read of a pass's last quad and that of the pass after the next, beside the draining."""


class MatVec(wiring.Component):
    """All matrix-vector products of a frame.

    Latency: see :meth:`latency` and :meth:`duration`; throughput: :attr:`interval`.

    Resources: L multipliers (coefficient x operand) with registers on both sides, L read-only memories of
    ``depth`` coefficients with output registers, a memory of 2 Q quads, 2 W barrel shifters.

    Members:
        operand: stream in, Q quads of parities for each of ``PRODUCTS`` in turn.
        result: stream out, after each operand the result quads of its stack, operator by operator.
    """

    def __init__(self, design: Design) -> None:
        self._design = design
        self._lanes = design.architecture.mac_lanes
        self._words = min(4, self._lanes)
        self._sum_quads = max(1, self._lanes // 4)
        shape = stream.Signature(vector_quad(design))
        super().__init__({"operand": In(shape), "result": Out(shape)})

    @property
    def depth(self) -> int:
        """Coefficients of one lane."""
        return sum(passes(self._design, name) * self._design.quads for name in bases(self._design))

    @property
    def multiplications(self) -> int:
        """Products of a frame that count; lanes that have no row left in a last pass multiply by zero besides."""
        return sum(4 * stacks(self._design)[name].quads * self._design.quads for name in PRODUCTS)

    @property
    def pair_interval(self) -> int:
        """Cycles from the launch of a pass to that of the pass after the next: ``max(2 Q, Q + ceil(L / 4) + 8)``.

        The first of the two follows after Q cycles.
        """
        q = self._design.quads
        return max(2 * q, q + self._sum_quads + _RETURN)

    @property
    def interval(self) -> int:
        """Cycles per frame while operands are always there and results are always taken.

        The mean of two frames, rounded up: with an odd number of passes long and short frames can alternate.
        """
        total = sum(passes(self._design, name) for name in PRODUCTS)
        return -(-total * self.pair_interval // 2)

    def passes(self, stack: str) -> int:
        """Times the operand of ``stack`` runs past the lanes."""
        return passes(self._design, stack)

    def latency(self, stack: str) -> int:
        """Cycles from the transfer of the last operand quad to the first result of an otherwise idle unit."""
        return self._result_cycle(0)

    def duration(self, stack: str) -> int:
        """Cycles from the transfer of the last operand quad to the last result of an otherwise idle unit."""
        return self._result_cycle(stacks(self._design)[stack].quads - 1)

    def _result_cycle(self, number: int) -> int:
        """Cycles from the last operand quad to result quad ``number``: pass, then place in the drain register."""
        turn, row = divmod(4 * number + 3, self._lanes)
        launch = turn // 2 * self.pair_interval + turn % 2 * self._design.quads
        return _LOAD + launch + self._design.quads - 1 + CAPTURE + DRAIN + row // 4

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        design = self._design
        m.submodules.buffer = buffer = _Buffer(design)
        m.submodules.schedule = schedule = _Schedule(design)
        m.submodules.prepare = prepare = _Prepare(design)
        m.submodules.drain = drain = _Drain(design)
        wiring.connect(m, buffer.operand, wiring.flipped(self.operand))
        wiring.connect(m, wiring.flipped(self.result), drain.result)
        self._control(m, buffer, schedule, prepare, drain)
        first, valid, last = _delays(m, schedule, CAPTURE)
        m.d.comb += drain.complete.eq(last[CAPTURE])
        address = _chain(m, schedule.address, _ADDRESS, "address")[_ADDRESS]
        for number, image in enumerate(lane_images(design)):
            m.submodules[f"lane{number}"] = lane = _Lane(design, image)
            m.d.comb += [
                lane.address.eq(address),
                lane.word.eq(prepare.words[number % self._words]),
                lane.first.eq(first[CAPTURE - 1]),
                lane.valid.eq(valid[CAPTURE - 1]),
                drain.sums[number].eq(lane.sum),
            ]
        return m

    def _control(self, m: Module, buffer: _Buffer, schedule: _Schedule, prepare: _Prepare, drain: _Drain) -> None:
        """Amounts travel by the parity of the pass: both places are in use from launch until drained."""
        amounts = Signal.like(buffer.amounts, name="amounts", reset_less=True)
        with m.If(schedule.launch):
            m.d.sync += amounts[schedule.parity].eq(buffer.amounts[schedule.bank])
        m.d.comb += [
            buffer.read.eq(Cat(schedule.quad, schedule.read_bank)),
            buffer.free.eq(schedule.free),
            schedule.full.eq(buffer.full),
            schedule.drained.eq(drain.drained),
            prepare.quad.eq(buffer.quad),
            drain.amounts.eq(amounts[schedule.oldest]),
        ]
        parity, part = Signal(), Signal.like(schedule.read_part, reset_less=True)
        m.d.sync += [parity.eq(schedule.read_parity), part.eq(schedule.read_part)]
        m.d.comb += [prepare.amounts.eq(amounts[parity]), prepare.part.eq(part)]


def _chain(m: Module, value: Value, stages: int, name: str, reset_less: bool = True) -> list[Value]:
    """``value`` now and after each of ``stages`` registers."""
    chain = [value]
    for stage in range(1, stages + 1):
        chain.append(Signal.like(value, name=f"{name}{stage}", reset_less=reset_less))
        m.d.sync += chain[-1].eq(chain[-2])
    return chain


def _delays(m: Module, schedule: _Schedule, stages: int) -> tuple[list[Value], list[Value], list[Value]]:
    """Marks that accompany a quad through the pipeline; first and last are of its pass."""
    return (
        _chain(m, schedule.first, stages, "first"),
        _chain(m, schedule.reading, stages, "valid", reset_less=False),
        _chain(m, schedule.last, stages, "last", reset_less=False),
    )


def _amounts(design: Design) -> data.ArrayLayout:
    """Left shifts that align the four parities of an operand."""
    return data.ArrayLayout(unsigned((widths(design).vector - 1).bit_length()), 4)


def _parts(design: Design) -> int:
    """Passes that it takes to complete a result quad: four words over the lanes, or one."""
    return 4 // min(4, design.architecture.mac_lanes)


class _Buffer(wiring.Component):
    """Two banks of operand quads, and how far each parity must be shifted to fill its word.

    Members:
        operand: stream in.
        full: bank may be read; rises two cycles after the transfer of the bank's last quad.
        amounts: by bank, valid while ``full``.
        read, quad: row and, a cycle later, its content.
        free: by bank, for one cycle: it may be written, from the next cycle on.
    """

    def __init__(self, design: Design) -> None:
        self._design = design
        shape = vector_quad(design)
        super().__init__(
            {
                "operand": In(stream.Signature(shape)),
                "full": Out(2),
                "amounts": Out(data.ArrayLayout(_amounts(design), 2)),
                "read": In(count(design.quads - 1).width + 1),
                "quad": Out(shape),
                "free": In(2),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        last = self._design.quads - 1
        m.submodules.memory = memory = Memory(shape=self.operand.p.shape(), depth=1 << len(self.read), init=[])
        write, read = memory.write_port(), memory.read_port()
        number, bank, done, done_bank = Signal(count(last)), Signal(), Signal(), Signal(reset_less=True)
        occupied = Signal(2)
        m.d.comb += [
            self.operand.ready.eq(~occupied.bit_select(bank, 1)),
            write.en.eq(self.operand.valid & self.operand.ready),
            write.addr.eq(Cat(number, bank)),
            write.data.eq(self.operand.p),
            read.addr.eq(self.read),
            self.quad.eq(read.data),
        ]
        ended = Signal()
        m.d.comb += ended.eq(write.en & (number == last))
        m.d.sync += [done.eq(ended), done_bank.eq(bank)]
        with m.If(write.en):
            m.d.sync += number.eq(Mux(ended, 0, number + 1))
        with m.If(ended):
            m.d.sync += bank.eq(~bank)
        m.d.sync += [
            occupied.eq((occupied | (ended << bank)) & ~self.free),
            self.full.eq((self.full | (done << done_bank)) & ~self.free),
        ]
        self._measure(m, write.en, number == 0, done, done_bank)
        return m

    def _measure(self, m: Module, transfer: Value, first: Value, done: Value, bank: Value) -> None:
        """OR of magnitudes while a bank fills; leading zeros when it is full."""
        for parity in range(4):
            seen = Signal(widths(self._design).vector - 1, name=f"seen{parity}", reset_less=True)
            with m.If(transfer):
                m.d.sync += seen.eq(Mux(first, 0, seen) | magnitude_bits(self.operand.p[parity]))
            with m.If(done):
                m.d.sync += self.amounts[bank][parity].eq(leading_zeros(seen))


class _Schedule(wiring.Component):
    """Launches passes and walks through buffer and coefficients.

    Members:
        full, drained: bank can be read; a pass has left the drain register.
        launch, bank, parity: a pass begins with the next cycle, on this bank; passes count modulo two.
        oldest: the pass that leaves the drain register next, modulo two.
        free: by bank, its last pass has begun.
        reading, first, last, quad, read_bank, read_parity, read_part, address: the read of this cycle.  Its pass's
            slots begin at ``read_part * L``.
    """

    def __init__(self, design: Design) -> None:
        self._design = design
        depth = sum(passes(design, name) * design.quads for name in bases(design))
        super().__init__(
            {
                "full": In(2),
                "drained": In(1),
                "launch": Out(1),
                "bank": Out(1),
                "parity": Out(1),
                "oldest": Out(1),
                "free": Out(2),
                "reading": Out(1),
                "first": Out(1),
                "last": Out(1),
                "quad": Out(count(design.quads - 1)),
                "read_bank": Out(1),
                "read_parity": Out(1),
                "read_part": Out(count(_parts(design) - 1)),
                "address": Out(count(depth - 1)),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        new, ends = self._products(m)
        self._credit(m)
        m.d.comb += [
            self.first.eq(self.quad == 0),
            self.last.eq(self.reading & (self.quad == self._design.quads - 1)),
        ]
        m.d.sync += self.free.eq((self.launch & ends) << self.bank)
        with m.If(self.launch):
            m.d.sync += [
                self.reading.eq(1),
                self.quad.eq(0),
                self.read_bank.eq(self.bank),
                self.read_parity.eq(self.parity),
                self.bank.eq(self.bank ^ ends),
            ]
        with m.Elif(self.last):
            m.d.sync += self.reading.eq(0)
        with m.Else():
            m.d.sync += self.quad.eq(self.quad + 1)
        self._walk(m, new)
        return m

    def _products(self, m: Module) -> tuple[Value, Value]:
        """Product and pass of the next launch: whether it is the first, or the last pass of its product."""
        product, turn = Signal(count(len(PRODUCTS) - 1)), Signal(count(max(self._passes) - 1))
        self._start = Signal.like(self.address, name="start")
        ends = Signal()
        with m.Switch(product):
            for number, name in enumerate(PRODUCTS):
                with m.Case(number):
                    m.d.comb += [
                        ends.eq(turn == self._passes[number] - 1),
                        self._start.eq(bases(self._design)[name]),
                    ]
        with m.If(self.launch):
            m.d.sync += turn.eq(Mux(ends, 0, turn + 1))
            with m.If(ends):
                m.d.sync += product.eq(Mux(product == len(PRODUCTS) - 1, 0, product + 1))
        return turn == 0, ends

    @property
    def _passes(self) -> list[int]:
        return [passes(self._design, name) for name in PRODUCTS]

    def _credit(self, m: Module) -> None:
        """Two passes at most are on their way between launch and drain; they end in order."""
        busy, parts = Signal(2), _parts(self._design)
        m.d.comb += self.launch.eq(
            (self.last | ~self.reading) & self.full.bit_select(self.bank, 1) & ~busy.bit_select(self.parity, 1)
        )
        m.d.sync += busy.eq((busy | (self.launch << self.parity)) & ~(self.drained << self.oldest))
        m.d.sync += [self.parity.eq(self.parity ^ self.launch), self.oldest.eq(self.oldest ^ self.drained)]
        if parts > 1:
            part = Signal.like(self.read_part)
            with m.If(self.launch):
                m.d.sync += [self.read_part.eq(part), part.eq(part + 1)]

    def _walk(self, m: Module, new: Value) -> None:
        """Coefficients are read in their order; only a product's first pass jumps, to its stack."""
        with m.If(self.launch & new):
            m.d.sync += self.address.eq(self._start)
        with m.Elif(self.launch | (self.reading & ~self.last)):
            m.d.sync += self.address.eq(self.address + 1)


class _Prepare(wiring.Component):
    """Operand words from a quad of the buffer: aligned, then rounded; three registers.

    Fewer than four lanes need fewer words: ``part`` tells which.
    """

    def __init__(self, design: Design) -> None:
        self._design, self._words = design, min(4, design.architecture.mac_lanes)
        super().__init__(
            {
                "quad": In(vector_quad(design)),
                "amounts": In(_amounts(design)),
                "part": In(count(_parts(design) - 1)),
                "words": Out(data.ArrayLayout(signed(design.formats.operand), self._words)),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        vector = widths(self._design).vector
        for word in range(self._words):
            raw = Signal(signed(vector), name=f"raw{word}", reset_less=True)
            amount = Signal(self.amounts.shape().elem_shape, name=f"amount{word}", reset_less=True)
            aligned = Signal(signed(vector), name=f"aligned{word}", reset_less=True)
            m.d.sync += [
                raw.eq(_part(self.quad, self.part, word, self._words)),
                amount.eq(_part(self.amounts, self.part, word, self._words)),
                aligned.eq(raw << amount),
                self.words[word].eq(round_top(aligned, self._design.formats.operand)),
            ]
        return m


def _part(words: Any, part: Value, word: int, size: int) -> Value:
    """Word ``part * size + word`` of a quad."""
    choices = [words[number] for number in range(word, 4, size)]
    return choices[0] if size == 4 else Array(choices)[part]


class _Lane(Elaboratable):
    """Coefficient memory, multiplier and accumulator.

        address -> memory -> register -> coefficient -+
                                                      * -> product -> + -> sum
        word -----------------------------> operand --+               ^-- 0 if first

    ``word`` comes two cycles after its address, ``valid`` and ``first`` four after it; ``sum`` a cycle later.
    """

    def __init__(self, design: Design, image: np.ndarray[Any, np.dtype[np.int64]]) -> None:
        formats = design.formats
        self._image, self._shape = [int(word) for word in image], signed(formats.coefficient)
        self.address = Signal(count(len(self._image) - 1))
        self.word = Signal(signed(formats.operand))
        self.first, self.valid = Signal(), Signal()
        self.sum = Signal(signed(widths(design).accumulator), reset_less=True)

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.memory = memory = Memory(shape=self._shape, depth=len(self._image), init=self._image)
        port: ReadPort = memory.read_port()
        fetched = Signal(self._shape, reset_less=True)
        coefficient = Signal(self._shape, reset_less=True)
        operand = Signal.like(self.word, reset_less=True)
        product = Signal(signed(len(coefficient) + len(operand)), reset_less=True)
        m.d.comb += port.addr.eq(self.address)
        m.d.sync += [
            fetched.eq(port.data),
            coefficient.eq(fetched),
            operand.eq(self.word),
            product.eq(coefficient * operand),
        ]
        with m.If(self.valid):
            m.d.sync += self.sum.eq(product + Mux(self.first, 0, self.sum))
        return m


class _Drain(wiring.Component):
    """From complete sums to results on the vector grid.

        sums -> drain register -> W words, right shifts -> shifted -> rounded, in place -> output, spare

    Everything behind the sums stands still while the spare register is in use, so that the enable of all these
    registers is a register itself.

    Members:
        sums, complete: L exact sums; complete for one cycle, then held until the next pass may overwrite them.
        amounts: alignment of the operand of the pass in the drain register.
        drained: the last words of a pass leave the drain register.
        result: stream out.
    """

    def __init__(self, design: Design) -> None:
        self._design, self._lanes = design, design.architecture.mac_lanes
        self._words = min(4, self._lanes)
        w = widths(design)
        self._steps = self._table()
        self._offset = max(offset for _, offset, _, _ in self._steps)
        self._shift = count(self._offset + w.vector - 1)
        super().__init__(
            {
                "sums": In(signed(w.accumulator)).array(self._lanes),
                "complete": In(1),
                "amounts": In(_amounts(design)),
                "drained": Out(1),
                "result": Out(stream.Signature(vector_quad(design))),
            }
        )

    def _table(self) -> list[tuple[int, int, int, bool]]:
        """Quads in the order they leave the drain register: how many, offset of the right shift, flip, sent or not.

        An operand that was moved left by ``amount`` has its result moved right by ``offset + amount``.
        """
        design, w, table = self._design, widths(self._design), []
        for name in PRODUCTS:
            stack = stacks(design)[name]
            for op in stack.operators:
                offset = w.alignment + op.fraction + design.formats.operand - w.vector
                table.append((op.quads, offset, op.flip, True))
            idle = passes(design, name) * self._lanes // 4 - stack.quads
            if idle:
                table.append((idle, 0, 0, False))
        return table

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        w, go = widths(self._design), Signal()
        words, valid = self._register(m, go)
        part, whole = self._part_counter(m, valid & go)
        offset, flip, send = self._place(m, valid & go & whole)
        marks = data.StructLayout({"valid": 1, "complete": 1, "flip": 2, "part": part.shape()})
        shift_marks, round_marks = Signal(marks), Signal(marks)
        done = Signal()
        assembled = Signal(self.result.p.shape(), reset_less=True)
        with m.If(go):
            m.d.sync += [
                shift_marks.valid.eq(valid),
                shift_marks.complete.eq(valid & whole & send),
                shift_marks.flip.eq(flip),
                shift_marks.part.eq(part),
                round_marks.eq(shift_marks),
                done.eq(round_marks.complete),
            ]
        rounded = []
        for number, word in enumerate(words):
            sum_ = Signal(signed(w.accumulator), name=f"sum{number}", reset_less=True)
            shift = Signal(self._shift, name=f"shift{number}", reset_less=True)
            shifted = Signal(signed(w.vector + 1), name=f"shifted{number}", reset_less=True)
            wide = Cat(Const(0, w.alignment), sum_).as_signed()
            with m.If(go):
                m.d.sync += [
                    sum_.eq(word),
                    shift.eq(offset + _part(self.amounts, part, number, self._words)),
                    shifted.eq(shift_right(wide, shift)),
                ]
            rounded.append(round_half(shifted))
        self._assemble(m, go, round_marks, rounded, assembled)
        m.submodules.spare = spare = _Spare(self.result.p.shape())
        m.d.comb += [go.eq(spare.i.ready), spare.i.valid.eq(done), spare.i.payload.eq(assembled)]
        wiring.connect(m, spare.o, wiring.flipped(self.result))
        return m

    def _register(self, m: Module, go: Value) -> tuple[list[Value], Value]:
        """Sums are captured when the register is free, and leave it W words at a time."""
        steps = max(1, self._lanes // 4)
        register = [Signal.like(s, name=f"held{n}", reset_less=True) for n, s in enumerate(self.sums)]
        valid, waiting, capture, step = Signal(), Signal(), Signal(), Signal(count(steps - 1))
        m.d.comb += [
            self.drained.eq(valid & go & (step == steps - 1)),
            capture.eq((self.complete | waiting) & (~valid | self.drained)),
        ]
        m.d.sync += [
            waiting.eq((self.complete | waiting) & ~capture),
            valid.eq(capture | (valid & ~self.drained)),
        ]
        with m.If(capture):
            m.d.sync += [step.eq(0), *(held.eq(s) for held, s in zip(register, self.sums, strict=True))]
        with m.Elif(valid & go):
            m.d.sync += [step.eq(step + 1), *(a.eq(b) for a, b in zip(register, register[self._words :], strict=False))]
        return register[: self._words], valid

    def _part_counter(self, m: Module, leave: Value) -> tuple[Value, Value]:
        """Which words of their quad those that leave are, and whether they complete it."""
        parts = _parts(self._design)
        part = Signal(count(parts - 1))
        if parts > 1:
            with m.If(leave):
                m.d.sync += part.eq(part + 1)
        return part, part == parts - 1

    def _place(self, m: Module, leave: Value) -> tuple[Value, Value, Value]:
        """Offset, flip and fate of the quad that leaves the drain register, by its number in the frame."""
        step, left = Signal(count(len(self._steps) - 1)), Signal(count(max(quads for quads, *_ in self._steps) - 1))
        offset, flip, send, end = Signal(count(self._offset)), Signal(2), Signal(), Signal()
        with m.Switch(step):
            for number, (quads, right, permutation, sent) in enumerate(self._steps):
                with m.Case(number):
                    m.d.comb += [
                        offset.eq(right),
                        flip.eq(permutation),
                        send.eq(sent),
                        end.eq(left == quads - 1),
                    ]
        with m.If(leave):
            m.d.sync += left.eq(Mux(end, 0, left + 1))
            with m.If(end):
                m.d.sync += step.eq(Mux(step == len(self._steps) - 1, 0, step + 1))
        return offset, flip, send

    def _assemble(self, m: Module, go: Value, marks: Any, rounded: list[Value], quad: Any) -> None:
        """Slot ``s`` becomes parity ``s ^ flip``; with fewer than four words at a time, a part of the quad."""
        size = self._words
        for flip in sorted({flip for _, _, flip, _ in self._steps}):
            for slot in range(4):
                with m.If(go & marks.valid & (marks.flip == flip) & (marks.part == slot // size)):
                    m.d.sync += quad[slot ^ flip].eq(rounded[slot % size])


class _Spare(wiring.Component):
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
