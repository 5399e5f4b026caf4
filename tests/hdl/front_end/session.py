"""Drive a front end: settings, tables, frames and resets in order; what came out, frame by frame."""

import random
from collections import Counter
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np
from amaranth import ResetInserter, Signal
from amaranth.sim import Simulator

from tfra.hdl.front_end.calibrate import GAINS, OFFSETS, REPAIRS
from tfra.hdl.front_end.ports import EVENTS
from tfra.hdl.front_end.unit import FrontEnd
from tfra.model.fixed.front_end import Settings, Tables
from tfra.sim.harness import flowing, plain
from tfra.sim.protocol import Pattern

LIMIT = 60_000


@dataclass
class Frame:
    """A frame on its way in, whole or not."""

    words: list[int]
    user: int = 0
    ends: bool = True


@dataclass
class Seen:
    """What came out: per good frame, its facts and codes; codes of bad ones; events; faulty taxels; cycles."""

    facts: list[dict[str, Any]] = field(default_factory=list)
    codes: list[list[int]] = field(default_factory=list)
    bad: list[list[int]] = field(default_factory=list)
    events: Counter[str] = field(default_factory=Counter)
    faulty: list[dict[str, int]] = field(default_factory=list)
    values: list[int] = field(default_factory=list)
    taken: list[int] = field(default_factory=list)
    """Cycle of each taxel's transfer."""
    given: list[int] = field(default_factory=list)
    """Cycle of each code's transfer."""


