"""The cocotb testbench: runs inside Icarus or Verilator, on a core with the ports of the generated Verilog.

``TFRA_JOB`` names the file of the job, ``TFRA_OUTCOME`` that of the outcome, and ``TFRA_PROGRESS`` that of the number
of finished frames.  One coroutine serves each port and sleeps until valid or ready changes wherever it can, because
waking Python costs more than simulating a cycle.  The clock itself is cocotb's own in C++.
"""

import os
import time
from collections.abc import Callable, Sequence
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


async def _send(dut: Any, name: str, job: Job, words: list[int], sent: Callable[[], None]) -> None:
    """Send ``words`` to the stream ``name``, with the stalls of the job; ``sent`` is called at every transfer."""
    data, valid, ready = dut[f"{name}_data"], dut[f"{name}_valid"], dut[f"{name}_ready"]
    clk, rise, pattern = RisingEdge(dut.clk), RisingEdge(ready), stalls(job.stall_in, job.seed, name)
    for word in words:
        if next(pattern):
            valid.value = 0
            await clk
            while next(pattern):
                await clk
        data.value = word
        valid.value = 1
        await clk
        while not ready.value:
            await rise
            await clk
        sent()
    valid.value = 0


async def _drive(dut: Any, record: Record) -> None:
    """Load coefficients, if the core wants them, and send all frames."""
    job = record.job
    if job.coefficients is not None:
        await _send(dut, "load", job, job.coefficients, record.coefficient_sent)
    await _send(dut, "taxel", job, job.codes, record.taxel_sent)


async def _take(dut: Any, record: Record, progress: Path) -> None:
    """Take all frames from the result stream, then see that nothing follows."""
    job, due = record.job, 0.0
    data, last, valid = dut.result_data, dut.result_last, dut.result_valid
    clk, rise, pattern = RisingEdge(dut.clk), RisingEdge(valid), stalls(job.stall_out, job.seed, "result")
    missing = record.missing
    while missing:
        ready = not next(pattern)
        dut.result_ready.value = int(ready)
        await clk
        while not valid.value:
            record.idle()
            await rise
            await clk
        if record.word(int(data.value), int(last.value), ready) and time.monotonic() > due:
            due = time.monotonic() + _PROGRESS_PERIOD
            progress.write_text(str(len(record.outcome.last_word)))
        missing -= ready
    progress.write_text(str(job.results))
    dut.result_ready.value = 1
    await clk
    if not valid.value:
        await First(rise, Timer(job.drain * PERIOD, "step"))
    if valid.value:
        record.surplus()


async def _listen(dut: Any, probes: Sequence[Probe], packed: list[list[int]]) -> None:
    """Append the words of every transfer of the ``probes`` to their lists in ``packed``."""
    signals = [(resolve(dut, probe.transfer), resolve(dut, probe.words)) for probe in probes]
    clk = RisingEdge(dut.clk)
    while True:
        await clk
        for (transfer, words), seen in zip(signals, packed, strict=True):
            if transfer.value:
                seen.append(int(words.value))


async def _watch(record: Record) -> None:
    """Return when no transfer has happened for the job's patience."""
    before = -1
    while record.transfers != before:
        before = record.transfers
        await Timer(record.job.patience * PERIOD, "step")


async def _reset(dut: Any, job: Job) -> int:
    """Start the clock and reset the core; returns the simulator's time of the last edge with a reset."""
    dut.rst.value = 1
    dut.result_ready.value = 0
    for name, value in job.settings.items():
        dut[name].value = value
    for name in ("taxel",) if job.coefficients is None else ("load", "taxel"):
        dut[f"{name}_data"].value = dut[f"{name}_valid"].value = 0
    Clock(dut.clk, PERIOD, "step").start()
    for _ in range(RESET_CYCLES):
        await RisingEdge(dut.clk)
    dut.rst.value = 0
    return int(get_sim_time("step"))


@cocotb.test()
async def frames(dut: Any) -> None:
    """The only test: the job of the environment."""
    job = Job.load(Path(os.environ["TFRA_JOB"]))
    start = await _reset(dut, job)
    record = Record(job, lambda: (int(get_sim_time("step")) - start) // PERIOD)
    if job.probes:
        cocotb.start_soon(_listen(dut, job.probes, record.outcome.probes))
    cocotb.start_soon(_drive(dut, record))
    taking = cocotb.start_soon(_take(dut, record, Path(os.environ["TFRA_PROGRESS"])))
    await First(taking, cocotb.start_soon(_watch(record)))
    if not taking.done():
        record.hung()
    record.close().save(Path(os.environ["TFRA_OUTCOME"]))
