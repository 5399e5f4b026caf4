"""Memories with a write port and a read port."""

from collections.abc import Callable
from typing import Any

from amaranth import Module, Value
from amaranth.lib.memory import Memory


class Ram:
    """A memory of the module ``m``, whose ports are added by calls; none of them in a condition."""

    def __init__(self, m: Module, name: str, shape: Any, depth: int) -> None:
        self._m = m
        m.submodules[name] = self._memory = Memory(shape=shape, depth=depth, init=[])
        self._write: Any = None

    def write(self, enable: Any, address: Value, word: Any) -> None:
        """Store ``word`` at ``address`` at the end of every cycle in which ``enable`` is high."""
        self._write = port = self._unnamed(self._memory.write_port)
        self._m.d.comb += [
            port.en.eq(enable),
            port.addr.eq(address),
            port.data.eq(word),
        ]

    def read(self, address: Value, enable: Any = None, *, transparent: bool = False) -> Any:
        """The word at ``address``, a cycle later; if ``transparent``, the one that is written in the same cycle."""
        transparent_for = [self._write] if transparent else []
        port = self._unnamed(self._memory.read_port, transparent_for=transparent_for)
        self._m.d.comb += port.addr.eq(address)
        if enable is not None:
            self._m.d.comb += port.en.eq(enable)
        return port.data

    def look_up(self, address: Value) -> Any:
        """The word at ``address``, in the same cycle."""
        port = self._unnamed(self._memory.read_port, domain="comb")
        self._m.d.comb += port.addr.eq(address)
        return port.data

    @staticmethod
    def _unnamed(make: Callable[..., Any], **options: Any) -> Any:
        """A port whose wires have no names: synthesis then names cells after the registers at the port."""
        return make(**options)
