"""Passes of the matrix-vector unit: when one begins, and what it reads."""

from __future__ import annotations

from typing import Any

from amaranth import Module, Mux, Signal, Value
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from tfra.codegen.images import bases, passes
from tfra.hdl.arithmetic import count
from tfra.hdl.matvec_operand import quad_parts
from tfra.model.design import Design
from tfra.model.fixed.coefficients import PRODUCTS


class Schedule(wiring.Component):
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
                "read_part": Out(count(quad_parts(design) - 1)),
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
        busy, parts = Signal(2), quad_parts(self._design)
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
