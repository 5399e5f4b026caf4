"""Drive one block in Amaranth's simulator: streams in with idle cycles, streams out with backpressure."""

from __future__ import annotations

import random
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from amaranth import Const, Value
from amaranth.lib import data
from amaranth.sim import Simulator

from tfra.sim.protocol import Pattern, bursts, flowing, random_stalls

PATTERNS = (flowing, random_stalls, bursts)

Leave = Callable[[int, "Recording", int], bool]
"""For ports that must never wait: whether a transfer of a given number may be offered, from the record up to a given
cycle."""


def apart(pattern: Pattern, cycles: int) -> Pattern:
    """``pattern`` with a least number of cycles between transfers: beats of a quad."""

    def spaced(rng: random.Random) -> Iterator[bool]:
        for stall in pattern(rng):
            yield stall
            if not stall:
                yield from [True] * (cycles - 1)

    return spaced


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


def port(dut: Any, path: str) -> Any:
    """The object at a dotted path of attributes, with numbers for arrays."""
    node = dut
    for part in path.split("."):
        node = node[int(part)] if part.isdigit() else getattr(node, part)
    return node


def play(
    dut: Any, cycles: Iterable[Mapping[str, Any]], watched: Sequence[str], record: list[dict[str, Any]] | None = None
) -> list[dict[str, Any]]:
    """Set inputs cycle by cycle and return what the ``watched`` ports show in each; those not set are zero.

    ``cycles`` may be a generator that reads the ``record`` of the cycles before.
    """
    record = [] if record is None else record
    simulator = Simulator(dut)
    simulator.add_clock(1e-6)

    async def process(ctx: Any) -> None:
        last: set[str] = set()
        for inputs in cycles:
            for name in last - inputs.keys():
                ctx.set(Value.cast(port(dut, name)), 0)
            for name, value in inputs.items():
                ctx.set(port(dut, name), value)
            last = set(inputs)
            record.append({name: plain(ctx.get(port(dut, name))) for name in watched})
            await ctx.tick()

    simulator.add_testbench(process)
    simulator.run()
    return record


def run(
    dut: Any,
    inputs: Mapping[str, Sequence[Any]],
    outputs: Mapping[str, int],
    *,
    stall_in: Pattern = flowing,
    stall_out: Pattern = flowing,
    steady: Collection[str] = (),
    leave: Mapping[str, Leave] | None = None,
    seed: int = 0,
    limit: int = 100_000,
    vcd: Path | None = None,
) -> Recording:
    """Send ``inputs`` (port -> payloads), take ``outputs`` (port -> number of transfers), record them all.

    Ports are dotted attribute paths, with numbers for arrays (``o.0``); ``steady`` ones never stall, those in ``leave``
    call its function first.  ``vcd`` is a file to write with every signal.  A stream without ready is recorded as it
    comes.  Raises ``AssertionError`` when the block hangs, drops valid before ready, or changes a payload that was not
    taken.
    """
    bench = _Bench(dut, Recording(), leave or {}, seed)
    simulator = Simulator(dut)
    simulator.add_clock(1e-6)
    simulator.add_testbench(bench.count(limit), background=True)
    for name, values in inputs.items():
        simulator.add_testbench(bench.send(name, values, flowing if name in steady else stall_in), background=True)
    for name, number in outputs.items():
        simulator.add_testbench(bench.take(name, number, stall_out), background=True)
    simulator.add_testbench(bench.until_done)
    with simulator.write_vcd(str(vcd)) if vcd else nullcontext():
        simulator.run()
    return bench.record


Process = Callable[[Any], Any]


@dataclass
class _Bench:
    """The processes that drive a block, and their record."""

    dut: Any
    record: Recording
    leave: Mapping[str, Leave]
    seed: int
    cycle: int = 0
    missing: int = 0
    """Output ports that have not seen all their transfers."""

    def count(self, limit: int) -> Process:
        """Count cycles up to ``limit``."""

        async def process(ctx: Any) -> None:
            while True:
                await ctx.tick()
                self.cycle += 1
                assert self.cycle < limit, f"no end after {limit} cycles (seed {self.seed})"

        return process

    def send(self, name: str, values: Sequence[Any], pattern: Pattern) -> Process:
        """Offer ``values`` at the port ``name``."""
        stalls, s = pattern(random.Random(f"{self.seed} {name}")), port(self.dut, name)
        self.record.cycles[name], self.record.values[name] = [], list(values)

        async def process(ctx: Any) -> None:
            for number, value in enumerate(values):
                while name in self.leave and not self.leave[name](number, self.record, self.cycle):
                    await ctx.tick()
                while next(stalls):
                    await ctx.tick()
                ctx.set(s.payload, value)
                ctx.set(s.valid, 1)
                taken = False
                while not taken:
                    *_, taken = await ctx.tick().sample(s.ready)
                self.record.cycles[name].append(self.cycle)
                ctx.set(s.valid, 0)

        return process

    def take(self, name: str, number: int, pattern: Pattern) -> Process:
        """Take ``number`` transfers at the port ``name``."""
        stalls, s = pattern(random.Random(f"{self.seed} {name} out")), port(self.dut, name)
        values, cycles = self.record.values.setdefault(name, []), self.record.cycles.setdefault(name, [])
        self.missing += 1

        async def process(ctx: Any) -> None:
            held, never_waits = None, isinstance(s.ready, Const)
            while len(values) < number:
                ready = never_waits or not next(stalls)
                if not never_waits:
                    ctx.set(s.ready, ready)
                _, _, valid, payload = await ctx.tick().sample(s.valid, s.payload)
                now = plain(payload)
                kept = held is None or (valid and held == now)
                assert kept, f"{name}: changed before it was taken (seed {self.seed})"
                held = now if valid and not ready else None
                if valid and ready:
                    values.append(now)
                    cycles.append(self.cycle)
            if not never_waits:
                ctx.set(s.ready, 0)
            self.missing -= 1

        return process

    async def until_done(self, ctx: Any) -> None:
        """End when every output port has seen its transfers."""
        while self.missing:
            await ctx.tick()
