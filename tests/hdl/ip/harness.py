"""A core behind AXI in Amaranth's simulator: a simple core, and what is around the whole."""

import random
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

from amaranth import Module, ResetInserter, Signal, signed
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out, connect

from tests.hdl.bus.manager import Manager, Process, simulated
from tfra.codegen.registers.source import parameters, register_map
from tfra.hdl.interface import ports
from tfra.hdl.ip.wrapper import Wrapper
from tfra.hdl.lib.pipeline import wrapping_counter
from tfra.model.fixed.design import Design

STATUS = 0x15


class EchoCore(wiring.Component):
    """Answers a frame by 0, words that are its first taxel plus their numbers, and ``STATUS`` at the end.

    With ``words``, that many have to be loaded after a reset, and the sum of them is added, too.
    """

    def __init__(self, design: Design, words: int = 0) -> None:
        self._design, self._words = design, words
        streams = {"taxel": In(stream.Signature(ports.taxel(design)))}
        streams |= {"result": Out(stream.Signature(ports.result(design)))}
        if words:
            streams["load"] = In(stream.Signature(signed(design.coefficient_word)))
        super().__init__(streams)

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        total, loading = Signal(signed(32)), Signal(init=self._words > 0)
        if self._words:
            count = Signal(range(self._words + 1))
            m.d.comb += self.load.ready.eq(loading)
            with m.If(loading & self.load.valid):
                m.d.sync += [count.eq(count + 1), total.eq(total + self.load.payload)]
                m.d.sync += loading.eq(count != self._words - 1)
        answering, first = Signal(), Signal.like(self.taxel.payload)
        taken, given = (port.valid & port.ready for port in (self.taxel, self.result))
        taxel, last = wrapping_counter(m, taken, self._design.sensor.taxels, "taxel")
        word, ends = wrapping_counter(m, given, self._design.frame_words, "word")
        m.d.comb += [
            self.taxel.ready.eq(~answering & ~loading),
            self.result.valid.eq(answering),
            self.result.payload.data.eq(first + word + total),
            self.result.payload.last.eq(ends),
        ]
        with m.If(word == 0):
            m.d.comb += self.result.payload.data.eq(0)
        with m.If(ends):
            m.d.comb += self.result.payload.data.eq(STATUS)
        with m.If(taken):
            m.d.sync += answering.eq(last)
            with m.If(taxel == 0):
                m.d.sync += first.eq(self.taxel.payload)
        with m.If(given & ends):
            m.d.sync += answering.eq(0)
        return m


@dataclass
class Bench:
    """``design`` behind AXI: what came back as ``(tuser, words)``, and the cycles of transfers at both streams.

    Its core is simple if no other ``core`` is given, and takes ``words`` coefficients.
    """

    design: Design
    words: int = 0
    core: Any = None
    back: list[tuple[int, list[int]]] = field(default_factory=list)
    taken: list[int] = field(default_factory=list)
    given: list[int] = field(default_factory=list)
    partial: list[int] = field(default_factory=list)
    open: bool = True
    cycle: int = 0

    def __post_init__(self) -> None:
        self.map = register_map(parameters(self.design))
        self.wrapper = Wrapper(self.design, self.map, loaded=self.words > 0)
        core, m = self.core or EchoCore(self.design, self.words), Module()
        m.submodules.wrapper = self.wrapper
        m.submodules.core = ResetInserter(self.wrapper.core_reset)(core)
        for name in core.signature.members:
            connect(m, getattr(self.wrapper, name), getattr(core, name))
        self._module = m

    async def write(self, ctx: Any, name: str, **fields: int) -> None:
        """Write a register: the given fields, others as after a reset."""
        register = self.map[name]
        word = 0
        for each in register.fields:
            word |= fields.get(each.name, each.reset) << each.low
        assert await Manager(ctx, self.wrapper.axi).write(register.address, word) == 0

    async def read(self, ctx: Any, name: str) -> dict[str, int]:
        """Fields of a register."""
        word, response = await Manager(ctx, self.wrapper.axi).read(self.map[name].address)
        assert response == 0
        return {each.name: (word >> each.low) & ((1 << each.bits) - 1) for each in self.map[name].fields}

    async def send(self, ctx: Any, beats: Iterable[int], user: int = 0, last: bool = True, stalls: Any = None) -> None:
        """A frame, or a part of one if not ``last``."""
        port, every = self.wrapper.frames, list(beats)
        for number, beat in enumerate(every):
            while stalls and stalls.random() < 0.3:
                await ctx.tick()
            ctx.set(port.valid, 1)
            ctx.set(port.payload.words.as_value(), beat)
            ctx.set(port.payload.user, user)
            ctx.set(port.payload.last, last and number == len(every) - 1)
            await ctx.tick().until(port.ready)
            ctx.set(port.valid, 0)

    def sink(self, rng: random.Random | None = None) -> Process:
        """Takes output frames while ``open``, and counts cycles."""

        async def process(ctx: Any) -> None:
            port, frames = self.wrapper.results, self.wrapper.frames
            while True:
                ready = self.open and not (rng and rng.random() < 0.4)
                ctx.set(port.ready, ready)
                seen = (port.valid, port.payload, frames.valid & frames.ready)
                _, _, valid, payload, taken = await ctx.tick().sample(*seen)
                self.cycle += 1
                self.taken += [self.cycle] * taken
                if valid and ready:
                    self.given.append(self.cycle)
                    self.partial.append(payload.data)
                    if payload.last:
                        self.back.append((payload.user, self.partial))
                        self.partial = []

        return process

    async def settle(self, ctx: Any, cycles: int = 100) -> None:
        """Long enough for a frame to pass, by default."""
        await ctx.tick().repeat(cycles)

    def run(
        self, *processes: Process, rng: random.Random | None = None, check: bool = False, watch: Iterable[Process] = ()
    ) -> None:
        """Run ``processes``, under the rules of the bus if ``check``, which take as long as all the rest."""
        background, axi = [self.sink(rng), *watch], self.wrapper.axi if check else None
        simulated(self._module, *processes, background=background, check=axi)

    def answer(
        self, first: int, sequence: int, user: int = 0, flags: int = 0, *, forces: bool = True, frame: int | None = None
    ) -> list[int]:
        """The output frame for a frame that begins with the taxel ``first``, with ``forces`` or without.

        It is number ``frame`` of those that leave, by default ``sequence``.
        """
        count = self.design.frame_words
        words = [(first + number) & 0xFFFFFFFF for number in range(count - 1)] + [STATUS]
        words[0] = sequence if frame is None else frame
        drop = next(each for each in self.design.layout if each.name == "forces")
        kept = [n for n in range(count) if forces or not drop.start <= n < drop.start + drop.count]
        return [sequence | user << 16, flags | 1 << 24, *(words[n] for n in kept)]
