"""The testbench for Amaranth's own simulator: the core without Verilog or other tools."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from tfra.sim.harness import Driver, Port
from tfra.sim.protocol import STALLS, Job, Outcome, Record, stalls


def run(core: Any, job: Job, progress: Callable[[int], None] | None = None, waves: Path | None = None) -> Outcome:
    """Run ``job`` on ``core``, a component with the stream ports ``taxel`` and ``result``, and ``load`` if it loads.

    Probes of the job are left out: their names are those of the Verilog.  ``waves`` is a VCD file to write.
    """
    loads = job.coefficients or []
    driver = Driver(core, job.seed, leave={"taxel": lambda *_: record.loaded == len(loads)})
    record: Record = Record(job, lambda: driver.cycle)
    if loads:
        driver.add_source("load", loads, STALLS[job.stall_in], record.coefficient_sent)
    driver.add_source("taxel", job.codes, STALLS[job.stall_in], record.taxel_sent)
    port, pattern = core.result, stalls(job.stall_out, job.seed, "result")

    def monitor(ctx: Any) -> Port:
        """Take all frames, then see that nothing follows; give up when no transfer has happened for too long."""
        mask = (1 << len(port.payload.data)) - 1
        before, since = -1, 0
        while record.missing:
            ready = not next(pattern)
            ctx.set(port.ready, ready)
            valid, data, last = yield
            if not valid:
                record.idle()
            elif record.word(data & mask, last, ready) and progress:
                progress(1)
            if record.transfers != before:
                before, since = record.transfers, driver.cycle
            elif driver.cycle - since > job.patience:
                record.hung()
                return
        ctx.set(port.ready, 1)
        for _ in range(job.drain):
            if (yield)[0]:
                record.surplus()
                return

    driver.add_watch(monitor, port.valid, port.payload.data, port.payload.last)
    driver.simulate(waves)
    return record.close()
