"""Drive one block in Amaranth's simulator: streams in with idle cycles, streams out with backpressure."""

from __future__ import annotations

import random
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from amaranth.lib import data
from amaranth.sim import Simulator

from tfra.sim.protocol import Pattern, bursts, flowing, random_stalls

PATTERNS = (flowing, random_stalls, bursts)


@dataclass
class Recording:
    """Transfers of a run: per port, the values and the cycle of each."""

    values: dict[str, list[Any]] = field(default_factory=dict)
    cycles: dict[str, list[int]] = field(default_factory=dict)


def plain(value: Any) -> Any:
    """A payload as nested lists, dicts and ints."""
    if isinstance(value, data.Const):
        layout = value.shape()
        if isinstance(layout, data.ArrayLayout):
            return [plain(value[i]) for i in range(layout.length)]
        return {name: plain(value[name]) for name, _ in layout}
    return int(value)


def run(
    dut: Any,
    inputs: Mapping[str, Sequence[Any]],
    outputs: Mapping[str, int],
    *,
    stall_in: Pattern = flowing,
    stall_out: Pattern = flowing,
    seed: int = 0,
    limit: int = 100_000,
) -> Recording:
    """Send ``inputs`` (port -> payloads), take ``outputs`` (port -> number of transfers), record them all.

    Ports are dotted attribute paths, with numbers for arrays (``o.0``).  Raises ``AssertionError`` when the block
    hangs, drops valid before ready, or changes a payload that was not taken.
    """
    record = Recording()
    clock = {"cycle": 0}
    simulator = Simulator(dut)
    simulator.add_clock(1e-6)
    missing = {"ports": len(outputs)}

    def port(path: str) -> Any:
        node = dut
        for part in path.split("."):
            node = node[int(part)] if part.isdigit() else getattr(node, part)
        return node

    async def cycles(ctx: Any) -> None:
        while True:
            await ctx.tick()
            clock["cycle"] += 1
            assert clock["cycle"] < limit, f"no end after {limit} cycles (seed {seed})"

    def sender(name: str, values: Sequence[Any]) -> Callable[[Any], Any]:
        stalls = stall_in(random.Random(f"{seed} {name}"))
        record.cycles[name], record.values[name] = [], list(values)

        async def process(ctx: Any) -> None:
            s = port(name)
            for value in values:
                while next(stalls):
                    await ctx.tick()
                ctx.set(s.payload, value)
                ctx.set(s.valid, 1)
                taken = False
                while not taken:
                    *_, taken = await ctx.tick().sample(s.ready)
                record.cycles[name].append(clock["cycle"])
                ctx.set(s.valid, 0)

        return process

    def receiver(name: str, number: int) -> Callable[[Any], Any]:
        stalls = stall_out(random.Random(f"{seed} {name} out"))
        record.cycles[name], record.values[name] = [], []

        async def process(ctx: Any) -> None:
            s = port(name)
            held = None
            while len(record.values[name]) < number:
                ready = not next(stalls)
                ctx.set(s.ready, ready)
                _, _, valid, payload = await ctx.tick().sample(s.valid, s.payload)
                now = plain(payload)
                assert held is None or (valid and held == now), f"{name}: changed before it was taken (seed {seed})"
                held = now if valid and not ready else None
                if valid and ready:
                    record.values[name].append(now)
                    record.cycles[name].append(clock["cycle"])
            ctx.set(s.ready, 0)
            missing["ports"] -= 1

        return process

    async def until_done(ctx: Any) -> None:
        while missing["ports"]:
            await ctx.tick()

    simulator.add_testbench(cycles, background=True)
    for name, values in inputs.items():
        simulator.add_testbench(sender(name, values), background=True)
    for name, number in outputs.items():
        simulator.add_testbench(receiver(name, number), background=True)
    simulator.add_testbench(until_done)
    simulator.run()
    return record
