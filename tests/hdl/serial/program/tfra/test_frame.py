"""The program, run by the interpreter, computes what the model does, in the cycles it states."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.hdl.serial.designs import DESIGNS, TEN, random_design
from tests.hdl.serial.interpreted import check, interpret
from tests.marks import long
from tfra.hdl.serial.program.memory import bases, groups, store_image
from tfra.hdl.serial.program.tfra.frame import program
from tfra.hdl.serial.sizes import lane_count
from tfra.model.choices import SERIAL, Adc, Search
from tfra.model.cover.scenes import contact_codes, directed_codes, wild_codes
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.fixed.tfra.operators import STACKS
from tfra.model.fixed.tfra.pipeline import FixedTfra
from tfra.model.sensor import SensorArray


def scenes(design, seed, contacts=3, wild=3):
    parts = contact_codes(design, contacts, seed), directed_codes(design), wild_codes(design, wild, seed)
    return np.concatenate(parts)


@pytest.mark.parametrize("name", ["2×3", "3×4", "wide", "short", *long("5×7, tolerance", "long")])
def test_every_word_equals_the_model(name):
    check(DESIGNS[name], scenes(DESIGNS[name], seed=1))


def near(design):
    """Frames on either side of the contact threshold, as they are and halved."""
    codes = directed_codes(design)[-4:]
    return np.concatenate([codes, codes // 2])


@pytest.mark.parametrize("threshold", [0, 1, 5, 1023, 1024, 8191])
def test_the_contact_threshold(threshold):
    design = replace(DESIGNS["2×3"], adc=Adc(contact_threshold=threshold))
    check(design, near(design))


@pytest.mark.parametrize("wrong", [-1, 1])
def test_a_wrong_threshold_is_noticed(wrong):
    design, other = (replace(DESIGNS["2×3"], adc=Adc(contact_threshold=t)) for t in (50, 50 + wrong))
    assert (interpret(other, near(design))[0] != FixedTfra(design)(near(design)).words).any()


@pytest.mark.parametrize("seed", [3, 4, 5, *long(0, 1, 2)])
def test_any_small_array(seed):
    design = random_design(seed)
    check(design, scenes(design, seed, contacts=2, wild=2)[::3])


def test_ten_by_ten_equals_the_model_and_fits_a_small_fpga():
    """iCE40UP5K: 1024 instructions, 1280 words and the operands' copy are 27 of its 30 block memories."""
    check(TEN, scenes(TEN, seed=2)[::6])
    code = program(TEN)
    assert len(code.instructions) <= 1024
    assert len(code.memory) <= 1280
    assert code.operands <= 256
    assert len(store_image(TEN)) == 7400


def test_a_wrong_coefficient_is_noticed():
    design = DESIGNS["3×4"]
    codes = contact_codes(design, 1, seed=1)
    image = store_image(design)
    image[0, 0] ^= 1 << 10
    assert (interpret(design, codes, image)[0] != FixedTfra(design)(codes).words).any()


@pytest.mark.parametrize("design", DESIGNS.values(), ids=DESIGNS)
def test_every_coefficient_is_in_its_place_and_all_else_is_zero(design):
    image, start, lanes, q = store_image(design), bases(design), lane_count(design), design.quads
    for stack in STACKS:
        for op in design.stacks[stack].operators:
            for quad in range(op.quads):
                for parity in range(4):
                    row = start[op.name] + (parity * groups(design, op) + quad // lanes) * q
                    assert (image[row : row + q, quad % lanes] == op.rows[quad, parity]).all()
                    image[row : row + q, quad % lanes] = 0
    assert not image.any()


@pytest.mark.parametrize(("rows", "steps"), [(4, 1000), (20, 4)])
def test_designs_that_do_not_fit_are_refused(rows, steps):
    design = TfraDesign(SensorArray(rows, rows, 2e-3, 2e-3, 3e-3), search=Search(steps), architecture=SERIAL)
    with pytest.raises(ValueError, match=r"architecture.kind: the serial core holds 2048 words, more are needed"):
        program(design)
