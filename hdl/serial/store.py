"""The coefficient store: one port, written once after reset, then read."""

from __future__ import annotations

from typing import Any

from amaranth import ClockSignal, Const, Instance, Module, Signal, unsigned
from amaranth.lib import wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

_CELL, _WIDTH, _DEPTH = "SB_SPRAM256KA", 16, 1 << 14


def cells(target: str) -> tuple[str, ...]:
    """Types of the cells that a store for ``target`` is made of."""
    return (_CELL,) if target == "ice40" else ()


class Store(wiring.Component):
    """``depth`` words of ``bits`` without initial contents.

    For ``target`` "ice40" it is made of SB_SPRAM256KA, otherwise it is a plain memory.
    """

    def __init__(self, bits: int, depth: int, target: str) -> None:
        self._bits, self._depth, self._target = bits, depth, target
        super().__init__(
            {
                "address": In(range(depth)),
                "write": In(1),  # write ``write_data`` in this cycle instead of reading
                "write_data": In(bits),
                "data": Out(bits),  # the word at the address of the cycle before
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        if cells(self._target):
            self._wire_cells(m)
        else:
            self._wire_memory(m)
        return m

    def _wire_memory(self, m: Module) -> None:
        m.submodules.memory = memory = Memory(shape=unsigned(self._bits), depth=self._depth, init=[])
        read, write = memory.read_port(), memory.write_port()
        m.d.comb += [
            read.addr.eq(self.address),
            read.en.eq(~self.write),
            self.data.eq(read.data),
            write.addr.eq(self.address),
            write.data.eq(self.write_data),
            write.en.eq(self.write),
        ]

    def _wire_cells(self, m: Module) -> None:
        count = -(-self._bits // _WIDTH)
        padded = Signal(count * _WIDTH)
        found = Signal(count * _WIDTH)
        address = Signal(range(_DEPTH))
        m.d.comb += [padded.eq(self.write_data), self.data.eq(found), address.eq(self.address)]
        for number in range(count):
            part = slice(number * _WIDTH, (number + 1) * _WIDTH)
            m.submodules[f"block{number}"] = Instance(
                _CELL,
                i_ADDRESS=address,
                i_DATAIN=padded[part],
                i_MASKWREN=Const(0b1111, 4),
                i_WREN=self.write,
                i_CHIPSELECT=Const(1),
                i_CLOCK=ClockSignal(),
                i_STANDBY=Const(0),
                i_SLEEP=Const(0),
                i_POWEROFF=Const(1),
                o_DATAOUT=found[part],
            )
