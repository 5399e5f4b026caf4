"""Sums of products of every lane, when they are stated to be there."""

import random

import numpy as np
import pytest

from tfra.hdl.serial.isa import MAC_DELAY
from tfra.hdl.serial.lanes import Lanes
from tfra.hdl.serial.sizes import Sizes
from tfra.sim.harness import play

SIZES = Sizes(24, 8, 12, 16, 3, 24, 16, 16, 16, 8, 16)


@pytest.mark.parametrize("lengths", [(1, 1), (2, 2), (5, 2, 3, 2, 5), (1, 7, 1)])
def test_groups_back_to_back(lengths):
    """Groups follow each other as soon as their sums can be told apart."""
    rng, choices, lanes = random.Random(sum(lengths)), list(dict.fromkeys(lengths)), SIZES.lanes
    operands = [rng.randrange(-1 << 11, 1 << 11) for _ in range(max(lengths))]
    rows = [[rng.randrange(-1 << 7, 1 << 7) for _ in range(lanes)] for _ in range(sum(lengths))]
    before = [{"load": 1, "word": sum((value % 256) << (8 * lane) for lane, value in enumerate(row))} for row in rows]
    before += [{"write": 1, "write_address": n, "write_data": value} for n, value in enumerate(operands)]
    before += [{"set_pointer": 1, "pointer": 0}]
    start, row, groups, sums = 0, 0, [{} for _ in range(sum(lengths) + 30)], {}
    for length, following in zip(lengths, (*lengths[1:], lanes), strict=True):
        groups[start] |= {"start": 1} | ({"length": choices.index(length)} if len(choices) > 1 else {})
        products = np.array(rows[row : row + length]).T @ operands[:length]
        for cycle, value in enumerate(products.tolist(), start + length + MAC_DELAY - 1):
            groups[cycle] |= {"next": 1}
            sums[cycle] = value
        row += length
        start += length + max(0, lanes - following)
    record = play(Lanes(SIZES, choices, len(operands), len(rows), "portable"), before + groups, ["sum"])
    assert {cycle: record[len(before) + cycle]["sum"] for cycle in sums} == sums
