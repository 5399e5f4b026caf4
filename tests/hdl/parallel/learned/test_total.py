"""Total against plain sums, with the parts of several frames in any order that the products allow."""

import random

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.hdl.parallel.designs import random_words
from tests.hdl.parallel.learned.designs import CASES, few
from tfra.hdl.parallel.learned.plan import FRAMES
from tfra.hdl.parallel.learned.total import PARTS, QUADS, Total
from tfra.model.fixed.butterfly import OO
from tfra.sim.harness import PATTERNS, flowing, run

NUMBER = 9
ZERO = {"exponent": 0, "magnitude": 0, "traction": 0, "saturated": 0}


def order(rng: random.Random) -> list[tuple[int, int]]:
    """Parts and frames: a part after the one before it, no more than ``FRAMES`` frames on their way."""
    done, found = [0] * len(PARTS), []
    while done[-1] < NUMBER:
        ready = [0] if done[0] < min(NUMBER, done[-1] + FRAMES) else []
        ready += [part for part in (1, 2) if done[part] < done[part - 1]]
        part = rng.choice(ready)
        found.append((part, done[part]))
        done[part] += 1
    return found


def send(design, parts, contact, seed, stall=flowing):
    """``parts (3, n, 2, 4)``; one quad or more of other operators come between."""
    rng = random.Random(seed)
    sent = []
    for part, frame in order(rng):
        kind = 1 << design.kinds.index(PARTS[part])
        sent += [{"words": quad, "kind": kind} for quad in parts[part, frame].tolist()]
        sent += [{"words": [1, 2, 3, 4], "kind": 1 << design.kinds.index("first")}] * rng.randrange(1, 4)
    facts = [ZERO | {"contact": int(bit)} for bit in contact]
    return run(
        Total(design), {"result": sent, "frame": facts}, {"total": QUADS * NUMBER}, stall_in=stall, steady=("frame",)
    )


def draw(design, seed):
    rng = np.random.default_rng(seed)
    parts = random_words(rng, design.widths.vector - 2, (3, NUMBER, QUADS, 4))
    parts[..., OO] = 0
    return parts, rng.random(NUMBER) < 0.7


@few
@given(st.integers(0, 1 << 32), st.sampled_from(CASES), st.sampled_from(PATTERNS))
def test_equals_the_sum(seed, design, stall):
    parts, contact = draw(design, seed)
    seen = send(design, parts, contact, seed, stall)
    want = parts.sum(axis=0) * contact[:, None, None]
    assert seen.values["total"] == want.reshape(-1, 4).tolist()


def test_latency_is_as_stated():
    design = CASES[0]
    parts, contact = draw(design, 1)
    seen = send(design, parts, contact, 1)
    kind = 1 << design.kinds.index("read2")
    last = [c for c, v in zip(seen.cycles["result"], seen.values["result"], strict=True) if v["kind"] == kind]
    assert [b - a for a, b in zip(last, seen.cycles["total"], strict=True)] == [Total.latency] * len(last)
    assert [b - a for a, b in zip(last[1::2], seen.cycles["frame"], strict=True)] == [2] * NUMBER


@pytest.mark.parametrize("part", range(3))
def test_a_wrong_bit_is_noticed(part):
    design = CASES[0]
    parts, contact = draw(design, 2)
    contact[:] = True
    seen = send(design, parts, contact, 2)
    parts[part, 3, 1, 0] ^= 1
    assert seen.values["total"] != parts.sum(axis=0).reshape(-1, 4).tolist()
