"""The multiplier lanes: sums of Q products, one group of rows at a time, beside the program."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

from amaranth import Cat, Elaboratable, Module, Mux, Signal, signed
from amaranth.lib.memory import Memory

from tfra.hdl.lib.arithmetic import counter_shape
from tfra.hdl.serial import product
from tfra.hdl.serial.isa import MAC_DELAY
from tfra.hdl.serial.product import Product
from tfra.hdl.serial.sizes import Sizes
from tfra.hdl.serial.store import Store

_ARRIVAL = 2 + product.DELAY
"""Cycles from an address to its product: memory, a register behind it, and the product."""

assert MAC_DELAY == 2 + _ARRIVAL


class Lanes(Elaboratable):
    """Lanes that multiply the operand words from ``address`` on by the coefficients from ``pointer`` on.

    ::

        operands --\\
        store -----> product -> accumulator -> sums (shifted out by ``next``)

    ``start`` begins a group of ``quads`` products; its sums are in ``sum``, lane by lane, MAC_DELAY cycles after the
    last one.  ``set_pointer`` and ``load`` (a whole word) move the coefficients' pointer; ``write`` enters an operand.
    """

    def __init__(self, sizes: Sizes, quads: int, operands: int, depth: int, target: str) -> None:
        self._sizes, self._quads, self._depth, self._target = sizes, quads, depth, target
        self._operands = 1 << max(1, (operands - 1).bit_length())
        self.address = Signal(range(self._operands))
        self.start, self.next = Signal(), Signal()
        self.sum = Signal(signed(sizes.accumulator))
        self.pointer = Signal(range(depth))
        self.set_pointer, self.load = Signal(), Signal()
        self.word = Signal(sizes.lanes * sizes.coefficient)
        self.write, self.write_address = Signal(), Signal(range(self._operands))
        self.write_data = Signal(signed(sizes.operand))

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.operands = memory = Memory(shape=signed(self._sizes.operand), depth=self._operands, init=[])
        m.submodules.store = store = Store(len(self.word), self._depth, self._target)
        read, write = memory.read_port(), memory.write_port()
        address, here = Signal.like(self.address), Signal.like(self.pointer)
        left = Signal(counter_shape(self._quads - 1))
        run = Signal()
        flags = Signal(2 * _ARRIVAL)  # of each product on its way: first, last
        first = Signal()
        m.d.comb += [
            write.en.eq(self.write),
            write.addr.eq(self.write_address),
            write.data.eq(self.write_data),
            read.addr.eq(address),
            store.address.eq(here),
            store.i.eq(self.word),
            store.write.eq(self.load),
        ]
        m.d.sync += flags.eq(Cat(run & first, run & (left == 0), flags))
        with m.If(run):
            m.d.sync += [address.eq(address + 1), left.eq(left - 1), first.eq(0), run.eq(left != 0)]
        with m.If(self.start):
            m.d.sync += [run.eq(1), address.eq(self.address), left.eq(self._quads - 1), first.eq(1)]
        with m.If(self.set_pointer):
            m.d.sync += here.eq(self.pointer)
        with m.Elif(run | self.load):
            m.d.sync += here.eq(here + 1)
        self._sum(m, read.data, store.o, flags[-2], flags[-1])
        return m

    def _sum(self, m: Module, operand: Any, word: Any, first: Any, last: Any) -> None:
        bits, sizes = self._sizes.coefficient, self._sizes
        sums = [Signal(signed(sizes.accumulator), name=f"sum{lane}") for lane in range(sizes.lanes)]
        m.d.comb += self.sum.eq(sums[0])
        with m.If(self.next):
            m.d.sync += [here.eq(behind) for here, behind in pairwise(sums)]
        for lane, result in enumerate(sums):
            m.submodules[f"product{lane}"] = one = Product(sizes.operand, bits, sizes.operand + bits)
            total = Signal(signed(sizes.accumulator), name=f"total{lane}")
            new = Signal.like(total, name=f"new{lane}")
            m.d.sync += [
                one.a.eq(operand),
                one.b.eq(word[lane * bits : (lane + 1) * bits].as_signed()),
            ]
            m.d.comb += [
                new.eq(Mux(first, 0, total) + one.o),
            ]
            m.d.sync += total.eq(new)
            with m.If(last):
                m.d.sync += result.eq(new)
