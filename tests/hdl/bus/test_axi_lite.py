"""The bus alone, in front of a memory: order of the channels, answers, cycles."""

import random
from typing import Any

import pytest
from amaranth import Array, Cat, Module, ResetInserter, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, connect, flipped

from tests.hdl.bus.manager import OKAY, SLVERR, Manager, simulated
from tfra.hdl.bus.axi_lite import ANSWER, AxiLite, bus
from tfra.hdl.lib.pipeline import delayed

WORDS = 8


class Memory(wiring.Component):
    """Eight words behind the bus; an access of the last one is an error."""

    def __init__(self) -> None:
        super().__init__({"bus": In(bus(5))})

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.axi_lite = axi_lite = AxiLite(5)
        connect(m, flipped(self.bus), axi_lite.bus)
        port, words = axi_lite.port, Array(Signal(32, name=f"word_{n}") for n in range(WORDS))
        read, written = port.read_address[2:], port.write_address[2:]
        with m.If(port.write):
            for byte in range(4):
                with m.If(port.strobe[byte]):
                    m.d.sync += words[written].word_select(byte, 8).eq(port.data.word_select(byte, 8))
        for made, results in (
            (port.write, [(port.write_error, written == WORDS - 1)]),
            (port.read, [(port.read_error, read == WORDS - 1), (port.answer, words[read])]),
        ):
            now = delayed(m, made, ANSWER - 1, control=True)
            for result, value in results:
                late = delayed(m, value, ANSWER - 1)
                with m.If(now):
                    m.d.sync += result.eq(late)
        return m


@pytest.mark.parametrize("seed", range(2))
def test_words_come_back_whatever_stalls(seed: int) -> None:
    dut, rng, kept = Memory(), random.Random(seed), [0] * WORDS

    async def process(ctx: Any) -> None:
        manager = Manager(ctx, dut.bus, rng)
        for _ in range(150):
            number, word, strobe = rng.randrange(WORDS), rng.getrandbits(32), rng.getrandbits(4)
            response = SLVERR if number == WORDS - 1 else OKAY
            if rng.getrandbits(1):
                enabled = sum(255 << 8 * byte for byte in range(4) if strobe >> byte & 1)
                kept[number] = kept[number] & ~enabled | word & enabled
                assert await manager.write(4 * number + rng.randrange(4), word, strobe) == response
            else:
                assert await manager.read(4 * number) == (kept[number], response)

    simulated(dut, process, check=dut.bus)


@pytest.mark.parametrize("seed", range(2))
def test_reads_and_writes_at_the_same_time(seed: int) -> None:
    """Writes raise two words in turn, and reads never see one of them fall, or take it for the other."""
    dut = Memory()

    async def write(ctx: Any) -> None:
        manager = Manager(ctx, dut.bus, random.Random(f"{seed} w"))
        for value in range(1, 100):
            assert await manager.write(value % 2 * 4, value) == OKAY

    async def read(ctx: Any) -> None:
        manager = Manager(ctx, dut.bus, random.Random(f"{seed} r") if seed else None)
        before = [0, 0]
        for number in (each % 2 for each in range(100)):
            value, response = await manager.read(number * 4)
            assert response == OKAY
            assert value == 0 or value % 2 == number
            assert value >= before[number]
            before[number] = value
        assert min(before) > 50

    simulated(dut, write, read, check=dut.bus)


def test_cycles() -> None:
    """Latency and interval of an access without stalls, of either kind."""
    dut = Memory()

    async def process(ctx: Any) -> None:
        for requests, answer in (((dut.bus.awvalid, dut.bus.wvalid), "b"), ((dut.bus.arvalid,), "r")):
            valid, ready = (getattr(dut.bus, f"{answer}{name}") for name in ("valid", "ready"))
            ctx.set(ready, 1)
            for request in requests:
                ctx.set(request, 1)
            seen = []
            for _ in range(3 * AxiLite.interval):
                seen.append(ctx.get(valid))
                await ctx.tick()
            first = [cycle for cycle, is_valid in enumerate(seen) if is_valid]
            assert first == [AxiLite.latency + AxiLite.interval * n for n in range(len(first))]
            assert len(first) > 1
            for request in requests:
                ctx.set(request, 0)
            for _ in range(AxiLite.interval):
                await ctx.tick()
            ctx.set(ready, 0)

    simulated(dut, process)


def test_a_reset_forgets_requests() -> None:
    """An address that came before a reset writes nothing with the data that come after it."""
    dut = Memory()
    dut_in_reset = ResetInserter(reset := Signal())(dut)

    async def process(ctx: Any) -> None:
        manager = Manager(ctx, dut.bus)
        assert await manager.write(0, 5) == OKAY
        ctx.set(dut.bus.awaddr, 4)
        for address, clear, word in ((1, 0, 0), (0, 1, 0), (0, 0, 1)):
            ctx.set(Cat(dut.bus.awvalid, reset, dut.bus.wvalid), address | clear << 1 | word << 2)
            await ctx.tick()
        for _ in range(2 * AxiLite.interval):
            assert not ctx.get(dut.bus.bvalid)
            await ctx.tick()

    simulated(dut_in_reset, process)


class Late(wiring.Component):
    """A bus whose data follow a ready, which the check must notice."""

    def __init__(self) -> None:
        super().__init__({"bus": In(bus(5))})

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.memory = memory = Memory()
        connect(m, flipped(self.bus), memory.bus)
        m.d.comb += self.bus.rdata.eq(memory.bus.rdata ^ self.bus.rready)
        return m


def test_a_combinational_path_is_noticed() -> None:
    dut = Late()

    async def process(ctx: Any) -> None:
        await Manager(ctx, dut.bus).read(0)

    with pytest.raises(AssertionError, match="combinational path"):
        simulated(dut, process, check=dut.bus)
