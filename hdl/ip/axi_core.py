"""A core with everything around it."""

from typing import Any

from amaranth import Module, ResetInserter
from amaranth.lib import wiring
from amaranth.lib.wiring import connect, flipped

from tfra.hdl.ip.wrapper import Wrapper


class AxiCore(wiring.Component):
    """``core`` inside of its ``wrapper``.

    Members: those of the wrapper that are not streams of the core.
    """

    def __init__(self, wrapper: Wrapper, core: Any) -> None:
        self._wrapper, self._core = wrapper, core
        names = ("axi", "frames", "results", "interrupt")
        super().__init__({name: wrapper.signature.members[name] for name in names})

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.wrapper = wrapper = self._wrapper
        m.submodules.core = ResetInserter(wrapper.core_reset)(self._core)
        for name, member in self.signature.members.items():
            if member.is_signature:
                connect(m, getattr(wrapper, name), flipped(getattr(self, name)))
        m.d.comb += self.interrupt.eq(wrapper.interrupt)
        for name in self._core.signature.members:
            if hasattr(wrapper, name):
                connect(m, getattr(wrapper, name), getattr(self._core, name))
        return m
