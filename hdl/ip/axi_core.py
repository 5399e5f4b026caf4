"""A core with its wrapper, for simulation in Python."""

from __future__ import annotations

from typing import Any

from amaranth import Module, ResetInserter
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out, connect, flipped

from tfra.hdl.bus.map import RegisterMap
from tfra.hdl.interface.microarchitecture import Microarchitecture
from tfra.hdl.ip.wrapper import Wrapper

PORTS = ("bus", "interrupt", "frames", "results")


class AxiCore(wiring.Component):
    """:class:`Wrapper` and the core that it is made for.

    Members: as those of ``Wrapper``, without the ones to the core.  Raises as ``Wrapper``, and as ``core.build``.
    """

    def __init__(self, core: Microarchitecture, registers: RegisterMap) -> None:
        self._wrapper, self._core = Wrapper(core, registers), core.build()
        members = self._wrapper.signature.members
        super().__init__({name: members[name] for name in PORTS})

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.wrapper = wrapper = self._wrapper
        m.submodules.core = core = ResetInserter(wrapper.reset)(self._core)
        for name in PORTS:
            own, inner = getattr(self, name), getattr(wrapper, name)
            if name == "interrupt":
                m.d.comb += own.eq(inner)
            else:
                connect(m, *((flipped(own), inner) if name != "results" else (inner, flipped(own))))
        connect(m, wrapper.taxel, core.taxel)
        connect(m, core.result, wrapper.result)
        if "load" in wrapper.signature.members:
            connect(m, wrapper.load, core.load)
        return m
