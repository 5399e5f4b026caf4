"""A block with plain ports, which synthesis can take for a whole design."""

from typing import Any

from amaranth import Const, Module, Value
from amaranth.lib import wiring
from amaranth.lib.wiring import In


class Flat(wiring.Component):
    """``block`` with plain ports, a name for each member of its streams."""

    def __init__(self, block: wiring.Component) -> None:
        self._block, self._inner = block, dict[str, Value]()
        ports: dict[str, Any] = {}
        for path, port, value in block.signature.flatten(block):
            if not isinstance(value, Const):  # the ready of a stream that never waits
                name = "_".join(map(str, path))
                ports[name], self._inner[name] = port.flow(len(Value.cast(value))), Value.cast(value)
        super().__init__(ports)

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.block = self._block
        for name, port in self.signature.members.items():
            outer, inner = getattr(self, name), self._inner[name]
            m.d.comb += inner.eq(outer) if port.flow is In else outer.eq(inner)
        return m
