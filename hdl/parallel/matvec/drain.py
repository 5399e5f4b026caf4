"""Results of the matrix-vector unit: complete sums are shifted, rounded and permuted, four words at a time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from amaranth import Array, Cat, Const, Module, Mux, Signal, Value, signed, unsigned
from amaranth.lib import data, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.arithmetic import counter_shape, round_half, shift_right, two_steps
from tfra.hdl.lib.pipeline import delayed, register
from tfra.hdl.lib.streams import always_ready_stream
from tfra.hdl.parallel.matvec.images import passes
from tfra.hdl.parallel.matvec.operand import amount_quad, pick_word
from tfra.hdl.parallel.payloads import product
from tfra.model.fixed.design import Design


@dataclass(frozen=True)
class _Step:
    """Quads that leave the drain register: how many, the offset of their right shift, flip, kind, start of a product.

    An operand that was moved left by ``amount`` has its result moved right by ``offset + amount``.  Quads without a
    kind come from lanes that had no row left; they are not sent.
    """

    quads: int
    offset: int
    flip: int
    kind: int | None
    start: bool


def drain_words(design: Design) -> int:
    """W: words that leave the drain register in a cycle."""
    return min(design.architecture.vector_words, design.architecture.mac_lanes)


def drain_steps(design: Design) -> int:
    """Cycles in which the words of a pass leave the drain register."""
    return design.architecture.mac_lanes // drain_words(design)


def drain_latency(design: Design) -> int:
    """Cycles from the capture of sums to their first result: drain register, amounts, two shifts, rounding and place.

    With parts of quads, one more for the register that stands while those of the next quad come.
    """
    return 5 + (design.cycles_per_quad > 1)


_FINE = 3
"""Bits of a shift by which its second step moves: about half of them."""


class Drain(wiring.Component):
    """From complete sums to results on the vector grid.

        sums -> drain register -> W words - those of the pass before, right shifts -> shifted -> rounded, in place
            -> output

    Nothing behind the sums waits, since products begin only when there is a place for their results.  Sums run on
    from anything: behind a reset they are captured once, as those of a pass before the first, with no results.

    Members:
        sums, completing: L running sums; high a cycle before they are those of a pass.  The register is free then,
            since passes are as many cycles apart as it has steps.
        amounts: alignment of the operand of the pass in the drain register.
        complete: out, a cycle behind ``completing``: sums are captured.
        new, stack: beside ``completing``, whether the pass is its product's first; its stack.
        drained: the last words of a pass leave the drain register.
        result: stream out.
    """

    def __init__(self, design: Design) -> None:
        self._design, self._lanes = design, design.architecture.mac_lanes
        self._words = drain_words(design)
        w = design.widths
        self._steps = self._table()
        self._offset = max(step.offset for step in self._steps)
        self._shift = counter_shape(self._offset + w.vector - 1)
        super().__init__(
            {
                "sums": In(signed(w.accumulator)).array(self._lanes),
                "completing": In(1),
                "complete": Out(1),
                "amounts": In(amount_quad(design)),
                "new": In(1),
                "stack": In(2),
                "drained": Out(1),
                "result": Out(always_ready_stream(product(design))),
            }
        )

    def _table(self) -> list[_Step]:
        """What leaves the drain register, product by product in the order of the stacks."""
        design, w, table = self._design, self._design.widths, []
        for name in self._design.stacks:
            stack, start = design.stacks[name], True
            for op in stack.operators:
                offset = w.alignment + op.fraction + design.formats.operand - w.vector
                table.append(_Step(op.quads, offset, op.flip, design.kinds.index(op.name), start))
                start = False
            idle = passes(design, name) * self._lanes // 4 - stack.quads
            if idle:
                table.append(_Step(idle, 0, 0, None, False))
        return table

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        w = self._design.widths
        words, valid = self._register(m)
        part, whole = self._part_counter(m, valid)
        place = self._place(m, valid & whole)
        kind = self.result.p.kind.shape()
        marks = data.StructLayout({"valid": 1, "complete": 1, "flip": 2, "part": part.shape(), "kind": kind})
        shift_marks = Signal(marks)
        round_marks = data.View(marks, delayed(m, shift_marks.as_value(), 2, "marks", control=True))
        done = Signal()
        assembled = Signal(self.result.p.shape(), reset_less=True)
        m.d.sync += [
            shift_marks.valid.eq(valid),
            shift_marks.complete.eq(valid & whole & place.send),
            shift_marks.flip.eq(place.flip),
            shift_marks.part.eq(part),
            shift_marks.kind.eq(place.kind),
            done.eq(round_marks.complete),
            assembled.kind.eq(round_marks.kind),
        ]
        rounded = []
        for number, word in enumerate(words):
            sum_ = Signal(signed(w.accumulator), name=f"sum{number}", reset_less=True)
            shift = Signal(self._shift, name=f"shift{number}", reset_less=True)
            shifted = Signal(signed(w.vector + 1), name=f"shifted{number}", reset_less=True)
            wide = Cat(Const(0, w.alignment), sum_).as_signed()
            (coarse, _), (_, fine) = two_steps(shift, _FINE), two_steps(register(m, shift, "later"), _FINE)
            moved = shift_right(wide, coarse)[: w.vector + 1 + (1 << _FINE)].as_signed()
            m.d.sync += [
                sum_.eq(word),
                shift.eq(place.offset + pick_word(self.amounts, part, number, self._words)),
                shifted.eq(register(m, moved, "coarse") >> fine),
            ]
            rounded.append(round_half(shifted))
        self._assemble(m, round_marks, rounded, assembled.words)
        if self._design.cycles_per_quad > 1:
            out = Signal.like(assembled, reset_less=True)  # which stands while parts of the next quad come
            with m.If(done):
                m.d.sync += out.eq(assembled)
            assembled, done = out, register(m, done, "sent", control=True)
        m.d.comb += [self.result.valid.eq(done), self.result.payload.eq(assembled)]
        return m

    def _register(self, m: Module) -> tuple[list[Value], Value]:
        """Sums are captured, and leave W words at a time; it moves on even when it is empty, to have one broadcast.

        Returns those that leave, without what they were a pass ago, and whether they are there.
        """
        steps = drain_steps(self._design)
        words = [Signal.like(s, name=f"held{n}", reset_less=True) for n, s in enumerate(self.sums)]
        fresh, begun, full = Signal(init=1), Signal(), Signal()  # full: with sums of the pass before the first, too
        capture, last = Signal(), Signal()
        coming = Signal(counter_shape(steps - 1))  # what leaves in the next cycle
        m.d.comb += self.drained.eq(full & last & begun)
        m.d.sync += [
            fresh.eq(0),
            begun.eq(begun | (full & last)),
            self.complete.eq(self.completing),
            capture.eq(self.completing | fresh),
            coming.eq(Mux(self.completing | fresh, 0, coming + 1)),
            last.eq(coming == steps - 1),
            full.eq(capture | (full & ~last)),
        ]
        with m.If(capture):
            m.d.sync += (held.eq(s) for held, s in zip(words, self.sums, strict=True))
        with m.Else():
            m.d.sync += (a.eq(b) for a, b in zip(words, words[self._words :], strict=False))
        leaving = words[: self._words]
        return self._differences(m, leaving, coming, full), full & begun

    def _differences(self, m: Module, words: list[Value], coming: Value, keep: Value) -> list[Value]:
        """Words less what they were a pass ago, modulo their length: exact, since the sum of a pass fits."""
        bits = len(words[0])
        m.submodules.before = memory = Memory(shape=unsigned(bits * len(words)), depth=1 << len(coming), init=[])
        write, read = memory.write_port(), memory.read_port(domain="comb")
        m.d.comb += [
            write.en.eq(keep),
            write.addr.eq(register(m, coming, "step")),
            write.data.eq(Cat(words)),
            read.addr.eq(coming),
        ]
        before = register(m, read.data, "before")
        return [(word - before.word_select(n, bits))[:bits].as_signed() for n, word in enumerate(words)]

    def _part_counter(self, m: Module, leave: Value) -> tuple[Value, Value]:
        """Which words of their quad those that leave are, and whether they complete it."""
        parts = 4 // self._words
        part = Signal(counter_shape(parts - 1))
        if parts > 1:
            with m.If(leave):
                m.d.sync += part.eq(part + 1)
        return part, part == parts - 1

    def _place(self, m: Module, leave: Value) -> data.View:
        """Offset, flip, kind and fate of the quad that leaves the drain register; a product's first pass jumps."""
        step = Signal(counter_shape(len(self._steps) - 1))
        left = Signal(counter_shape(max(s.quads for s in self._steps) - 1))
        kind = self.result.p.kind.shape()
        place = Signal(data.StructLayout({"offset": counter_shape(self._offset), "flip": 2, "kind": kind, "send": 1}))
        end = Signal()
        with m.Switch(step):
            for number, row in enumerate(self._steps):
                with m.Case(number):
                    m.d.comb += [
                        place.offset.eq(row.offset),
                        place.flip.eq(row.flip),
                        place.kind.eq(0 if row.kind is None else 1 << row.kind),
                        place.send.eq(row.kind is not None),
                        end.eq(left == row.quads - 1),
                    ]
        with m.If(leave):
            m.d.sync += [left.eq(Mux(end, 0, left + 1)), step.eq(step + end)]
        starts = [number for number, row in enumerate(self._steps) if row.start]
        start = register(m, Array(starts)[self.stack], "start")
        with m.If(register(m, self.completing & self.new, "starts", control=True)):
            m.d.sync += [left.eq(0), step.eq(start)]
        return place

    def _assemble(self, m: Module, marks: Any, rounded: list[Value], quad: Any) -> None:
        """Slot ``s`` becomes parity ``s ^ flip``; with fewer than four words at a time, a part of the quad."""
        size = self._words
        for flip in sorted({step.flip for step in self._steps}):
            for slot in range(4):
                with m.If(marks.valid & (marks.flip == flip) & (marks.part == slot // size)):
                    m.d.sync += quad[slot ^ flip].eq(rounded[slot % size])
