"""Shift registers between a core's ports and one pin each: it fits small packages, and its paths end at registers."""

from collections.abc import Sequence
from typing import Any

from amaranth import Cat, ClockDomain, ClockSignal, Instance, Module, ResetSignal, Shape, Signal, Value
from amaranth.lib import wiring
from amaranth.lib.wiring import In

from tfra.codegen.sidecar.schema import Port
from tfra.codegen.verilog.emit import FLOWS, plain_verilog, to_rtlil

_DOMAIN = ("aclk", "aresetn")
"""Ports of a wrapper that are no words: its clock and its reset, which become ``clk`` and ``rst`` like a core's."""
_CLOCKED = {"clk": ClockSignal, "rst": ResetSignal}
"""Those of a core."""


class Pins(wiring.Component):
    """``core`` with a shift register and a one-bit pin for every port; for place and route only.

    While ``shift`` is high, words are shifted in and out, lowest bit first; outputs are captured while it is low.
    So only the core itself is timed.  Resources: a flip-flop for every bit of the ports.
    """

    def __init__(self, core: wiring.Component) -> None:
        self._core, self._domain = core, "pins" if "aclk" in core.signature.members else "sync"
        self._ports = {name: port for name, port in core.signature.members.items() if name not in _DOMAIN}
        clock = {"clk": In(1), "rst": In(1)} if self._domain == "pins" else {}
        super().__init__({"shift": In(1), **clock, **{name: port.flow(1) for name, port in self._ports.items()}})

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.top = self._core
        if self._domain == "pins":
            m.domains.pins = pins = ClockDomain(reset_less=True)
            m.d.comb += [pins.clk.eq(self.clk), self._core.aclk.eq(self.clk), self._core.aresetn.eq(~self.rst)]
        for name, port in self._ports.items():
            pin, word = getattr(self, name), Value.cast(getattr(self._core, name))
            register = Signal(Shape.cast(port.shape).width, name=f"{name}_register", reset_less=True)
            shifted = Cat(register[1:], pin if port.flow is In else 0)
            if port.flow is In:
                m.d.comb += word.eq(register)
                with m.If(self.shift):
                    m.d[self._domain] += register.eq(shifted)
            else:
                m.d.comb += pin.eq(register[0])
                m.d[self._domain] += register.eq(word)
                with m.If(self.shift):
                    m.d[self._domain] += register.eq(shifted)
        return m


class _Foreign(wiring.Component):
    """A module ``name`` from elsewhere with ``ports``; clock and reset of a core are those of the design."""

    def __init__(self, name: str, ports: Sequence[Port]) -> None:
        self._name, self._ports = name, ports
        super().__init__({port.name: FLOWS[port.direction](port.bits) for port in ports if port.name not in _CLOCKED})

    def elaborate(self, platform: Any) -> Instance:
        signals = {name: signal() for name, signal in _CLOCKED.items()} | vars(self)
        return Instance(self._name, **{f"{port.direction[0]}_{port.name}": signals[port.name] for port in self._ports})


def pins_verilog(name: str, ports: Sequence[Port]) -> str:
    """Verilog of the module ``NAME_pins``: the module ``name`` of another file, which has ``ports``, behind pins."""
    return plain_verilog(to_rtlil(Pins(_Foreign(name, ports)), f"{name}_pins"), f"{name}_pins")
