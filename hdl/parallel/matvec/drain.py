"""Results of the matrix-vector unit: complete sums are shifted, rounded and permuted, W words at a time."""

from functools import reduce
from operator import or_
from typing import Any

from amaranth import Array, Cat, Const, Module, Mux, Signal, Value, signed, unsigned
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.arithmetic import counter_shape, round_off, shift_right, two_steps
from tfra.hdl.lib.pipeline import delayed, register
from tfra.hdl.lib.ram import Ram
from tfra.hdl.lib.streams import always_ready_stream
from tfra.hdl.parallel.matvec.operand import headroom_quad
from tfra.hdl.parallel.matvec.placement import placements, table
from tfra.hdl.parallel.matvec.plan import stack_number
from tfra.hdl.parallel.payloads import product
from tfra.model.fixed.design import Design


def drain_steps(design: Design) -> int:
    """Cycles in which the words of a pass leave the drain register."""
    return design.architecture.mac_lanes // design.architecture.vector_words


def drain_latency(design: Design) -> int:
    """Cycles from the capture of sums to their first result: drain register, ``sum``, ``coarse``, ``shifted``, quad.

    With several beats a quad, one more for the register that holds a quad while the beats of the next arrive.
    """
    return 5 + (design.cycles_per_quad > 1)


FINE = 3
"""Bits of a shift by which its second step moves: about half of them."""


def pick_word(words: Any, group: Value, word: int, size: int) -> Value:
    """Word ``group * size + word`` of a quad."""
    choices = [words[number] for number in range(word, 4, size)]
    return choices[0] if size == 4 else Array(choices)[group]


def on_grid(m: Module, design: Design, number: int, word: Value, shift: Value) -> Value:
    """Word ``number`` of the register, shifted right to the grid of vectors and rounded; two registers before it."""
    w = design.widths
    top = max(row.offset for row in table(design)) + w.vector - 1
    total = Signal(signed(w.accumulator), name=f"sum{number}", reset_less=True)
    amount = Signal(counter_shape(top), name=f"shift{number}", reset_less=True)
    shifted = Signal(signed(w.vector + 1), name=f"shifted{number}", reset_less=True)
    coarse_shift, _ = two_steps(amount, FINE)
    _, fine_shift = two_steps(register(m, amount, f"coarse_shift{number}"), FINE)
    wide = Cat(Const(0, w.alignment), total).as_signed()
    moved = shift_right(wide, coarse_shift)[: w.vector + 1 + (1 << FINE)].as_signed()
    coarse = register(m, moved, f"coarse{number}")
    m.d.sync += [
        total.eq(word),
        amount.eq(shift),
        shifted.eq(coarse >> fine_shift),
    ]
    rounding = design.formats.rounding
    if rounding.sticky:
        lost = _lost_bit(m, wide, amount, coarse, fine_shift)
        return round_off(Cat(lost, shifted).as_signed(), 2, rounding)
    return round_off(shifted, 1, rounding)


def _lost_bit(m: Module, wide: Value, amount: Value, coarse: Value, fine: Value) -> Value:
    """Whether any bit is set below the one that is kept below the point, beside the shifted word.

    ``wide`` is to be shifted by ``amount``; a cycle later, ``coarse`` is what the first step leaves, and ``fine`` the
    rest of the shift.
    """
    size, steps = 1 << FINE, amount[FINE:]
    below = Cat(Const(0, 1), wide)
    groups = [below[low : low + size].any() for low in range(0, len(below), size)]
    gone = reduce(or_, (some & (steps > number) for number, some in enumerate(groups)))
    left = reduce(or_, (bit & (fine > number) for number, bit in enumerate(coarse[: size - 1])))
    return register(m, register(m, gone, "gone") | left, "lost")


