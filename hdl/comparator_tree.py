"""A pipelined tree that finds the smallest of many keys and where it stands."""

from __future__ import annotations

from typing import Any

from amaranth import Cat, Module, Mux, Signal, Value, unsigned
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.arithmetic import count


class ComparatorTree(wiring.Component):
    """``least = min(keys)`` and ``place``, the first that holds it; a new set every cycle, nothing stalls.

        keys[0] --+
                  +-- reg --+
        keys[1] --+         +-- reg -- ... -- least, place
        keys[2] ----- reg --+

    A key that must not win gets a one as its highest bit.  Resources: ``ways - 1`` comparators and multiplexers of
    ``bits``, one register behind each.

    Arguments:
        ways: number of keys.
        bits: width of a key, unsigned.

    Members: ``keys``: ``ways`` keys in; ``least``, ``place``: the winner's key and number, ``latency`` cycles later.
    """

    def __init__(self, ways: int, bits: int) -> None:
        self._ways, self._bits = ways, bits
        super().__init__(
            {
                "keys": In(unsigned(bits)).array(ways),
                "least": Out(unsigned(bits)),
                "place": Out(count(ways - 1)),
            }
        )

    @property
    def latency(self) -> int:
        """Cycles from keys to winner: one per level, ``ceil(log2(ways))``."""
        return (self._ways - 1).bit_length()

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        level: list[tuple[Value, list[Value]]] = [(key, []) for key in self.keys]
        while len(level) > 1:
            pairs = zip(level[::2], [*level[1::2], None], strict=False)
            level = [self._node(m, left, right) for left, right in pairs]
        m.d.comb += [self.least.eq(level[0][0]), self.place.eq(Cat(level[0][1]) if level[0][1] else 0)]
        return m

    def _node(
        self, m: Module, left: tuple[Value, list[Value]], right: tuple[Value, list[Value]] | None
    ) -> tuple[Value, list[Value]]:
        """Register of the smaller of two; the left one, of lower number, wins a tie.  A place is a list of bits."""
        key = Signal(self._bits, reset_less=True)
        place: list[Value] = [Signal(name=f"place{bit}", reset_less=True) for bit in range(len(left[1]) + 1)]
        if right is None:
            m.d.sync += [key.eq(left[0]), *(bit.eq(old) for bit, old in zip(place, [*left[1], 0], strict=True))]
            return key, place
        swap = Signal()
        m.d.comb += swap.eq(right[0] < left[0])
        m.d.sync += [key.eq(Mux(swap, right[0], left[0])), place[-1].eq(swap)]
        m.d.sync += [bit.eq(Mux(swap, b, a)) for bit, a, b in zip(place, left[1], right[1], strict=False)]
        return key, place
