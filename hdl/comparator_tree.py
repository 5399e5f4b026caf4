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
        level: list[tuple[Value, Value]] = [(key, Cat()) for key in self.keys]
        while len(level) > 1:
            pairs = zip(level[::2], [*level[1::2], None], strict=False)
            level = [self._node(m, left, right) for left, right in pairs]
        m.d.comb += [self.least.eq(level[0][0]), self.place.eq(level[0][1])]
        return m

    def _node(self, m: Module, left: tuple[Value, Value], right: tuple[Value, Value] | None) -> tuple[Value, Value]:
        """Register of the smaller of two; the left one, of lower number, wins a tie."""
        key = Signal(self._bits, reset_less=True)
        place = Signal(len(left[1]) + 1, reset_less=True)
        if right is None:
            m.d.sync += [key.eq(left[0]), place.eq(left[1])]
            return key, place
        swap = Signal()
        m.d.comb += swap.eq(right[0] < left[0])
        m.d.sync += [
            key.eq(Mux(swap, right[0], left[0])),
            place.eq(Cat(Mux(swap, right[1], left[1])[: len(left[1])], swap)),
        ]
        return key, place
