"""The datapath: an instruction fetches its operands, is executed, and then writes its register."""

from __future__ import annotations

from typing import Any

from amaranth import Cat, Const, Elaboratable, Module, Mux, Shape, Signal, Value, signed
from amaranth.lib import data

from tfra.hdl.serial.alu import ADDS, FINE, Alu, coarse, signs
from tfra.hdl.serial.isa import ADDRESS_BITS, NO_RESULT, REGISTERS, Dest, Left, Op, Src
from tfra.hdl.serial.sequencer import LAYOUT
from tfra.hdl.serial.sizes import Sizes

STAGE = data.StructLayout({"instruction": LAYOUT, "address": ADDRESS_BITS, "valid": 1})


class Datapath(Elaboratable):
    """Registers, T, K, Y, SH, the flags, and the way around them.

    ``decoded`` enters ``o``, which fetches operands, and then ``e``, which is executed, in cycles with ``advance``.
    ``source`` and ``result`` are those of ``e`` (``total`` if it is a sum), ``acts`` says that its condition holds and
    ``delivers`` that it has a result, too.  ``last`` is the result before, for the result stream if it ``gives``;
    ``takes``: ``o`` needs ``taxel``.
    """

    def __init__(self, sizes: Sizes, taxel: Shape) -> None:
        self._sizes = sizes
        word = signed(sizes.word)
        self.advance, self.takes, self.gives, self.ends, self.acts, self.delivers = (Signal() for _ in range(6))
        self.decoded, self.o, self.e = Signal(STAGE), Signal(STAGE), Signal(STAGE)
        self.memory, self.product, self.sum, self.taxel = Signal(word), Signal(word), Signal(word), Signal(taxel)
        self.source, self.result, self.total, self.last = (Signal(word) for _ in range(4))
        self.y = Signal(signed(sizes.multiplier))

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.alu = alu = Alu(self._sizes)
        t, k = Signal(signed(self._sizes.word + 1)), Signal(self._sizes.quotient)
        limited, divided, written = Signal(), Signal(), Signal(REGISTERS)
        e, go, shifts, writes = self.e.instruction, Signal(), Signal(), Signal(REGISTERS)
        gives_result = go & ~Cat(e.op == op for op in NO_RESULT).any()
        m.d.comb += [
            go.eq(self.e.valid & self._condition(m)),
            shifts.eq(go & ((e.op == Op.SHIFT) | (e.op == Op.LENGTH))),
            writes.eq(Cat(gives_result & (e.dest == Dest.R0 + number) for number in range(REGISTERS))),
            self.acts.eq(self.advance & go),
            self.delivers.eq(self.advance & gives_result),
            self.takes.eq(self.o.valid & (self.o.instruction.source == Src.IN)),
            self.result.eq(alu.result),
            self.total.eq(alu.total),
        ]
        with m.If(self.advance):
            m.d.sync += [
                self.o.eq(self.decoded),
                self.e.eq(self.o),
                self.last.eq(alu.result),
                written.eq(writes),
                divided.eq(e.op == Op.DIV),
                self.gives.eq(gives_result & ((e.dest == Dest.OUT) | (e.dest == Dest.LAST))),
                self.ends.eq(e.dest == Dest.LAST),
            ]
            with m.If(divided & written.any()):
                m.d.sync += k.eq(Cat(~self.last[-1], k))
            with m.If(shifts):
                m.d.sync += [t.eq(alu.shifted), k.eq(0)]
            with m.If(go & (e.op == Op.DIV)):
                m.d.sync += t.eq(t >> 1)
            with m.If(self.o.valid & (self.o.instruction.source == Src.LIMITED)):
                m.d.sync += limited.eq(0)
            with m.If(go & (e.op == Op.LIMIT) & alu.limited):
                m.d.sync += limited.eq(1)
        left, source = self._fetch(m, t, k, limited, Mux(divided & self.last[-1], 0, written))
        self._operands(m, alu, left, source, writes, shifts, t[0])
        return m

    def _condition(self, m: Module) -> Value:
        """Whether the flags let an instruction act; nearly all of it is known before, but for the sign in ``last``."""
        o, e, flags, sets, now = self.o.instruction, self.e.instruction, Signal(2), Signal(2), Signal(2)
        asks = Cat(o.when >> 1 == 1, o.when >> 1 == 2)
        follows, given, follow = Signal(), Signal(), Signal()
        m.d.comb += [
            now.eq(Cat(Mux(new, self.last[-1], flag) for new, flag in zip(sets, flags, strict=True))),
            follow.eq(self.delivers & (asks & e.flag).any()),
        ]
        with m.If(self.advance):
            m.d.sync += [
                flags.eq(now),
                sets.eq(Mux(self.delivers, e.flag, 0)),
                follows.eq(follow),
                given.eq(Mux(asks.any(), o.when[0] ^ (~follow & (asks & now).any()), 1)),
            ]
        return given ^ (follows & self.last[-1])

    def _fetch(self, m: Module, t: Value, k: Value, limited: Value, arrived: Value) -> tuple[Signal, Signal]:
        """Operands of ``o``; registers take the last result where it has ``arrived``."""
        i, word = self.o.instruction, signed(self._sizes.word)
        lefts: dict[int, Any] = {Left.ZERO: Const(0), Left.T: t[1:].as_signed()}
        sources: dict[int, Any] = {
            Src.M: self.memory,
            Src.FLOOR: t[1:].as_signed(),
            Src.IMM: i.immediate.as_signed(),
            Src.PRODUCT: self.product,
            Src.SUM: self.sum,
            Src.IN: self.taxel,
            Src.K: Cat(k, Const(0, 1)).as_signed(),
            Src.LIMITED: limited.as_signed(),
        }
        for number in range(REGISTERS):
            register = Signal(word, name=f"r{number}")
            value = Mux(arrived[number], self.last, register)
            lefts[Left.R0 + number] = sources[Src.R0 + number] = value
            with m.If(self.advance):
                m.d.sync += register.eq(value)
        left, source = Signal(word), Signal(word)
        for target, choices, select in ((left, lefts, i.left), (source, sources, i.source)):
            with m.Switch(select):
                for choice, value in choices.items():
                    with m.Case(int(choice)):
                        m.d.comb += target.eq(value)
        return left, source

    def _operands(
        self, m: Module, alu: Alu, left: Value, source: Value, writes: Value, shifts: Value, half: Value
    ) -> None:
        """Operands from ``o`` to the ALU, but the last result where ``e`` writes what ``o`` reads."""
        o, e, word = self.o.instruction, self.e.instruction, self._sizes.word
        first, addend, left_is_last, source_is_last = Signal.like(left), Signal.like(left), Signal(), Signal()
        inverts, carry, rounds, adds, amount = Signal(), Signal(), Signal(), Signal(), Signal(self._sizes.shift)
        shifted = Signal.like(alu.coarse)
        subtract, drop = signs(o.op, source[-1])

        def follows(choice: Value, registers: int, shifted: int) -> Value:
            same = Cat(writes[n] & (choice == registers + n) for n in range(REGISTERS))
            return same.any() | (shifts & (choice == shifted))

        with m.If(self.advance):
            m.d.sync += [
                first.eq(left),
                self.source.eq(source),
                shifted.eq(coarse(self._sizes, source, amount)),
                addend.eq(Mux(drop, 0, source) ^ subtract.replicate(word).as_signed()),
                left_is_last.eq(follows(o.left, Left.R0, Left.T)),
                source_is_last.eq(follows(o.source, Src.R0, Src.FLOOR)),
                inverts.eq((o.op == Op.SUB) | (o.op == Op.DIV)),
                carry.eq(subtract),
                rounds.eq(o.left == Left.T),
                adds.eq(Cat(o.op == op for op in ADDS).any()),
            ]
        with m.If(self.delivers & (e.dest == Dest.Y)):
            m.d.sync += self.y.eq(alu.total)
        with m.If(self.delivers & (e.dest == Dest.SH)):
            m.d.sync += amount.eq(alu.total + self._sizes.reach)
        m.d.comb += [
            alu.op.eq(e.op),
            alu.left.eq(Mux(left_is_last, self.last, first)),
            alu.source.eq(self.source),
            alu.addend.eq(Mux(source_is_last, self.last ^ inverts.replicate(word).as_signed(), addend)),
            alu.adds.eq(adds),
            alu.carry.eq(carry | (rounds & half)),
            alu.coarse.eq(shifted),
            alu.fine.eq(amount[:FINE]),
        ]
