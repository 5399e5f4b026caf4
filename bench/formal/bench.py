"""A block under free inputs, and what is claimed of it."""

import inspect
import sys
import types
from collections.abc import Iterator
from typing import Any

from amaranth import Const, Fragment, Module, Shape, Signal, Value
from amaranth.asserts import AnyConst
from amaranth.back import rtlil
from amaranth.hdl import Assert, Assume, Cover, MemoryInstance
from amaranth.lib.wiring import In

TOP = "top"


class Bench:
    """A module with the block under test in it; every input that nothing drives is free, a reset in any cycle included.

    ``only`` keeps one claim and leaves out the lemmas: a counterexample then breaks this claim itself.
    """

    def __init__(self, only: str | None = None) -> None:
        self.m = Module()
        self.claims: list[str] = []
        self._only = only
        self._inputs: list[Value] = []

    def free(self, shape: Any, name: str) -> Signal:
        """Any value in every cycle."""
        signal = Signal(shape, name=name)
        self._inputs.append(signal)
        return signal

    def constant(self, shape: Any) -> Any:
        """Any value, the same in all cycles."""
        return AnyConst(shape)

    def place(self, block: Any) -> dict[str, Any]:
        """Put ``block`` into the module, its inputs free; returns its signals by their names.

        Signals of a submodule have its name and a point before theirs; the second of two with the same name has " (2)"
        after it.  A memory has the name of its submodule.
        """
        for _, member, port in block.signature.flatten(block):
            value = Value.cast(port)
            if member.flow is In and isinstance(value, Signal):
                self._inputs.append(value)
        self.m.submodules.block = fragment = Fragment.get(block, None)
        found: dict[str, Any] = {}
        for name, each in _inner(fragment, ""):
            if found.setdefault(name, each) is not each:
                found[f"{name} (2)"] = each
        return found

    def look_up(self, memory: Any, address: Any) -> Signal:
        """The word of ``memory``, one of :meth:`place`, at ``address``."""
        place = Signal(range(memory._data.depth))
        word = Signal(Shape.cast(memory._data.shape))
        self.m.d.comb += place.eq(address)
        memory.read_port(domain="comb", addr=place, data=word, en=Const(1), transparent_for=())
        return word

    def claim(self, name: str, when: Any, holds: Any) -> None:
        """``holds`` in every cycle of ``when``, which has to occur."""
        self.claims.append(name)
        if self._only in (None, name):
            with self.m.If(when):
                self.m.d.comb += Assert(holds, name, src_loc_at=1)
            self.m.d.comb += Cover(when)

    def lemma(self, holds: Any) -> None:
        """An invariant of the block's registers: proven with the claims, and needed for the induction alone."""
        if self._only is None:
            self.m.d.comb += Assert(holds, src_loc_at=1)

    def assume(self, holds: Any) -> None:
        """What the block is promised by its neighbours."""
        self.m.d.comb += Assume(holds)

    def past(self, value: Any, cycles: int = 1) -> Any:
        """``value`` some cycles ago; zero before that, and after a reset."""
        for _ in range(cycles):
            earlier = Signal(Value.cast(value).shape())
            self.m.d.sync += earlier.eq(value)
            value = earlier
        return value

    def text(self) -> str:
        """RTLIL of the module."""
        return str(rtlil.convert(self.m, name=TOP, ports=self._inputs))


def _inner(fragment: Any, path: str) -> Iterator[tuple[str, Any]]:
    """Signals by their names, and memories by those of their parts."""
    for statements in fragment.statements.values():
        for statement in statements:
            yield from ((path + signal.name, signal) for signal in statement._lhs_signals())
    for part, name, _ in fragment.subfragments:
        if isinstance(part, MemoryInstance):
            yield path + name, part
        else:
            yield from _inner(part, f"{path}{name}.")


def mutated(subject: Any, old: str, new: str) -> Any:
    """``subject``, a class or a function, with ``old`` in its source replaced by ``new``.

    Raises ``ValueError`` unless the source has ``old`` once.
    """
    original = sys.modules[subject.__module__]
    source = inspect.getsource(subject)
    if source.count(old) != 1:
        raise ValueError(f"{subject.__name__}: one place with {old!r} is needed, found {source.count(old)}")
    module = types.ModuleType(subject.__module__)
    text = inspect.getsource(original).replace(source, source.replace(old, new))
    exec(compile(text, str(original.__file__), "exec"), module.__dict__)
    return getattr(module, subject.__name__)
