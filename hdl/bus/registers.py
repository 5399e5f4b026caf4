"""A bank of registers behind AXI4-Lite."""

from typing import Any

from amaranth import Module
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out, connect, flipped

from tfra.hdl.bus.axi_lite import AxiLite, bus
from tfra.hdl.bus.bank import Bank, hardware
from tfra.hdl.bus.map import RegisterMap


class Registers(wiring.Component):
    """The registers of a map on an AXI4-Lite bus.

    Arguments:
        registers: the map.
    """

    def __init__(self, registers: RegisterMap) -> None:
        self._map = registers
        super().__init__(
            {
                "bus": In(bus(registers.address_bits)),
                "hardware": Out(hardware(registers)),  # by register, the ports of its fields
                "interrupt": Out(1),  # level, active high
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.axi_lite = axi_lite = AxiLite(self._map.address_bits)
        m.submodules.bank = bank = Bank(self._map)
        connect(m, flipped(self.bus), axi_lite.bus)
        connect(m, axi_lite.port, bank.port)
        connect(m, bank.hardware, flipped(self.hardware))
        m.d.comb += self.interrupt.eq(bank.interrupt)
        return m
