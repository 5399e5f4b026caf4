"""Drive one block in Amaranth's simulator: streams in with idle cycles, streams out with backpressure."""

import random
import sys
from collections.abc import Callable, Collection, Generator, Iterable, Iterator, Mapping, Sequence
from contextlib import nullcontext, suppress
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
    driver = Driver(dut, seed, limit, leave or {})
    for name, values in inputs.items():
        driver.add_source(name, values, flowing if name in steady else stall_in)
    for name, number in outputs.items():
        driver.add_sink(name, number, stall_out)
    driver.simulate(vcd)
    return driver.record


Port = Generator[None, Sequence[Any], None]
"""Drives one port: gets what its signals were at a clock edge and sets what they are until the next."""


class Driver:
    """Drives all ports of a block from one process, which is much faster than a testbench for each."""

    def __init__(self, dut: Any, seed: int, limit: int = sys.maxsize, leave: Mapping[str, Leave] | None = None) -> None:
        self.record = Recording()
        self.cycle = 0
        self._dut = dut
        self._seed = seed
        self._limit = limit
        self._leave = leave or {}
        self._watched = 0
        self._ports: list[tuple[Callable[[Any], Port], tuple[Value, ...]]] = []
        self._simulator = Simulator(dut)
        self._simulator.add_clock(1e-6)
        self._simulator.add_process(self._drive)

    def simulate(self, vcd: Path | None = None) -> None:
        """Run until every output has seen its transfers, and write all signals to ``vcd``."""
        with self._simulator.write_vcd(str(vcd)) if vcd else nullcontext():
            self._simulator.run()

    async def _drive(self, ctx: Any) -> None:
        """Drive the ports in their order, cycle by cycle."""
        ports = [(drives(ctx), len(read)) for drives, read in self._ports]
        for one, _ in ports:
            next(one, None)
        with ctx.critical():
            async for _, _, *values in ctx.tick().sample(*(signal for _, read in self._ports for signal in read)):
                self.cycle += 1
                assert self.cycle < self._limit, f"no end after {self._limit} cycles (seed {self._seed})"
                start = 0
                for one, count in ports:
                    with suppress(StopIteration):
                        one.send(values[start : start + count])
                    start += count
                if not self._watched:
                    return

    def add_watch(self, drives: Callable[[Any], Port], *read: Value) -> None:
        """Let ``drives`` look at the signals ``read`` in every cycle; the simulation does not end before it does."""

        def watch(ctx: Any) -> Port:
            yield from drives(ctx)
            self._watched -= 1

        self._watched += 1
        self._ports.append((watch, read))

    def add_source(
        self, name: str, values: Sequence[Any], pattern: Pattern, taken: Callable[[], None] | None = None
    ) -> None:
        """Offer ``values`` at the port ``name``; ``taken`` is called at every transfer."""
        stalls, s = pattern(random.Random(f"{self._seed} {name}")), port(self._dut, name)
        self.record.cycles[name] = []
        self.record.values[name] = list(values)

        def source(ctx: Any) -> Port:
            for number, value in enumerate(values):
                while name in self._leave and not self._leave[name](number, self.record, self.cycle):
                    yield
                while next(stalls):
                    yield
                ctx.set(s.payload, value)
                ctx.set(s.valid, 1)
                while not (yield)[0]:
                    pass
                self.record.cycles[name].append(self.cycle)
                if taken:
                    taken()
                ctx.set(s.valid, 0)

        self._ports.append((source, (s.ready,)))

    def add_sink(self, name: str, number: int, pattern: Pattern) -> None:
        """Take ``number`` transfers at the port ``name``."""
        stalls, s = pattern(random.Random(f"{self._seed} {name} out")), port(self._dut, name)
        values, cycles = self.record.values.setdefault(name, []), self.record.cycles.setdefault(name, [])
        never_waits = isinstance(s.ready, Const)

        def sink(ctx: Any) -> Port:
            offered = None
            while len(values) < number:
                ready = never_waits or not next(stalls)
                if not never_waits:
                    ctx.set(s.ready, ready)
                valid, payload = yield
                now = plain(payload) if valid else None
                assert offered is None or offered == now, f"{name}: changed before it was taken (seed {self._seed})"
                offered = None if ready else now
                if valid and ready:
                    values.append(now)
                    cycles.append(self.cycle)
            if not never_waits:
                ctx.set(s.ready, 0)

        self.add_watch(sink, s.valid, s.payload)
