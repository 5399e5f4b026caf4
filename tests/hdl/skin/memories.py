"""Memories beside a block: their words come a cycle after their addresses."""

from typing import Any, NamedTuple

import numpy as np
from amaranth.sim import Simulator

from tfra.model.arrays import Bools, Ints
from tfra.sim.harness import plain

LIMIT = 20_000


class Bitmap(NamedTuple):
    """Rows of a bitmap as words, and the block's way to it."""

    rows: list[int]
    way: Any


def words_of(bits: Bools) -> list[int]:
    """A word for each row of ``bits (rows, columns)``."""
    return [sum(int(bit) << place for place, bit in enumerate(row)) for row in bits]


def bits_of(words: list[int], columns: int) -> Bools:
    return np.array([[word >> place & 1 for place in range(columns)] for word in words], dtype=np.bool_)


async def serve(ctx: Any, bitmaps: list[Bitmap], heights: tuple[Any, Ints] | None = None) -> None:
    """Answer what a block reads of ``bitmaps``, and of ``heights`` at its port ``place``, and store what it writes."""
    block, grid = heights or (None, None)
    signals = [getattr(each.way, name) for each in bitmaps for name in ("row", "write", "target", "data")]
    while True:
        *_, place, words = await _next(ctx, signals, block)
        for number, (rows, way) in enumerate(bitmaps):
            row, write, target, data = words[4 * number : 4 * number + 4]
            ctx.set(way.word, rows[row] if row < len(rows) else 0)
            if write:
                rows[target] = data
        if block is not None and grid is not None:
            row, column = place["row"], place["column"]
            inside = row < grid.shape[0] and column < grid.shape[1]
            ctx.set(block.height, int(grid[row, column]) if inside else 0)


async def _next(ctx: Any, signals: list[Any], block: Any) -> Any:
    places = [] if block is None else [block.place]
    _, _, *values = await ctx.tick().sample(*signals, *places)
    return plain(values[-1]) if places else None, values[: len(signals)]


def played(dut: Any, bench: Any, *others: Any) -> None:
    """Run ``bench`` to its end beside ``others``, testbenches that have none."""
    simulator = Simulator(dut)
    simulator.add_clock(1e-6)
    for other in others:
        simulator.add_testbench(other, background=True)
    simulator.add_testbench(bench)
    simulator.run()


async def until(ctx: Any, signal: Any) -> int:
    """Wait for a pulse; the cycles that it took."""
    for cycle in range(LIMIT):
        *_, high = await ctx.tick().sample(signal)
        if high:
            return cycle
    raise AssertionError(f"no pulse in {LIMIT} cycles")
