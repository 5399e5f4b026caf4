"""Words through shift registers reach the core and come back."""

from typing import Any

from amaranth import Module, signed, unsigned
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from tfra.codegen.verilog.pins import Pins
from tfra.sim.harness import play


class Square(wiring.Component):
    """y = x * x + 1, and ready follows valid."""

    def __init__(self) -> None:
        super().__init__({"x": In(signed(5)), "y": Out(unsigned(10)), "valid": In(1), "ready": Out(1)})

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.d.comb += [self.y.eq(self.x * self.x + 1), self.ready.eq(self.valid)]
        return m


def test_words_through_pins() -> None:
    dut = Pins(Square())
    pins = dict.fromkeys(("shift", "x", "y", "valid", "ready"), 1)
    assert {name: len(getattr(dut, name)) for name in dut.signature.members} == pins
    words = (-16, -3, 0, 7, 15)
    cycles: list[dict[str, int]] = []
    for word in words:
        cycles += [{"shift": 1, "x": word >> bit & 1} for bit in range(5)]
        cycles += [{}, *({"shift": 1} for _ in range(10))]
    seen = play(dut, [*cycles, {"shift": 1, "valid": 1}, {}, {}], ("y", "ready"))
    for number, word in enumerate(words):
        start = 16 * number + 6
        assert sum(seen[start + bit]["y"] << bit for bit in range(10)) == word * word + 1
    assert [each["ready"] for each in seen[-2:]] == [0, 1]
