"""The multiplier lanes: sums of Q products, one group of rows at a time, in parallel with the program."""

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

from amaranth import Array, Cat, Module, Mux, Signal, Value, signed
from amaranth.lib import wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.arithmetic import counter_shape
from tfra.hdl.primitives import Store
from tfra.hdl.serial import product
from tfra.hdl.serial.isa import MAC_DELAY
from tfra.hdl.serial.product import Product
from tfra.hdl.serial.sizes import Sizes

_ARRIVAL = 2 + product.DELAY
"""Cycles from an address to its product: memory, a register after it, and the product."""

assert MAC_DELAY == 2 + _ARRIVAL


class Lanes(wiring.Component):
    """Every lane multiplies the words of an operand by its coefficients and sums up the products.

    ::

        operands ──┐
        store ─────┴─▶ products ─▶ totals ─▶ sums (shifted out by ``next``)

    The sums of a group are valid ``MAC_DELAY`` cycles after its last product has begun, until those of the next group.
    """

    def __init__(self, sizes: Sizes, lengths: Sequence[int], operands: int, depth: int, target: str) -> None:
        self._sizes, self._lengths, self._depth, self._target = sizes, lengths, depth, target
        self._operands = 1 << max(1, (operands - 1).bit_length())
        super().__init__({
            "start": In(1),  # begin a group
            "address": In(range(self._operands)),  # of the group's first operand
            "next": In(1),  # shift out the next lane's sum
            "sum": Out(signed(sizes.accumulator)),  # of the lanes in their order
            "set_pointer": In(1),  # ``pointer`` is the address of the next coefficients
            "pointer": In(range(depth)),
            "load": In(1),  # write ``word`` to the store, at the coefficients' address, which increments
            "word": In(sizes.lanes * sizes.coefficient),  # a coefficient of every lane
            "write": In(1),  # write an operand
            "write_address": In(range(self._operands)),  # of that operand
            "write_data": In(signed(sizes.operand)),
            # which of ``lengths`` is the number of the group's products
            **({"length": In(range(len(lengths)))} if len(lengths) > 1 else {}),
        })

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.operands = operands = Memory(shape=signed(self._sizes.operand), depth=self._operands, init=[])
        m.submodules.store = store = Store(len(self.word), self._depth, self._target)
        read, write = operands.read_port(), operands.write_port()
        operand_address = Signal.like(self.address)
        coefficient_address = Signal.like(self.pointer)
        m.d.comb += [
            write.en.eq(self.write),
            write.addr.eq(self.write_address),
            write.data.eq(self.write_data),
            read.addr.eq(operand_address),
            store.address.eq(coefficient_address),
            store.write_data.eq(self.word),
            store.write.eq(self.load),
        ]
        running, first, last = self._run(m, operand_address)
        with m.If(self.set_pointer):
            m.d.sync += coefficient_address.eq(self.pointer)
        with m.Elif(running | self.load):
            m.d.sync += coefficient_address.eq(coefficient_address + 1)
        self._multiply(m, read.data, store.data, first, last)
        return m

    def _run(self, m: Module, operand_address: Signal) -> tuple[Value, Value, Value]:
        """Whether a product begins, and whether the one that arrives is the first, or the last, of its group."""
        running = Signal()
        is_first = Signal()
        following = Array(length - 1 for length in self._lengths)  # products after a group's first
        products_left = Signal(counter_shape(max(self._lengths) - 1))
        marks = Signal(2 * _ARRIVAL)  # first and last of each product on its way
        m.d.sync += marks.eq(Cat(running & is_first, running & (products_left == 0), marks))
        with m.If(running):
            m.d.sync += [
                operand_address.eq(operand_address + 1),
                products_left.eq(products_left - 1),
                is_first.eq(0),
                running.eq(products_left != 0),
            ]
        with m.If(self.start):
            m.d.sync += [
                running.eq(1),
                operand_address.eq(self.address),
                products_left.eq(following[self.length] if len(following) > 1 else following[0]),
                is_first.eq(1),
            ]
        return running, marks[-2], marks[-1]

    def _multiply(self, m: Module, operand: Value, coefficients: Value, first: Value, last: Value) -> None:
        """Products and accumulators of all lanes, and the register of sums that shifts them out."""
        bits, sizes = self._sizes.coefficient, self._sizes
        sums = [Signal(signed(sizes.accumulator), name=f"sum{lane}") for lane in range(sizes.lanes)]
        m.d.comb += self.sum.eq(sums[0])
        with m.If(self.next):
            m.d.sync += [here.eq(behind) for here, behind in pairwise(sums)]
        for lane, result in enumerate(sums):
            m.submodules[f"product{lane}"] = lane_product = Product(sizes.operand, bits, sizes.operand + bits)
            total = Signal(signed(sizes.accumulator), name=f"total{lane}")
            new_total = Signal.like(total, name=f"new_total{lane}")
            m.d.sync += [
                lane_product.a.eq(operand),
                lane_product.b.eq(coefficients[lane * bits : (lane + 1) * bits].as_signed()),
                total.eq(new_total),
            ]
            m.d.comb += new_total.eq(Mux(first, 0, total) + lane_product.o)
            with m.If(last):
                m.d.sync += result.eq(new_total)
