"""FramesWaiting against a queue of places."""

from __future__ import annotations

import random
from collections import deque

import pytest

from tfra.hdl.parallel.tfra.combine.store import FRAMES
from tfra.hdl.parallel.tfra.combine.waiting import FramesWaiting
from tfra.sim.harness import play


@pytest.mark.parametrize("seed", range(3))
def test_frames_leave_in_the_order_of_their_places(seed):
    rng = random.Random(seed)
    waiting, entered, cycles, expected = deque(), 0, [], []
    for _ in range(200):
        enter = len(waiting) < FRAMES and rng.random() < 0.5
        leave = bool(waiting) and rng.random() < 0.5
        cycles.append({"enter": int(enter), "leave": int(leave)})
        expected.append(waiting[0] if waiting else None)
        if leave:
            waiting.popleft()
        if enter:
            waiting.append(entered % FRAMES)
            entered += 1
    seen = play(FramesWaiting(), cycles, ["some", "oldest"])
    assert [row["oldest"] if row["some"] else None for row in seen] == expected, f"seed {seed}"
