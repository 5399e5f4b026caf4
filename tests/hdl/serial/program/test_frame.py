"""The programs, run by the interpreter, compute what the models do, in the cycles they state."""

from dataclasses import replace

import numpy as np
import pytest

from tests.hdl.serial.designs import DESIGNS, LEARNED, LEARNED_TEN, TEN, random_design, tfra
from tests.hdl.serial.interpreted import check, interpret, scenes
from tests.marks import long
from tests.model.fixed.learned.cases import learned_design
from tfra.hdl.cores import program
from tfra.hdl.serial.program.memory import bases, groups, operators, store_image
from tfra.hdl.serial.sizes import lane_count
from tfra.model.choices import SERIAL, Search
from tfra.model.cover.scenes import contact_codes, directed_codes

TFRA, FORCES = DESIGNS["2×3"], LEARNED["2×3, forces"]
ALL = [*DESIGNS.values(), *LEARNED.values()]
LONG = ("5×7, tolerance", "wide", "long", "3×5", "5×7, forces")
CASES = [long(design)[0] if name in LONG else design for each in (DESIGNS, LEARNED) for name, design in each.items()]


@pytest.mark.parametrize("design", CASES)
def test_every_word_equals_the_model(design):
    check(design, scenes(design, seed=1))


@pytest.mark.parametrize("seed", [3, 4, 5, *long(0, 1, 2)])
def test_any_small_array(seed):
    design = random_design(seed)
    check(design, scenes(design, seed)[::3])


def near(design):
    """Frames on either side of the contact threshold, as they are and halved."""
    codes = directed_codes(design)[-4:]
    return np.concatenate([codes, codes // 2])


@pytest.mark.parametrize(
    ("design", "threshold"),
    [*((TFRA, value) for value in (0, 1, 5, 1023, 1024, 8191)), *((FORCES, value) for value in (0, 1, 1023, 2047))],
)
def test_the_contact_threshold(design, threshold):
    design = replace(design, adc=replace(design.adc, contact_threshold=threshold))
    check(design, near(design))


@pytest.mark.parametrize("design", [TFRA, FORCES])
@pytest.mark.parametrize("wrong", [-1, 1])
def test_a_wrong_threshold_is_noticed(design, wrong):
    design, other = (replace(design, adc=replace(design.adc, contact_threshold=t)) for t in (50, 50 + wrong))
    assert (interpret(other, near(design))[0] != design.model(near(design)).words).any()


@pytest.mark.parametrize(("design", "count"), [(DESIGNS["3×4"], 1), (FORCES, 9)])
def test_a_wrong_coefficient_is_noticed(design, count):
    """The first one of each of the first ``count`` operators."""
    codes = contact_codes(design, 1, seed=1)
    for start in list(bases(design).values())[:count]:
        image = store_image(design)
        image[start, 0] ^= 1 << 14
        assert (interpret(design, codes, image)[0] != design.model(codes).words).any()


@pytest.mark.parametrize("design", ALL)
def test_every_coefficient_is_in_its_place_and_all_else_is_zero(design):
    image, start, lanes = store_image(design), bases(design), lane_count(design)
    for op in operators(design):
        k = op.rows.shape[2]
        for quad, parity in np.ndindex(op.quads, 4):
            row = start[op.name] + (parity * groups(design, op) + quad // lanes) * k
            assert (image[row : row + k, quad % lanes] == op.rows[quad, parity]).all()
            image[row : row + k, quad % lanes] = 0
    assert not image.any()


@pytest.mark.parametrize(
    ("design", "frames", "lengths", "words", "store", "interval"),
    [
        (TEN, slice(None, None, 6), (25,), 1280, 7400, 40_000),
        (LEARNED_TEN, slice(None, None, 12), (25, 48, 24), 768, 4 * (17 * 25 + 9 * 48 + 24), 14_500),
        (replace(LEARNED_TEN, taxel_forces=True), slice(None, None, 24), (25, 48, 24), 1280, None, 40_000),
    ],
    ids=["TFRA", "learned", "learned, forces"],
)
def test_ten_by_ten_equals_the_model_and_fits_a_small_fpga(design, frames, lengths, words, store, interval):
    """iCE40UP5K: 1024 instructions and 1280 words are 27 of its 30 block memories.

    At 29 MHz, 2,000 frames/s are 14,500 cycles a frame.
    """
    check(design, scenes(design, seed=2)[frames])
    code = program(design)
    assert code.lengths == lengths
    assert len(code.instructions) <= 1024
    assert len(code.memory) <= words
    assert code.operands <= 256
    assert store in (None, len(store_image(design)))
    assert code.interval <= interval


@pytest.mark.parametrize(
    ("design", "what"),
    [
        (tfra(4, 4, 2e-3, 2e-3, 3e-3, search=Search(1000)), "2048 words, more are needed"),
        (tfra(20, 20, 2e-3, 2e-3, 3e-3, search=Search(4)), "2048 words, more are needed"),
        (learned_design(20, 20, (150, 20), architecture=SERIAL), "2048 words, more are needed"),
        (learned_design(10, 10, (250, 4), architecture=SERIAL), "2048 words, more are needed"),
        (learned_design(4, 4, (100, 160), architecture=SERIAL), "store holds 16384 words of coefficients, 23296"),
    ],
)
def test_designs_that_do_not_fit_are_refused(design, what):
    with pytest.raises(ValueError, match=f"^architecture.kind: the serial core.*{what}"):
        _ = program(design), store_image(design)