class Session:
    """Steps to be played in order; each method adds one."""

    def __init__(self, unit: FrontEnd, *, stall_in: Pattern = flowing, stall_out: Pattern = flowing, seed: int = 0):
        self.unit, self._reset = unit, Signal()
        self.seen, self.cycle, self._steps = Seen(), 0, []
        self._facts: list[dict[str, Any]] = []
        self._codes: list[int] = []
        self._in, self._out = stall_in(random.Random(f"{seed} in")), stall_out(random.Random(f"{seed} out"))

    def set(self, settings: Settings, tables: Tables | None = None, **more: int) -> None:
        """Write registers, while the unit does not run; run again."""

        async def step(ctx: Any) -> None:
            own = self.unit.settings
            ctx.set(own.run, 0)
            await self._drained(ctx)
            repairs = len(tables.repairs) if tables else 0
            for name, value in (asdict(settings) | {"repair_words": repairs} | more).items():
                ctx.set(getattr(own, name), int(value))
            kinds = ((OFFSETS, tables.offsets), (GAINS, tables.gains), (REPAIRS, tables.repairs)) if tables else ()
            for kind, words in kinds:
                await self._write(ctx, kind, 0, words)
            ctx.set(own.run, 1)

        self._steps.append(step)

    def change(self, cycles: int, **settings: int) -> None:
        """Write settings after so many ``cycles``, whatever the unit does then."""

        async def step(ctx: Any) -> None:
            await ctx.tick().repeat(cycles)
            for name, value in settings.items():
                ctx.set(getattr(self.unit.settings, name), value)

        self._steps.append(step)

    async def _write(self, ctx: Any, kind: int, place: int, words: Any) -> None:
        bus = self.unit.tables
        ctx.set(bus.kind, kind)
        ctx.set(bus.index, place)
        for index, word in enumerate(words, place):
            ctx.set(bus.index, index)
            ctx.set(bus.data, int(word) & 0xFFFFFFFF)
            ctx.set(bus.data_written, 1)
            await ctx.tick()
            ctx.set(bus.data_written, 0)

    def read(self, kind: int, place: int) -> None:
        """Read a word of a table into ``seen.values``."""

        async def step(ctx: Any) -> None:
            await self._drained(ctx)
            await self._write(ctx, kind, place, ())
            await ctx.tick().repeat(2)
            self.seen.values.append(ctx.get(self.unit.tables.value))

        self._steps.append(step)

    def frames(self, *frames: Frame) -> None:
        """Send them."""

        async def step(ctx: Any) -> None:
            for frame in frames:
                for number, word in enumerate(frame.words):
                    while next(self._in):
                        await ctx.tick()
                    last = frame.ends and number == len(frame.words) - 1
                    ctx.set(self.unit.i.payload, {"word": int(word), "user": frame.user, "last": last})
                    ctx.set(self.unit.i.valid, 1)
                    taken = False
                    while not taken:
                        *_, taken = await ctx.tick().sample(self.unit.i.ready)
                    self.seen.taken.append(self.cycle)
                    ctx.set(self.unit.i.valid, 0)

        self._steps.append(step)

    def pulse(self, name: str) -> None:
        """``tare`` or ``simulate``."""

        async def step(ctx: Any) -> None:
            ctx.set(getattr(self.unit, name), 1)
            await ctx.tick()
            ctx.set(getattr(self.unit, name), 0)
            await ctx.tick().repeat(3)

        self._steps.append(step)

    def reset(self, *, skip: bool, drained: bool = True) -> None:
        """A soft reset, which cuts a frame if it is to ``skip`` its rest."""

        async def step(ctx: Any) -> None:
            if drained:
                await self._drained(ctx)
            ctx.set(self._reset, 1)
            ctx.set(self.unit.skip, skip)
            await ctx.tick().repeat(2)
            ctx.set(self._reset, 0)
            ctx.set(self.unit.skip, 0)

        self._steps.append(step)

    def check(self, name: str, value: int) -> None:
        """A port has a value, once all frames are out."""

        async def step(ctx: Any) -> None:
            await self._drained(ctx)
            assert ctx.get(getattr(self.unit, name)) == value, name

        self._steps.append(step)

    async def _drained(self, ctx: Any) -> None:
        await ctx.tick()
        while ctx.get(self.unit.busy):
            await ctx.tick()
        await ctx.tick().repeat(10)  # faults of a frame that is no more than a part of a mean

    def play(self) -> Seen:
        """Play all steps until the unit is empty."""
        simulator = Simulator(ResetInserter(self._reset)(self.unit))
        simulator.add_clock(1e-6)

        async def main(ctx: Any) -> None:
            for step in self._steps:
                await step(ctx)
            await self._drained(ctx)

        simulator.add_testbench(self._watch, background=True)  # first: it counts cycles for the others
        simulator.add_testbench(main)
        simulator.add_testbench(self._take, background=True)
        simulator.run()
        taxels = len(self._codes) // max(1, len(self._facts))
        for number, facts in enumerate(self._facts):
            codes = self._codes[number * taxels : (number + 1) * taxels]
            if facts.pop("bad"):
                self.seen.bad.append(codes)
            else:
                self.seen.facts.append(facts)
                self.seen.codes.append(codes)
        return self.seen

    async def _watch(self, ctx: Any) -> None:
        unit, names = self.unit, list(EVENTS.members)
        while True:
            ports = [getattr(unit.events, name) for name in names]
            _, _, store, faulty, *events = await ctx.tick().sample(unit.faulty_store, unit.faulty, *ports)
            self.cycle += 1
            assert self.cycle < LIMIT, "no end"
            self.seen.events.update(name for name, event in zip(names, events, strict=False) if event)
            if store:
                self.seen.faulty.append(plain(faulty))

    async def _take(self, ctx: Any) -> None:
        unit, offered, ready, facts_valid = self.unit, None, [True, True], 0
        while True:
            facts_wait = facts_valid and not ready[0]
            ready = [not next(self._out), not next(self._out) and not facts_wait]
            ctx.set(unit.facts.ready, ready[0])
            ctx.set(unit.codes.ready, ready[1])
            _, _, facts_valid, facts, code_valid, code = await ctx.tick().sample(
                unit.facts.valid, unit.facts.payload, unit.codes.valid, unit.codes.payload
            )
            assert offered is None or (code_valid and code == offered), "changed before it was taken"
            offered = code if code_valid and not ready[1] else None
            if facts_valid and ready[0]:
                self._facts.append(plain(facts))
            if code_valid and ready[1]:
                self._codes.append(int(code))
                self.seen.given.append(self.cycle)


def words(values: Any) -> list[int]:
    """Signed numbers as words of 16 bits."""
    return (np.asarray(values).ravel() & 0xFFFF).tolist()
