"""The coefficient store: one port, written once after reset, then read."""

from typing import Any

from amaranth import Module, unsigned
from amaranth.lib import wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from tfra.hdl.primitives.gateware import GATEWARE


class Store(wiring.Component):
    """``depth`` words of ``bits`` without initial contents.

    For ``target`` "ice40" it is made of SB_SPRAM256KA, otherwise it is a plain memory.
    """

    def __init__(self, bits: int, depth: int, target: str) -> None:
        self._bits, self._depth, self._cells = bits, depth, GATEWARE[target].store
        super().__init__({
            "address": In(range(depth)),
            "write": In(1),  # write ``write_data`` in this cycle instead of reading
            "write_data": In(bits),
            "data": Out(bits),  # the word at the address of the cycle before
        })

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        if self._cells:
            m.d.comb += self.data.eq(self._cells(m, self._bits, self.address, self.write, self.write_data))
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
