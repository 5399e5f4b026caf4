"""A manager of AXI4-Lite with stalls of its own on every channel, and what a bus must keep to in every cycle."""

import random
from collections.abc import Awaitable, Callable, Sequence
from typing import Any

from amaranth.sim import Simulator

OKAY, SLVERR = 0, 2

Process = Callable[[Any], Awaitable[None]]

LONGEST = 5
"""Cycles of the longest stall."""


class Manager:
    """Accesses by a ``bus``, one after the other; stalls are random, or none without a generator ``rng``."""

    def __init__(self, ctx: Any, bus: Any, rng: random.Random | None = None) -> None:
        self._ctx, self._bus, self._rng = ctx, bus, rng

    async def write(self, address: int, word: int, strobe: int = 15) -> int:
        """Write, and return the response."""
        requests = {"aw": {"addr": address}, "w": {"data": word, "strb": strobe}}
        return (await self._access(requests, "b", ("resp",)))[0]

    async def read(self, address: int) -> tuple[int, int]:
        """Read, and return the word and the response."""
        word, response = await self._access({"ar": {"addr": address}}, "r", ("data", "resp"))
        return word, response

    def _stall(self) -> int:
        return self._rng.choice([0, 0, self._rng.randint(1, LONGEST)]) if self._rng else 0

    async def _access(self, requests: dict[str, dict[str, int]], answer: str, words: tuple[str, ...]) -> list[int]:
        ctx, bus = self._ctx, self._bus
        stalls, left = {channel: self._stall() for channel in (*requests, answer)}, set(requests)
        seen = [getattr(bus, f"{answer}{word}") for word in words]
        handshakes = [getattr(bus, f"{channel}ready") for channel in requests]
        while True:
            for channel, payload in requests.items():
                offered = channel in left and stalls[channel] <= 0
                ctx.set(getattr(bus, f"{channel}valid"), offered)
                for word, value in payload.items():
                    ctx.set(getattr(bus, f"{channel}{word}"), value if offered else ~value)
            ready = stalls[answer] <= 0
            ctx.set(getattr(bus, f"{answer}ready"), ready)
            _, _, valid, *sampled = await ctx.tick().sample(getattr(bus, f"{answer}valid"), *handshakes, *seen)
            for channel, taken in zip(requests, sampled, strict=False):
                left -= {channel} if taken and stalls[channel] <= 0 else set()
            if valid and ready:
                assert not left, "answered before it was asked"
                ctx.set(getattr(bus, f"{answer}ready"), 0)
                return [int(word) for word in sampled[len(requests) :]]
            stalls = {channel: stall - 1 for channel, stall in stalls.items()}


def rules(bus: Any) -> Process:
    """A process that checks: an answer stays until it is taken, and no output follows an input in the same cycle."""

    async def process(ctx: Any) -> None:
        answers = {"b": ("resp",), "r": ("data", "resp")}
        outputs = [bus.awready, bus.wready, bus.arready, bus.bvalid, bus.bresp, bus.rvalid, bus.rresp, bus.rdata]
        inputs = [bus.awvalid, bus.wvalid, bus.arvalid, bus.bready, bus.rready]
        offered: dict[str, list[int]] = {}
        while True:
            values, driven = [ctx.get(each) for each in outputs], [ctx.get(each) for each in inputs]
            for each, value in zip(inputs, driven, strict=True):
                ctx.set(each, 1 - value)
            assert [ctx.get(each) for each in outputs] == values, "combinational path"
            for each, value in zip(inputs, driven, strict=True):
                ctx.set(each, value)
            for channel, words in answers.items():
                now = [ctx.get(getattr(bus, f"{channel}{word}")) for word in words]
                valid = ctx.get(getattr(bus, f"{channel}valid"))
                assert channel not in offered or (valid and offered[channel] == now), f"{channel}: changed"
                offered.pop(channel, None)
                if valid and not ctx.get(getattr(bus, f"{channel}ready")):
                    offered[channel] = now
            await ctx.tick()

    return process


def simulated(dut: Any, *processes: Process, background: Sequence[Process] = (), check: Any = None) -> None:
    """Run ``processes`` until all of them have ended, under the :func:`rules` of the bus ``check`` if there is one."""
    simulator = Simulator(dut)
    simulator.add_clock(1e-6, if_exists=True)
    for process in processes:
        simulator.add_testbench(process)
    for process in (*background, *([] if check is None else [rules(check)])):
        simulator.add_testbench(process, background=True)
    simulator.run()
