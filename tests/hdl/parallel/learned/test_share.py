"""Share and Forces against their model: p of all sizes and none, forces that are limited, stalls."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.hdl.parallel.designs import random_words
from tests.hdl.parallel.learned.designs import CASES, few, label
from tests.marks import STALLS
from tests.model.fixed.learned.cases import learned_design
from tfra.hdl.parallel.learned import payloads
from tfra.hdl.parallel.learned.forces import Forces
from tfra.hdl.parallel.learned.plan import FRAMES
from tfra.hdl.parallel.learned.share import Share
from tfra.model.fixed.butterfly import to_quads
from tfra.model.fixed.gain import Resultant
from tfra.model.fixed.learned.bounds import total_bits
from tfra.model.fixed.learned.share import share, shared
from tfra.sim.harness import PATTERNS, apart, flowing, run

NUMBER = 8


def draw(design, seed):
    """Resultants and p ``(n, m)`` of all sizes; that of the first frames is zero, a unit, and as long as it may be."""
    rng = np.random.default_rng(seed)
    bits, taxels = design.widths.division, design.sensor.taxels
    p = np.abs(random_words(rng, design.widths.force, (NUMBER, taxels)))
    p >>= rng.integers(0, design.widths.force - 1, (NUMBER, 1))
    p = np.minimum(p, (1 << (design.widths.force - 1)) - 1)
    p[0], p[1], p[2] = 0, np.arange(taxels) == taxels - 1, (1 << (design.widths.force - 1)) - 1
    exponent = rng.integers(bits - design.widths.vector, bits, NUMBER)
    return Resultant(random_words(rng, bits, (NUMBER, 3)), exponent), p


def send_share(design, total, p, stall=flowing, seed=0):
    facts = [
        {"total": {"words": words, "exponent": exponent}, "mu_x": 0, "mu_y": 0}
        for words, exponent in zip(total.words.tolist(), total.exponent.tolist(), strict=True)
    ]
    q = design.quads
    return run(
        Share(design),
        {"p": to_quads(design, p).reshape(-1, 4).tolist(), "contact": facts},
        {"share": 3 * NUMBER, "share_token": NUMBER},
        stall_in=apart(stall, 4),
        steady=("contact",),
        leave={"p": lambda number, record, cycle: len(record.cycles["share_token"]) > number // q},
        seed=seed,
    )


@few
@given(st.integers(0, 1 << 32), st.sampled_from(CASES), st.sampled_from(PATTERNS))
def test_share_equals_the_model(seed, design, stall):
    total, p = draw(design, seed)
    seen = send_share(design, total, p, stall, seed)
    want = share(design, total, p)
    found = seen.values["share"]
    assert [one["even"] for one in found] == np.repeat(want.even, 3).tolist()
    assert [one["shift"] for one in found] == np.repeat(want.shift, 3).tolist()
    assert [one["mantissa"] for one in found] == want.mantissa.ravel().tolist()


@pytest.mark.parametrize("design", [*CASES, learned_design(2, 2, lanes=4)], ids=label)
def test_the_longest_shift_has_its_place_and_nothing_is_much_longer(design):
    """The largest sum of p, whose share is a resultant of nothing, or of the least that is not."""
    taxels = design.sensor.taxels
    p = np.full((2, taxels), (1 << (design.widths.force - 1)) - 1)
    assert int(p.sum(axis=1)[0]).bit_length() == total_bits(design, design.widths)
    least = np.array([design.widths.division - 1, design.widths.division - 2])
    found = share(design, Resultant(np.array([[0, 0, 0], [0, 0, -1]]), least), p)
    beyond = payloads.most_shift(design) - found.shift.max()
    assert beyond >= 0
    if design.formats.vector_fraction >= design.formats.force_fraction:
        assert beyond <= 2


def test_latency_and_interval_of_share_are_as_stated():
    design = learned_design(3, 4)
    seen, block = send_share(design, *draw(design, 1)), Share(design)
    block._MustUse__silence = True  # figures alone are wanted
    last = np.array(seen.cycles["p"])[design.quads - 1 :: design.quads]
    found = np.array(seen.cycles["share"]).reshape(-1, 3)
    assert (found - last[:, None] == block.latency + block.interval * np.arange(3)).all()


def send_forces(design, part, p, **stalls):
    """p of no more than ``FRAMES`` frames before the forces of the first; shares after the p of their frame."""
    shares = [
        {"mantissa": mantissa, "shift": int(part.shift[frame]), "even": int(part.even[frame])}
        for frame in range(NUMBER)
        for mantissa in part.mantissa[frame].tolist()
    ]
    q, words = design.quads, 3 * design.sensor.taxels
    return run(
        Forces(design),
        {"p": to_quads(design, p).reshape(-1, 4).tolist(), "share": shares},
        {"taxel": NUMBER * words},
        leave={
            "p": lambda number, record, cycle: number // q < len(record.values["taxel"]) // words + FRAMES,
            "share": lambda number, record, cycle: len(record.cycles["p"]) >= q * (number // 3 + 1),
        },
        **stalls,
    )


def check_forces(design, seed, **stalls):
    total, p = draw(design, seed)
    part = share(design, total, p)
    words, _ = shared(design, part, p)
    seen = send_forces(design, part, p, seed=seed, **stalls)
    found = seen.values["taxel"]
    assert [one["word"] for one in found] == words.ravel().tolist()
    ends = np.arange(1, len(found) + 1) % (3 * design.sensor.taxels) == 0
    assert [bool(one["last"]) for one in found] == ends.tolist()
    limited = np.array([one["limited"] for one in found]).reshape(NUMBER, -1).any(axis=1)
    assert limited.tolist() == shared(design, part, p)[1].tolist()
    return seen


@pytest.mark.parametrize(("stall_in", "stall_out"), STALLS)
def test_forces_equal_the_model_whatever_stalls(stall_in, stall_out):
    check_forces(learned_design(3, 3), 3, stall_in=stall_in, stall_out=stall_out)


@pytest.mark.parametrize("design", CASES, ids=label)
def test_forces_equal_the_model(design):
    check_forces(design, 5)


def test_latency_of_forces_is_as_stated():
    design = learned_design(3, 4)
    seen, block = check_forces(design, 1), Forces(design)
    block._MustUse__silence = True  # figures alone are wanted
    taxels = design.sensor.taxels
    # A share is offered from the cycle after the one before was taken, with the last read of its plane.
    first, second = seen.cycles["taxel"][0], seen.cycles["taxel"][taxels]
    assert second - seen.cycles["share"][0] == 1 + block.latency
    assert second - first == taxels


def test_a_wrong_bit_is_noticed():
    design = learned_design(2, 2)
    total, p = draw(design, 2)
    seen = send_share(design, total, p)
    other = share(design, Resultant(total.words ^ (1 << (design.widths.division - 3)), total.exponent), p)
    assert [one["mantissa"] for one in seen.values["share"]] != other.mantissa.ravel().tolist()
