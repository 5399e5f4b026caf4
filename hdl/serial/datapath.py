"""The datapath: an instruction fetches its operands, is executed, and then writes its register."""

from typing import Any

from amaranth import Cat, Const, Module, Mux, Shape, Signal, Value, signed
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.serial.alu import ADDS, FINE, Alu, coarse, signs
from tfra.hdl.serial.isa import ADDRESS_BITS, NO_RESULT, REGISTERS, Dest, Left, Op, Src
from tfra.hdl.serial.sequencer import INSTRUCTION
from tfra.hdl.serial.sizes import Sizes

STAGE = data.StructLayout({"instruction": INSTRUCTION, "address": ADDRESS_BITS, "valid": 1})
"""A stage of the pipeline: an instruction, its effective address, and valid."""


class Datapath(wiring.Component):
    """Registers R0 to R5, T, K, Y, SH and the flags, and the paths between them.

    ::

        decoded ─▶ fetching ─▶ executing ─▶ last
                   operands    ALU          the result, on its way to a register, a flag or the memory

    An instruction in ``fetching`` reads registers; the one in ``executing`` has not written its result yet.  The result
    in ``last`` is forwarded, and the one that the ALU computes replaces the operand a cycle later.
    """

    def __init__(self, sizes: Sizes, taxel: Shape) -> None:
        self._sizes = sizes
        word = signed(sizes.word)
        super().__init__({
            "advance": In(1),  # all stages advance
            "decoded": In(STAGE),  # what enters ``fetching``
            "fetching": Out(STAGE),  # the instruction that fetches operands
            "executing": Out(STAGE),  # the instruction that is executed
            "memory_word": In(word),  # the data memory's word for ``fetching``
            "last_product": In(word),  # the multiplier's last product
            "sum": In(word),  # the next lane's sum
            "taxel": In(taxel),  # the next code
            "takes": Out(1),  # ``fetching`` needs ``taxel``
            "acts": Out(1),  # the condition of ``executing`` holds; high in a cycle with ``advance``
            "delivers": Out(1),  # ``acts``, and the operation has a result
            "source": Out(word),  # second operand of ``executing``
            "y": Out(signed(sizes.multiplier)),  # the register Y
            "total": Out(word),  # the result of ``executing`` if it is a sum: sooner than ``result``
            "result": Out(word),  # the result of ``executing``
            "shifted": Out(signed(sizes.word + 1)),  # T of ``executing``, if that is SHIFT or LENGTH
            "last": Out(word),  # the result before
            "gives": Out(1),  # ``last`` is a word of the result stream
            "ends": Out(1),  # it is a frame's last word
        })

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.alu = alu = Alu(self._sizes)
        acts = Signal()  # as self.acts, but for the enable
        shifts = Signal()
        writes = Signal(REGISTERS)  # the registers that executing writes
        written = Signal(REGISTERS)  # the registers that last is for
        divided = Signal()  # last is the result of DIV
        e = self.executing.instruction
        has_result = acts & ~Cat(e.op == op for op in NO_RESULT).any()
        m.d.comb += [
            acts.eq(self.executing.valid & self._condition(m)),
            shifts.eq(acts & ((e.op == Op.SHIFT) | (e.op == Op.LENGTH))),
            writes.eq(Cat(has_result & (e.dest == Dest.R0 + number) for number in range(REGISTERS))),
            self.acts.eq(self.advance & acts),
            self.delivers.eq(self.advance & has_result),
            self.takes.eq(self.fetching.valid & (self.fetching.instruction.source == Src.IN)),
            self.result.eq(alu.result),
            self.total.eq(alu.total),
            self.shifted.eq(alu.shifted),
        ]
        with m.If(self.advance):
            m.d.sync += [
                self.fetching.eq(self.decoded),
                self.executing.eq(self.fetching),
                self.last.eq(alu.result),
                written.eq(writes),
                divided.eq(e.op == Op.DIV),
                self.gives.eq(has_result & ((e.dest == Dest.OUT) | (e.dest == Dest.LAST))),
                self.ends.eq(e.dest == Dest.LAST),
            ]
        t, k = self._divide(m, acts, shifts, divided & written.any())
        limited = self._limit(m, acts, alu.limited)
        arrived = Mux(divided & self.last[-1], 0, written)  # a negative difference of DIV is dropped
        left, source = self._fetch(m, t, k, limited, arrived)
        self._execute(m, alu, left, source, writes, shifts, t[0])
        return m

    def _condition(self, m: Module) -> Value:
        """Whether the condition of ``executing`` holds: known when it enters, except for a flag that was just set."""
        f, e = self.fetching.instruction, self.executing.instruction
        flags = Signal(2)
        last_sets = Signal(2)  # the flags that take the sign of last
        flags_now = Signal(2)
        asks = Cat(f.when >> 1 == 1, f.when >> 1 == 2)  # for F0, for F1
        asks_executing = Signal()  # for a flag that executing sets
        known = Signal()  # the condition, with zero for a flag that is on its way
        asked_last = Signal()  # such a flag was needed
        m.d.comb += [
            flags_now.eq(Cat(Mux(new, self.last[-1], flag) for new, flag in zip(last_sets, flags, strict=True))),
            asks_executing.eq(self.delivers & (asks & e.flag).any()),
        ]
        with m.If(self.advance):
            m.d.sync += [
                flags.eq(flags_now),
                last_sets.eq(Mux(self.delivers, e.flag, 0)),
                asked_last.eq(asks_executing),
                known.eq(Mux(asks.any(), f.when[0] ^ (~asks_executing & (asks & flags_now).any()), 1)),
            ]
        return known ^ (asked_last & self.last[-1])

    def _divide(self, m: Module, acts: Value, shifts: Value, step_ends: Value) -> tuple[Signal, Signal]:
        """T, with a bit below the point, and the quotient K."""
        t = Signal(signed(self._sizes.word + 1))
        k = Signal(self._sizes.quotient)
        with m.If(self.advance):
            with m.If(step_ends):
                m.d.sync += k.eq(Cat(~self.last[-1], k))
            with m.If(shifts):
                m.d.sync += t.eq(self.shifted)
                m.d.sync += k.eq(0)
            with m.If(acts & (self.executing.instruction.op == Op.DIV)):
                m.d.sync += t.eq(t >> 1)
        return t, k

    def _limit(self, m: Module, acts: Value, limits: Value) -> Signal:
        """Whether LIMIT has changed a word; reading it clears it."""
        limited = Signal()
        with m.If(self.advance):
            with m.If(self.fetching.valid & (self.fetching.instruction.source == Src.LIMITED)):
                m.d.sync += limited.eq(0)
            with m.If(acts & (self.executing.instruction.op == Op.LIMIT) & limits):
                m.d.sync += limited.eq(1)
        return limited

    def _fetch(self, m: Module, t: Value, k: Value, limited: Value, arrived: Value) -> tuple[Signal, Signal]:
        """Operands of ``fetching``; registers take the last result where it has ``arrived``."""
        i, word = self.fetching.instruction, signed(self._sizes.word)
        lefts: dict[int, Any] = {Left.ZERO: Const(0), Left.T: t[1:].as_signed()}
        sources: dict[int, Any] = {
            Src.M: self.memory_word,
            Src.FLOOR: t[1:].as_signed(),
            Src.IMM: i.immediate.as_signed(),
            Src.PRODUCT: self.last_product,
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
        left = Signal(word)
        source = Signal(word)
        for target, choices, select in ((left, lefts, i.left), (source, sources, i.source)):
            with m.Switch(select):
                for choice, value in choices.items():
                    with m.Case(int(choice)):
                        m.d.comb += target.eq(value)
        return left, source

    def _execute(
        self, m: Module, alu: Alu, left: Value, source: Value, writes: Value, shifts: Value, half: Value
    ) -> None:
        """Operands to the ALU, with the last result forwarded where ``executing`` writes what ``fetching`` reads."""
        f, word = self.fetching.instruction, self._sizes.word
        left_operand = Signal.like(left)
        addend = Signal.like(left)
        left_is_last = Signal()
        source_is_last = Signal()
        last_inverted = Signal()  # where last is the addend; LATE operations never have it
        carry = Signal()
        rounds = Signal()
        adds = Signal()
        subtract, drop = signs(f.op, source[-1])

        def reads_result(choice: Value, registers: int, shifted: int) -> Value:
            same = Cat(writes[n] & (choice == registers + n) for n in range(REGISTERS))
            return same.any() | (shifts & (choice == shifted))

        with m.If(self.advance):
            m.d.sync += [
                left_operand.eq(left),
                self.source.eq(source),
                addend.eq(Mux(drop, 0, source) ^ subtract.replicate(word).as_signed()),
                left_is_last.eq(reads_result(f.left, Left.R0, Left.T)),
                source_is_last.eq(reads_result(f.source, Src.R0, Src.FLOOR)),
                last_inverted.eq((f.op == Op.SUB) | (f.op == Op.DIV)),
                carry.eq(subtract),
                rounds.eq(f.left == Left.T),
                adds.eq(Cat(f.op == op for op in ADDS).any()),
            ]
        m.d.comb += [
            alu.op.eq(self.executing.instruction.op),
            alu.left.eq(Mux(left_is_last, self.last, left_operand)),
            alu.source.eq(self.source),
            alu.addend.eq(Mux(source_is_last, self.last ^ last_inverted.replicate(word).as_signed(), addend)),
            alu.adds.eq(adds),
            alu.carry.eq(carry | (rounds & half)),
        ]
        self._shift(m, alu, source)

    def _shift(self, m: Module, alu: Alu, source: Value) -> None:
        """Y and SH; the coarse half of a shift, which is done while the operand is fetched."""
        e = self.executing.instruction
        amount = Signal(self._sizes.shift)  # SH + reach, which is not negative
        shifted = Signal.like(alu.coarse)
        with m.If(self.advance):
            m.d.sync += shifted.eq(coarse(self._sizes, source, amount))
        with m.If(self.delivers & (e.dest == Dest.Y)):
            m.d.sync += self.y.eq(alu.total)
        with m.If(self.delivers & (e.dest == Dest.SH)):
            m.d.sync += amount.eq(alu.total + self._sizes.reach)
        m.d.comb += alu.coarse.eq(shifted)
        m.d.comb += alu.fine.eq(amount[:FINE])
