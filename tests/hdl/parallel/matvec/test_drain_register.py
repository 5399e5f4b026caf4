"""DrainRegister: what lanes have added up in each pass, W words a cycle, whatever they held before the first."""

import random

import pytest

from tests.hdl.parallel.designs import label, make
from tfra.hdl.parallel.matvec.drain_register import DrainRegister, drain_steps
from tfra.sim.harness import play

DESIGNS = [make(2, 2), make(4, 4, lanes=12), make(4, 4, lanes=12, words=1), make(4, 6, lanes=8, words=2)]
PASSES = 12


def _signed(value, bits):
    value %= 1 << bits
    return value - (1 << bits) if value >> (bits - 1) else value


@pytest.mark.parametrize("design", DESIGNS, ids=label)
@pytest.mark.parametrize("slack", [0, 3])
def test_words_are_differences_of_captures(design, slack):
    rng, lanes, bits = random.Random(slack), design.architecture.mac_lanes, design.widths.accumulator
    steps, size, apart = drain_steps(design), design.architecture.vector_words, max(drain_steps(design), 2)
    half = 1 << (bits - 1)
    anything = [rng.randrange(-half, half) for _ in range(lanes)]
    passes = [[rng.choice([rng.randrange(-half, half), -half, half - 1]) for _ in range(lanes)] for _ in range(PASSES)]
    cycles, totals, complete, expected, drained = [{}, {"sums": anything}], anything, [], {}, []
    for added in passes:
        cycles += [{"sums": totals}] * (apart - 2 + rng.randint(0, slack)) + [{"sums": totals, "completing": 1}]
        totals = [_signed(total + word, bits) for total, word in zip(totals, added, strict=True)]
        complete.append(len(cycles))
        expected |= {len(cycles) + 1 + step: added[step * size : (step + 1) * size] for step in range(steps)}
        drained.append(len(cycles) + steps)
        cycles.append({"sums": totals})
    cycles += [{"sums": totals}] * (steps + 1)
    lane_ports = [
        {f"sums.{lane}": total for lane, total in enumerate(row.get("sums", [0] * lanes))}
        | ({"completing": 1} if "completing" in row else {})
        for row in cycles
    ]
    watched = ["complete", "draining", "primed", "drained", *(f"words.{k}" for k in range(size))]
    seen = play(DrainRegister(design), lane_ports, watched)
    assert [cycle for cycle, row in enumerate(seen) if row["complete"]] == complete
    assert [cycle for cycle, row in enumerate(seen) if row["drained"]] == drained
    found = {
        cycle: [row[f"words.{k}"] for k in range(size)]
        for cycle, row in enumerate(seen)
        if row["draining"] and row["primed"]
    }
    assert found == expected
