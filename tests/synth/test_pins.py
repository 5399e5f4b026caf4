"""Words through shift registers reach the core and come back."""

from typing import Any

from amaranth import Module, signed, unsigned
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out
from amaranth.sim import Simulator

from tfra.synth.pins import Pins


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

    async def bench(ctx: Any) -> None:
        for value in (-16, -3, 0, 7, 15):
            ctx.set(dut.shift, 1)
            for bit in range(5):
                ctx.set(dut.x, value >> bit & 1)
                await ctx.tick()
            ctx.set(dut.shift, 0)
            await ctx.tick()
            ctx.set(dut.shift, 1)
            word = 0
            for bit in range(10):
                word |= ctx.get(dut.y) << bit
                await ctx.tick()
            assert word == value * value + 1
        ctx.set(dut.valid, 1)
        await ctx.tick()
        ctx.set(dut.shift, 0)
        await ctx.tick()
        assert ctx.get(dut.ready) == 1

    simulator = Simulator(dut)
    simulator.add_clock(1e-6)
    simulator.add_testbench(bench)
    simulator.run()
