"""A driver with a simulated core: every access of the driver is one of AXI4-Lite in a Verilog simulator.

It plays the scenario with the driver of the package in the working directory; ``outcome.json`` says what went wrong, or
nothing.  ``world.json``: ``name`` of the design, ``driver``: c or python, ``taxels_per_beat``, ``sidecar``,
``coefficients``, ``frames`` of converters' words, which are computed one after the other, and words of their
``results``.
"""

import json
import sys
import traceback
from collections.abc import Callable, Coroutine, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

import cocotb
from cocotb.clock import Clock
from cocotb.task import bridge, resume
from cocotb.triggers import ClockCycles, RisingEdge, with_timeout
from cocotbext.axi import AxiLiteBus, AxiLiteMaster, AxiStreamBus, AxiStreamFrame, AxiStreamSink, AxiStreamSource

from tests.codegen.package.c_driver import CCore, compiled
from tests.codegen.package.scenario import play

POLLS = 1000
"""Enough for everything that a driver waits for here, so that a fault ends soon."""
PATIENCE_US = 10_000


class SlaveError(Exception):
    """The core answered an access with an error."""


class World:
    """The core with its driver; all methods block."""

    def __init__(self, dut: Any, facts: dict[str, Any], host: Any) -> None:
        bus, low = AxiLiteBus.from_prefix(dut, "s_axi"), {"reset_active_level": False}
        self.host, self.facts, self._dut = host, facts["sidecar"], dut
        self.coefficients, self.frames, self.results = facts["coefficients"], facts["frames"], facts["results"]
        self.taxels_per_beat = facts["taxels_per_beat"]
        self._manager = AxiLiteMaster(bus, dut.aclk, dut.aresetn, **low)
        self._source = AxiStreamSource(AxiStreamBus.from_prefix(dut, "s_axis"), dut.aclk, dut.aresetn, **low)
        self._sink = AxiStreamSink(AxiStreamBus.from_prefix(dut, "m_axis"), dut.aclk, dut.aresetn, **low)
        self._library = compiled(Path.cwd(), facts["name"]) if facts["driver"] == "c" else None
        self._damaged: int | None = None

    def core(self, facts: dict[str, Any]) -> Any:
        """A driver of the core, as for the design ``facts``."""
        if self._library is None:
            return self.host.Core(self, facts, POLLS)
        return CCore(self._library, self.host, self, facts, POLLS)

    def read32(self, address: int) -> int:
        answer = self._done(lambda: self._manager.read(address, 4))
        if int(answer.resp):
            raise SlaveError(f"read of {address:#x}")
        return int.from_bytes(answer.data, "little")

    def damage(self, address: int) -> None:
        """Flip the lowest bit of the next word that the driver writes there."""
        self._damaged = address

    def write32(self, address: int, word: int) -> None:
        if address == self._damaged:
            self._damaged, word = None, word ^ 1
        answer = self._done(lambda: self._manager.write(address, word.to_bytes(4, "little")))
        if int(answer.resp):
            raise SlaveError(f"write of {address:#x}")

    def send(self, words: Sequence[int], user: int) -> None:
        """A frame, until its last beat was taken."""

        async def sent() -> None:
            await self._source.send(self._frame(words, user))
            await self._source.wait()

        self._done(sent)

    def send_slowly(self, words: Sequence[int], user: int, cycles: int) -> None:
        """A beat of the frame in so many ``cycles``, until its first one was taken; the others come by themselves."""
        self._source.set_pause_generator(number % cycles > 0 for number in range(cycles * (len(words) + 1) + 1))

        async def begun() -> None:
            await self._source.send(self._frame(words, user))
            while not int(self._dut.s_axis_tvalid.value):
                await RisingEdge(self._dut.aclk)

        self._done(begun)

    def receive(self) -> bytes:
        """The next output frame."""
        return bytes(self._done(lambda: self._sink.recv(compact=False)).tdata)

    def interrupt(self, cycles: int = 10) -> bool:
        """Whether the interrupt is high after ``cycles``."""

        async def level() -> bool:
            await ClockCycles(self._dut.aclk, cycles)
            return bool(int(self._dut.irq.value))

        return bool(self._done(level))

    def _frame(self, words: Sequence[int], user: int) -> AxiStreamFrame:
        data = b"".join((word & 0xFFFF).to_bytes(2, "little") for word in words)
        return AxiStreamFrame(data + bytes(-len(data) % (2 * self.taxels_per_beat)), tuser=user)

    def _done(self, what: Callable[[], Coroutine[Any, Any, Any]]) -> Any:
        async def timed() -> Any:
            return await with_timeout(cocotb.start_soon(what()), PATIENCE_US, "us")

        return resume(timed)()


@cocotb.test()
async def drive(dut: Any) -> None:
    """The scenario, in a thread of its own."""
    facts = json.loads(Path("world.json").read_text())
    sys.path.insert(0, str(Path.cwd() / "python"))
    world = World(dut, facts, import_module("tfra_host"))
    dut.aresetn.value = 0
    Clock(dut.aclk, 10, unit="ns").start()
    await ClockCycles(dut.aclk, 8)
    dut.aresetn.value = 1
    await ClockCycles(dut.aclk, 4)
    error = await bridge(_played)(world)
    Path("outcome.json").write_text(json.dumps(error))


def _played(world: World) -> str:
    try:
        play(world)
    except Exception:
        return traceback.format_exc()
    return ""
