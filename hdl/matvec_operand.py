"""Operands of the matrix-vector unit: two banks of quads, aligned and rounded on their way to the lanes."""

from __future__ import annotations

from typing import Any

from amaranth import Array, Cat, Module, Mux, Signal, Value, signed, unsigned
from amaranth.lib import data, stream, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from tfra.hdl.arithmetic import count, leading_zeros, magnitude_bits, round_top
from tfra.hdl.payloads import vector_quad
from tfra.model.design import Design
from tfra.model.fixed.widths import widths


def amount_quad(design: Design) -> data.ArrayLayout:
    """Left shifts that align the four parities of an operand."""
    return data.ArrayLayout(unsigned((widths(design).vector - 1).bit_length()), 4)


def quad_parts(design: Design) -> int:
    """Passes that it takes to complete a result quad: four words over the lanes, or one."""
    return 4 // min(4, design.architecture.mac_lanes)


def pick_word(words: Any, part: Value, word: int, size: int) -> Value:
    """Word ``part * size + word`` of a quad."""
    choices = [words[number] for number in range(word, 4, size)]
    return choices[0] if size == 4 else Array(choices)[part]


class OperandBuffer(wiring.Component):
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
                "amounts": Out(data.ArrayLayout(amount_quad(design), 2)),
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


class Prepare(wiring.Component):
    """Operand words from a quad of the buffer: aligned, then rounded; three registers.

    Fewer than four lanes need fewer words: ``part`` tells which.
    """

    def __init__(self, design: Design) -> None:
        self._design, self._words = design, min(4, design.architecture.mac_lanes)
        super().__init__(
            {
                "quad": In(vector_quad(design)),
                "amounts": In(amount_quad(design)),
                "part": In(count(quad_parts(design) - 1)),
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
                raw.eq(pick_word(self.quad, self.part, word, self._words)),
                amount.eq(pick_word(self.amounts, self.part, word, self._words)),
                aligned.eq(raw << amount),
                self.words[word].eq(round_top(aligned, self._design.formats.operand)),
            ]
        return m
