"""The cocotb testbench: runs inside Icarus or Verilator, on a core with the ports of the generated Verilog.

``TFRA_JOB`` names the file of the job, ``TFRA_OUTCOME`` that of the outcome, and ``TFRA_PROGRESS`` that of the number
of finished frames.  One coroutine serves each port and sleeps until valid or ready changes wherever it can, because
waking Python costs more than simulating a cycle.  The clock itself is cocotb's own in C++.
"""

import os
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import First, RisingEdge, Timer
from cocotb.utils import get_sim_time

from tfra.sim.protocol import Job, Probe, Record, stalls

PERIOD = 10  # steps of the simulator's time unit
RESET_CYCLES = 4
_PROGRESS_PERIOD = 0.25  # seconds between two notes of progress


def resolve(top: Any, path: str) -> Any:
    """Return the signal at ``path`` under ``top``; raises ``LookupError`` naming the path."""
    handle = top
    for name in path.split("."):
        try:
            handle = handle[name]
        except (KeyError, TypeError):
            raise LookupError(f"probe {path}: there is no {name} below {handle._path}") from None
    return handle


class Time:
    """Clock edges since the end of reset."""

    def __init__(self) -> None:
        self._start = 0

    def restart(self) -> None:
        """Make the latest clock edge number zero."""
        self._start = int(get_sim_time("step"))

    def cycle(self) -> int:
        """Return the number of the latest clock edge."""
        return (int(get_sim_time("step")) - self._start) // PERIOD


class Driver:
    """Source of the stream ``name``, with the stalls of the job."""

    def __init__(self, dut: Any, name: str, job: Job) -> None:
        self._clk, self._data = RisingEdge(dut.clk), dut[f"{name}_data"]
        self._valid, self._ready = dut[f"{name}_valid"], dut[f"{name}_ready"]
        self._stalls = stalls(job.stall_in, job.seed, name)

    async def send(self, words: list[int], sent: Callable[[], None]) -> None:
        """Send ``words``; ``sent`` is called at every transfer."""
        clk, rise = self._clk, RisingEdge(self._ready)
        for word in words:
            if next(self._stalls):
                self._valid.value = 0
                await clk
                while next(self._stalls):
                    await clk
            self._data.value = word
            self._valid.value = 1
            await clk
            while not self._ready.value:
                await rise
                await clk
            sent()
        self._valid.value = 0


class Monitor:
    """Sink of the result stream, with the checks of :class:`tfra.sim.protocol.StreamRules`."""

    def __init__(self, dut: Any, record: Record, now: Time, progress: Path) -> None:
        self._clk = RisingEdge(dut.clk)
        self._data, self._last = dut.result_data, dut.result_last
        self._valid, self._ready = dut.result_valid, dut.result_ready
        self._record, self._now, self._progress = record, now, progress
        self._stalls = stalls(record.job.stall_out, record.job.seed, "result")
        self._due = 0.0

    async def run(self) -> None:
        """Take all frames, then see that nothing follows."""
        clk, rise, record = self._clk, RisingEdge(self._valid), self._record
        missing = record.missing
        while missing:
            ready = not next(self._stalls)
            self._ready.value = int(ready)
            await clk
            while not self._valid.value:
                record.rules.idle()
                await rise
                await clk
            if record.word_seen(int(self._data.value), int(self._last.value), ready, self._now.cycle):
                self._note_progress()
            missing -= ready
        await self._drain()

    async def _drain(self) -> None:
        self._ready.value = 1
        await self._clk
        if not self._valid.value:
            await First(RisingEdge(self._valid), Timer(self._record.job.drain * PERIOD, "step"))
        if self._valid.value:
            self._record.rules.surplus()

    def _note_progress(self) -> None:
        """Write the number of finished frames, but not too often."""
        if time.monotonic() > self._due:
            self._due = time.monotonic() + _PROGRESS_PERIOD
            self._progress.write_text(str(len(self._record.last_word)))


class Tap:
    """Listener on a stream between two blocks."""

    def __init__(self, dut: Any, probe: Probe, words: list[int]) -> None:
        self._transfer, self._payload = resolve(dut, probe.transfer), resolve(dut, probe.words)
        self._words = words

    def sample(self) -> None:
        """Keep the words, if this clock edge is a transfer."""
        if self._transfer.value:
            self._words.append(int(self._payload.value))


async def _listen(dut: Any, taps: list[Tap]) -> None:
    clk = RisingEdge(dut.clk)
    while True:
        await clk
        for tap in taps:
            tap.sample()


async def _watch(record: Record) -> None:
    """Return when no transfer has happened for the job's patience."""
    before = -1
    while record.transfers != before:
        before = record.transfers
        await Timer(record.job.patience * PERIOD, "step")


async def _drive(dut: Any, record: Record, now: Time) -> None:
    """Load coefficients, if the core wants them, and send all frames."""
    job = record.job
    if job.coefficients is not None:
        await Driver(dut, "load", job).send(job.coefficients, record.coefficient_sent)
    await Driver(dut, "taxel", job).send(job.codes, lambda: record.taxel_sent(now.cycle))


async def _reset(dut: Any, job: Job, now: Time) -> None:
    dut.rst.value, dut.result_ready.value = 1, 0
    for name in ("taxel",) if job.coefficients is None else ("load", "taxel"):
        dut[f"{name}_data"].value = dut[f"{name}_valid"].value = 0
    Clock(dut.clk, PERIOD, "step").start()
    for _ in range(RESET_CYCLES):
        await RisingEdge(dut.clk)
    dut.rst.value = 0
    now.restart()


async def execute(dut: Any, job: Job, progress: Path) -> Record:
    """Run ``job`` and return its record."""
    record, now = Record(job), Time()
    await _reset(dut, job, now)
    if job.probes:
        taps = [Tap(dut, probe, words) for probe, words in zip(job.probes, record.probes, strict=True)]
        cocotb.start_soon(_listen(dut, taps))
    cocotb.start_soon(_drive(dut, record, now))
    monitor = cocotb.start_soon(Monitor(dut, record, now, progress).run())
    watchdog = cocotb.start_soon(_watch(record))
    await First(monitor, watchdog)
    if not monitor.done():
        record.hung()
    record.cycles = now.cycle()
    return record


@cocotb.test()
async def frames(dut: Any) -> None:
    """The only test: the job of the environment."""
    record = await execute(dut, Job.load(Path(os.environ["TFRA_JOB"])), Path(os.environ["TFRA_PROGRESS"]))
    record.outcome().save(Path(os.environ["TFRA_OUTCOME"]))
