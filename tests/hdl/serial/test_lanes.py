"""Sums of products of every lane, when they are stated to be there."""

import random
from itertools import pairwise

import pytest

from tfra.hdl.serial.isa import MAC_DELAY
from tfra.hdl.serial.lanes import Lanes
from tfra.hdl.serial.sizes import Sizes
from tfra.sim.harness import play

SIZES = Sizes(24, 8, 12, 16, 3, 24, 16, 16, 16, 8, 16)


def schedule(lengths):
    """First cycles of groups of these lengths that follow each other as soon as their sums can be told apart."""
    starts = [0]
    for length, following in pairwise(lengths):
        starts.append(starts[-1] + length + max(0, SIZES.lanes - following))
    return starts


@pytest.mark.parametrize("lengths", [(1, 1), (2, 2), (5, 5), (5, 2, 3, 2, 5), (1, 7, 1)])
def test_groups_back_to_back(lengths):
    rng = random.Random(sum(lengths))
    operands = [rng.randrange(-1 << 11, 1 << 11) for _ in range(max(lengths))]
    rows = [[rng.randrange(-1 << 7, 1 << 7) for _ in range(SIZES.lanes)] for _ in range(sum(lengths))]
    choices = tuple(dict.fromkeys(lengths))
    starts = dict(zip(schedule(lengths), lengths, strict=True))
    firsts = [start + length + MAC_DELAY - 1 for start, length in starts.items()]
    reading = [first + lane for first in firsts for lane in range(SIZES.lanes)]
    before = [{"load": 1, "word": sum((value % 256) << (8 * lane) for lane, value in enumerate(row))} for row in rows]
    before += [{"write": 1, "write_address": n, "write_data": value} for n, value in enumerate(operands)]
    before += [{"set_pointer": 1, "pointer": 0}]
    groups = []
    for cycle in range(max(reading) + 1):
        groups.append({"start": cycle in starts, "next": cycle in reading})
        if len(choices) > 1:
            groups[-1]["length"] = choices.index(starts.get(cycle, lengths[0]))
    record = play(Lanes(SIZES, choices, len(operands), len(rows), "portable"), before + groups, ["sum"])
    sums, begin = [], 0
    for length in lengths:
        products = [[a * b for b in row] for a, row in zip(operands, rows[begin : begin + length], strict=False)]
        sums += [sum(column) for column in zip(*products, strict=True)]
        begin += length
    assert [record[len(before) + cycle]["sum"] for cycle in reading] == sums
