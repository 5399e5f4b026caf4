"""The sequencer goes through loops, calls and pointers, with any stalls, in the cycles that the assembler counts."""

import random
from itertools import pairwise

from amaranth import Value

from tests.hdl.bus.manager import simulated
from tfra.hdl.serial.isa import R0, Dest, imm, mem
from tfra.hdl.serial.program.assembler import Assembler
from tfra.hdl.serial.sequencer import Sequencer


def example():
    """Three nested loops, calls from two places and a pointer that moves, for ever; cycles and addresses of a turn."""
    a = Assembler()

    def body():
        a.move(R0, imm(7))

    with a.loop(3):
        a.advance(1, 5)
        with a.loop(2), a.loop(4):
            a.move(Dest.NONE, mem(3, 1))
        a.call("seven", body)
    a.call("seven", body)
    a.advance(1, -15)
    a.jump(0)
    cycles = a.cycles
    a.link()
    return a.program, cycles, [3 + 5 * turn for turn in (1, 2, 3) for _ in range(8)]


def test_addresses_and_cycles():
    program, cycles, addresses = example()
    dut, rng = Sequencer(program), random.Random(1)
    marked = {i.word for i in program if i.source == mem(0).source and i.immediate == 3}
    ends = {i.word for i in program if i.immediate == -15}

    async def bench(ctx):
        seen, executed, turns = [], 0, []
        while len(turns) < 3:
            ctx.set(dut.advance, rng.random() < 0.7)
            _, _, valid, advance, word, address = await ctx.tick().sample(
                dut.valid, dut.advance, Value.cast(dut.instruction), dut.address
            )
            if valid and advance:
                executed += 1
                if word in marked:
                    seen.append(address)
                if word in ends:
                    turns.append(executed)
        assert seen == addresses * 3
        assert {later - earlier for earlier, later in pairwise(turns)} == {cycles}

    simulated(dut, bench)
