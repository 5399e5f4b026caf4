"""The testbench for Amaranth's own simulator: the core without Verilog or other tools."""

from collections.abc import Callable
from contextlib import nullcontext
from pathlib import Path
from typing import Any

from amaranth.sim import Simulator

from tfra.sim.protocol import Job, Outcome, Record, stalls

_PERIOD = 1e-6


def run(
    core: Any, job: Job, progress: Callable[[int], None] | None = None, waves: Path | None = None
) -> Outcome:
    """Run ``job`` on ``core``, a component with the stream ports ``taxel`` and ``result``, and ``load`` if it loads.

    Probes of the job are left out: their names are those of the Verilog.  ``waves`` is a VCD file to write.
    """
    record = Record(job)
    state = _State()
    simulator = Simulator(core)
    simulator.add_clock(_PERIOD)
    simulator.add_testbench(_driver(core, record, state), background=True)
    simulator.add_testbench(_monitor(core, record, state, progress))
    simulator.add_testbench(_clock(record, state), background=True)
    with simulator.write_vcd(str(waves)) if waves else nullcontext():
        simulator.run()
    record.cycles = state.cycle
    return record.outcome()


class _State:
    def __init__(self) -> None:
        self.cycle = 0
        self.hung = False

    def now(self) -> int:
        return self.cycle


def _clock(record: Record, state: _State) -> Callable[[Any], Any]:
    """Count cycles, and give up when no transfer has happened for the job's patience."""

    async def process(ctx: Any) -> None:
        before, since = -1, 0
        async for _ in ctx.tick():
            state.cycle += 1
            if record.transfers != before:
                before, since = record.transfers, state.cycle
            elif state.cycle - since > record.job.patience:
                state.hung = True

    return process


def _driver(core: Any, record: Record, state: _State) -> Callable[[Any], Any]:
    job = record.job

    async def send(ctx: Any, name: str, words: list[int], sent: Callable[[], None]) -> None:
        port, pattern = getattr(core, name), stalls(job.stall_in, job.seed, name)
        for word in words:
            while next(pattern):
                ctx.set(port.valid, 0)
                await ctx.tick()
            ctx.set(port.payload, word)
            ctx.set(port.valid, 1)
            await ctx.tick().until(port.ready)
            sent()
        ctx.set(port.valid, 0)

    async def process(ctx: Any) -> None:
        if job.coefficients is not None:
            await send(ctx, "load", job.coefficients, record.coefficient_sent)
        await send(ctx, "taxel", job.codes, lambda: record.taxel_sent(state.now))

    return process


def _monitor(core: Any, record: Record, state: _State, progress: Callable[[int], None] | None) -> Callable[[Any], Any]:
    job, port = record.job, core.result
    pattern = stalls(job.stall_out, job.seed, "result")

    async def process(ctx: Any) -> None:
        mask = (1 << len(port.payload.data)) - 1
        tick = ctx.tick().sample(port.valid, port.payload.data, port.payload.last)
        while record.missing and not state.hung:
            ready = not next(pattern)
            ctx.set(port.ready, ready)
            _, _, valid, data, last = await tick
            if not valid:
                record.rules.idle()
            elif record.word_seen(data & mask, last, ready, state.now) and progress:
                progress(1)
        if state.hung:
            record.hung()
            return
        ctx.set(port.ready, 1)
        for _ in range(job.drain):
            _, _, valid, *_ = await tick
            if valid:
                record.rules.surplus()
                return

    return process
