"""Results of the matrix-vector unit: complete sums are shifted, rounded and permuted, four words at a time."""

from __future__ import annotations

from typing import Any

from amaranth import Cat, Const, Module, Mux, Signal, Value, signed
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from tfra.codegen.images import passes
from tfra.hdl.arithmetic import count, round_half, shift_right
from tfra.hdl.matvec_operand import amount_quad, pick_word, quad_parts
from tfra.hdl.payloads import vector_quad
from tfra.hdl.streams import Spare
from tfra.model.design import Design
from tfra.model.fixed.coefficients import PRODUCTS, stacks
from tfra.model.fixed.widths import widths


class Drain(wiring.Component):
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
                "amounts": In(amount_quad(design)),
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
                    shift.eq(offset + pick_word(self.amounts, part, number, self._words)),
                    shifted.eq(shift_right(wide, shift)),
                ]
            rounded.append(round_half(shifted))
        self._assemble(m, go, round_marks, rounded, assembled)
        m.submodules.spare = spare = Spare(self.result.p.shape())
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
        parts = quad_parts(self._design)
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
