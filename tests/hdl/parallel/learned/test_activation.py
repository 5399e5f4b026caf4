"""Activation against its model: any words within the bounds, quads of several operators, gaps between them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.hdl.parallel.designs import random_words
from tests.hdl.parallel.learned.designs import CASES, few, label
from tests.model.fixed.learned.cases import learned_design
from tfra.hdl.parallel.learned.activation import Activation
from tfra.hdl.parallel.learned.plan import UNITS, mirror_bits
from tfra.model.fixed.butterfly import butterfly
from tfra.model.fixed.learned.activation import activation
from tfra.model.fixed.learned.bounds import bounds
from tfra.model.fixed.learned.design import LearnedDesign
from tfra.model.fixed.numbers import signed_bits
from tfra.sim.harness import PATTERNS, flowing, run


def check(design: LearnedDesign, quads: np.ndarray, kinds: list[int], stall=flowing) -> None:
    """Only quads of operators in front of an activation come out, and in order."""
    sent = [{"words": quad, "kind": 1 << kind} for quad, kind in zip(quads.tolist(), kinds, strict=True)]
    there = [n for n, kind in enumerate(kinds) if design.kinds[kind] in UNITS]
    seen = run(Activation(design), {"result": sent}, {"units": len(there)}, stall_in=stall)
    assert [quad["words"] for quad in seen.values["units"]] == activation(quads[None])[0][there].tolist()
    assert [quad["kind"] for quad in seen.values["units"]] == [1 << kinds[n] for n in there]
    late = [b - seen.cycles["result"][n] for n, b in zip(there, seen.cycles["units"], strict=True)]
    assert set(late) <= {Activation(design).latency}


@few
@given(st.integers(0, 1 << 32), st.sampled_from(CASES), st.sampled_from(PATTERNS))
def test_equals_the_model(seed, design, stall):
    rng = np.random.default_rng(seed)
    taxels = random_words(rng, mirror_bits(design) - 2, (30, 4))
    quads = butterfly(taxels) // 4 + rng.integers(-3, 4, taxels.shape)
    quads = np.concatenate([quads, random_words(rng, mirror_bits(design) - 3, (30, 4))])
    check(design, quads, rng.integers(0, len(design.kinds), len(quads)).tolist(), stall)


@pytest.mark.parametrize("design", CASES, ids=label)
def test_ends_of_the_range(design):
    """A mirror's word is as long as it may be, alone and beside others."""
    most = (1 << (mirror_bits(design) - 3)) - 1
    rows = [[most, 0, 0, 0], [-most] * 4, [most] * 4, [most, -most, most, -most], [0, 0, 0, -most], [0] * 4]
    mirrors = np.array(rows)
    check(design, butterfly(mirrors), [design.kinds.index("first")] * len(mirrors))


@pytest.mark.parametrize(
    "design", [*CASES, learned_design(2, 2, (1, 1), seed=3), learned_design(5, 4, taxel_forces=False)], ids=label
)
def test_words_hold_the_units_of_every_layer(design):
    """The longest of them needs all of the bits."""
    most = bounds(design, design.stacks)
    bits = [signed_bits(most[name]) for name in ("h1", "h2", "p0") if name in most]
    assert len(bits) == 2 + design.taxel_forces
    assert mirror_bits(design) == max(bits)


def test_what_is_compressed_alone_stays():
    """Four mirrors of 4, 8, -12, 16: the negative one is lost."""
    quad = butterfly(np.array([1, 2, -3, 4]))
    assert activation(quad).tolist() == butterfly(np.array([4, 8, 0, 16])).tolist()
    check(CASES[0], quad[None], [0])


def test_a_wrong_bit_is_noticed():
    design = learned_design(2, 2)
    seen = run(Activation(design), {"result": [{"words": [5, 1, 2, 3], "kind": 1}]}, {"units": 1})
    assert seen.values["units"][0]["words"] != activation(np.array([5, 1, 2, 2])).tolist()
