"""Coefficient memories hold every row of every operator where the lanes look for it."""

from dataclasses import replace
from operator import mul

import numpy as np
import pytest

from tests.hdl.parallel.designs import make
from tfra.hdl.parallel.matvec import images
from tfra.hdl.parallel.matvec.images import Tail, bases, lane_images, low_bits, order, passes, tail
from tfra.hdl.primitives.ecp5 import memories
from tfra.model.choices import FORMATS
from tfra.model.fixed.design import Design
from tfra.model.fixed.tfra.operators import OPERATORS, STACKS


def mixed(rows: int, columns: int, lanes: int, **bits: int) -> Design:
    """Coefficients as long as their stack says, 18 bits elsewhere."""
    own = tuple((f"coefficient.{op}", bits[stack]) for stack in bits for op in OPERATORS[stack])
    return replace(make(rows, columns, lanes=lanes), formats=replace(FORMATS["standard"], signals=own))


@pytest.mark.parametrize(
    "design",
    [
        make(2, 2),
        make(4, 6, lanes=8),
        mixed(4, 6, 8, contact=9, force=6, normal=18),
        make(5, 7),
        make(5, 7, "wide", lanes=20),
        make(10, 10, lanes=100),
    ],
    ids=str,
)
def test_every_coefficient_is_in_its_place_and_all_else_is_zero(design):
    lanes, q = design.architecture.mac_lanes, design.quads
    image, base = lane_images(design), bases(design)
    assert image.shape == (lanes, sum(passes(design, name) * q for name in STACKS))
    left = image.copy()
    for name in STACKS:
        quad = 0
        for op in design.stacks[name].operators:
            for i in range(op.quads):
                for parity in range(4):
                    row = 4 * quad + (parity ^ op.flip)
                    start = base[name] + row // lanes * q
                    assert np.array_equal(image[row % lanes, start : start + q], op.rows[i, parity])
                    left[row % lanes, start : start + q] = 0
                quad += 1
    assert not left.any()


def test_images_of_a_small_design_are_what_they_were_when_checked_by_hand():
    design = make(2, 2)
    contact, sums = design.stacks["contact"].operators
    image = lane_images(design)
    assert image.shape == (4, 2 + 6 + 1 + 3)
    assert image[:, 0].tolist() == contact.rows[0, :, 0].tolist()
    assert image[:, 1].tolist() == sums.rows[0, :, 0].tolist()
    c31 = design.stacks["residual"].operators[2]
    assert c31.flip == 1
    assert image[:, 6].tolist() == c31.rows[0, [1, 0, 3, 2], 0].tolist()


def test_uniform_words_have_no_tail():
    design = make(4, 6, lanes=8)
    assert tail(design).bits == 0
    assert order(design) == list(STACKS)


def test_the_tail_spares_block_memories():
    """Lengths of the stacks, all of them in memory: 9, 18, 18, 9; of 2,575 words 1,275 need no more than 9 bits.

    A pair of memories of 18 bits takes 6 blocks of 1,024 words; of 2,048 words of 9 bits 3, and 2 for the others.
    """
    design = mixed(10, 10, 8, contact=9, force=9)
    assert order(design) == ["residual", "normal", "contact", "force"]
    words = {name: 25 * passes(design, name) for name in STACKS}
    assert (sum(words.values()), words["residual"] + words["normal"]) == (2575, 1300)
    assert [memories(18, 2575), memories(9, 2575), memories(9, 1300)] == [6, 3, 2]
    assert tail(design) == Tail(9, 1300)


def test_a_tail_that_takes_more_block_memories_is_none():
    """Words of 13 and 8 bits in a shallow memory, half of a block: with a tail it would be twice as many."""
    assert memories(13, 162) == memories(8, 162) == memories(5, 100) == 1
    assert tail(mixed(4, 6, 8, contact=13, residual=13, normal=13, force=8)).bits == 0


@pytest.mark.parametrize("lengths", [{"force": 6}, {"contact": 9, "residual": 12}, {"normal": 7}])
def test_nothing_is_lost_behind_the_tail(lengths, monkeypatch):
    """Where every bit has its cost, the tail spares most bits."""
    monkeypatch.setattr(images, "memories", mul)
    design = mixed(4, 6, 8, **lengths)
    cut, image = tail(design), lane_images(design)
    assert 0 < cut.depth < image.shape[1]
    low = low_bits(image, cut.bits)
    assert not low[:, cut.depth :].any()
    assert np.abs(low).max() <= 1 << (cut.bits - 1)
    assert ((low & ((1 << cut.bits) - 1)) + ((image >> cut.bits) << cut.bits) == image).all()