class Drain(wiring.Component):
    """From complete sums to results on the vector grid.

    ::

        sums -> drain register -> sum -> coarse -> shifted -> round, flip -> assembled -> result
                    placement -> shift ---'---------'           '- marks: flip, kind, slots

    The drain register captures all sums of a pass at once and sends W words a cycle, each minus its lane's sum of the
    pass before.  Nothing after the sums waits, since products begin only when their results have a place.

    Lanes accumulate from pass to pass, modulo their word.  The difference is exact, since the sum of a pass fits the
    word.

    ==================  =============  ============  =============  ===============================================
    state               ``capturing``  ``draining``  ``last_step``  in this cycle
    ==================  =============  ============  =============  ===============================================
    empty               0              0             any            nothing; the register shifts all the same, so
                                                                    that its words have one enable
    capture             1              0             any            sums are captured; words leave from the next
                                                                    cycle on
    draining            0              1             0              W words leave
    last words          0              1             1              the last W words leave; empty follows
    last, and capture   1              1             1              the last W words leave, and sums are captured
    ==================  =============  ============  =============  ===============================================

    After a reset (``after_reset``) the sums, which may be anything, are captured once, as those of a pass before the
    first.  They are the base of its differences, not results: ``primed`` is high when they have left.
    """

    def __init__(self, design: Design) -> None:
        self._design, self._words = design, design.architecture.vector_words
        super().__init__({
            "sums": In(signed(design.widths.accumulator)).array(design.architecture.mac_lanes),  # L running sums
            # High a cycle before the sums are those of a pass; passes are at least as many cycles apart as the
            # register takes to drain.
            "completing": In(1),
            "complete": Out(1),  # a cycle after ``completing``: sums are captured
            "headroom": In(headroom_quad(design)),  # that of the operand of the pass in the drain register
            "new": In(1),  # in the same cycle as ``completing``, the pass is the first of its product
            "stack": In(stack_number(design)),  # in the same cycle as ``completing``, that of its product
            "drained": Out(1),  # the last words of a pass leave the drain register
            "result": Out(always_ready_stream(product(design))),
        })

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        valid, words = self._words_out(m)
        group, last_group = self._group_counter(m, valid)
        new = self.completing & self.new
        placement = placements(m, self._design, new, self.stack, valid & last_group)
        layout = {"valid": 1, "complete": 1, "flip": 2, "group": group.shape(), "kind": self.result.p.kind.shape()}
        sum_marks = Signal(data.StructLayout(layout))
        m.d.sync += [
            sum_marks.valid.eq(valid),
            sum_marks.complete.eq(valid & last_group & placement.send),
            sum_marks.flip.eq(placement.flip),
            sum_marks.group.eq(group),
            sum_marks.kind.eq(placement.kind),
        ]
        rounded = []
        for number, word in enumerate(words):
            headroom = pick_word(self.headroom, group, number, self._words)
            rounded.append(on_grid(m, self._design, number, word, placement.offset + headroom))
        shifted_marks = delayed(m, sum_marks.as_value(), 2, "marks", control=True)
        self._send(m, data.View(sum_marks.shape(), shifted_marks), rounded)
        return m

    def _words_out(self, m: Module) -> tuple[Value, list[Value]]:
        """The words that leave the drain register, and whether they are those of a pass."""
        steps = drain_steps(self._design)
        after_reset = Signal(init=1)
        capturing = Signal()
        draining = Signal()
        primed = Signal()
        last_step = Signal()
        next_step = Signal(counter_shape(steps - 1))
        m.d.sync += [
            after_reset.eq(0),
            self.complete.eq(self.completing),
            capturing.eq(self.completing | after_reset),
            next_step.eq(Mux(self.completing | after_reset, 0, next_step + 1)),
            last_step.eq(next_step == steps - 1),
            draining.eq(capturing | (draining & ~last_step)),
            primed.eq(primed | (draining & last_step)),
        ]
        m.d.comb += self.drained.eq(draining & last_step & primed)
        leaving = self._shift(m, capturing)
        before = self._before(m, leaving, draining, next_step)
        bits = len(leaving[0])
        words = [(word - before.word_select(number, bits))[:bits].as_signed() for number, word in enumerate(leaving)]
        return draining & primed, words

    def _shift(self, m: Module, capturing: Value) -> list[Value]:
        """The register, and the words that leave it."""
        captured = [Signal.like(total, name=f"captured{lane}", reset_less=True) for lane, total in enumerate(self.sums)]
        with m.If(capturing):
            m.d.sync += (word.eq(total) for word, total in zip(captured, self.sums, strict=True))
        with m.Else():
            m.d.sync += (word.eq(behind) for word, behind in zip(captured, captured[self._words :], strict=False))
        return captured[: self._words]

    def _before(self, m: Module, leaving: list[Value], draining: Value, next_step: Value) -> Value:
        """The same words of the pass before, from a memory that is read a cycle before it is written."""
        bits = len(leaving[0]) * len(leaving)
        before = Ram(m, "before", unsigned(bits), 1 << len(next_step))
        before.write(draining, register(m, next_step, "step"), Cat(leaving))
        return register(m, before.look_up(next_step), "before")

    def _group_counter(self, m: Module, leave: Value) -> tuple[Value, Value]:
        """Number of the group of W slots within its quad that leaves, and whether it completes the quad."""
        groups = 4 // self._words
        group = Signal(counter_shape(groups - 1))
        if groups > 1:
            with m.If(leave):
                m.d.sync += group.eq(group + 1)
        return group, group == groups - 1

    def _send(self, m: Module, marks: Any, rounded: list[Value]) -> None:
        """Slot ``s`` becomes parity ``s ^ flip``, group by group."""
        assembled = Signal(self.result.p.shape(), reset_less=True)
        complete = Signal()
        m.d.sync += complete.eq(marks.complete)
        m.d.sync += assembled.kind.eq(marks.kind)
        size = self._words
        for flip in sorted({row.flip for row in table(self._design)}):
            for slot in range(4):
                with m.If(marks.valid & (marks.flip == flip) & (marks.group == slot // size)):
                    m.d.sync += assembled.words[slot ^ flip].eq(rounded[slot % size])
        if self._design.cycles_per_quad > 1:
            sent = Signal.like(assembled, reset_less=True)  # which stands while groups of the next quad come
            with m.If(complete):
                m.d.sync += sent.eq(assembled)
            assembled, complete = sent, register(m, complete, "sent_valid", control=True)
        m.d.comb += self.result.valid.eq(complete)
        m.d.comb += self.result.payload.eq(assembled)
