"""The learned estimator's program, run by the interpreter, computes what the model does, in the cycles it states."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.hdl.serial.designs import LEARNED, LEARNED_TEN
from tests.hdl.serial.interpreted import check, interpret
from tests.marks import long
from tests.model.fixed.learned.cases import codes_of, made
from tfra.hdl.cores import program
from tfra.hdl.serial.program.memory import bases, groups, lengths, operators, store_image
from tfra.hdl.serial.sizes import lane_count
from tfra.model.choices import SERIAL, Adc, Formats
from tfra.model.cover.scenes import contact_codes, directed_codes, wild_codes
from tfra.model.tfra import Status

FORCES = LEARNED["2×3, forces"]


def scenes(design, seed):
    """Contacts, corners of the input, noise, and frames of all sizes, many of which pull."""
    parts = contact_codes(design, 2, seed), directed_codes(design), wild_codes(design, 3, seed)
    return np.concatenate([*parts, codes_of(design, 12, seed)])


@pytest.mark.parametrize("design", LEARNED.values(), ids=LEARNED)
def test_every_word_equals_the_model(design):
    codes = scenes(design, seed=1)
    check(design, codes)
    found = np.bitwise_or.reduce(design.model(codes).words[:, -1])
    assert found & Status.NO_CONTACT
    assert found & Status.IMPLAUSIBLE
    assert found & Status.INPUT_SATURATED


def test_the_scenes_have_every_status():
    found = {int(word) for d in LEARNED.values() for word in d.model(scenes(d, seed=1)).words[:, -1]}
    named = Status.NO_CONTACT | Status.NO_DIRECTION | Status.IMPLAUSIBLE
    assert np.bitwise_or.reduce(list(found)) == named | Status.INPUT_SATURATED | Status.OUTPUT_SATURATED
    assert 0 in found


@settings(deadline=None, max_examples=12)
@given(
    st.tuples(st.integers(2, 7), st.integers(2, 7)),
    st.tuples(st.integers(1, 14), st.integers(1, 9)),
    st.booleans(),
    st.integers(0, 2**32 - 1),
)
def test_any_array_any_weights(size, counts, taxel_forces, seed):
    design = made(*size, counts, seed, architecture=SERIAL, taxel_forces=taxel_forces)
    check(design, codes_of(design, 4, seed))


@pytest.mark.parametrize("seed", long(*range(40)))
def test_more_arrays(seed):
    rng = np.random.default_rng(seed)
    rows, columns, c1, c2 = (int(rng.integers(2, top)) for top in (12, 12, 60, 40))
    adc = Adc(int(rng.integers(6, 17)))
    design = made(rows, columns, (c1, c2), seed, architecture=SERIAL, adc=adc, taxel_forces=bool(seed % 2))
    check(design, codes_of(design, 8, seed))


@pytest.mark.parametrize(("outputs", "fraction"), [(1e-40, 6), (1e-12, 6), (1e-3, 0), (1e3, 0), (300, 6)])
def test_weights_of_any_size(outputs, fraction):
    """Sums that are shifted to the left, far to the right, or out of every word."""
    formats = Formats("other", 18, 18, fraction, 3)
    design = made(3, 4, (4, 3), seed=2, architecture=SERIAL, formats=formats)
    size = {name: getattr(design.weights, name) * outputs for name in ("direct", "read1", "read2")}
    design = replace(design, weights=replace(design.weights, **size))
    check(design, codes_of(design, 12, seed=1))


def near(design):
    """Frames on either side of the contact threshold, as they are and halved."""
    codes = directed_codes(design)[-4:]
    return np.concatenate([codes, codes // 2])


@pytest.mark.parametrize("threshold", [0, 1, 5, 1023, 2047])
def test_the_contact_threshold(threshold):
    design = replace(FORCES, adc=Adc(12, contact_threshold=threshold))
    check(design, near(design))


@pytest.mark.parametrize("wrong", [-1, 1])
def test_a_wrong_threshold_is_noticed(wrong):
    design, other = (replace(FORCES, adc=Adc(12, contact_threshold=t)) for t in (50, 50 + wrong))
    assert (interpret(other, near(design))[0] != design.model(near(design)).words).any()


@pytest.mark.parametrize("wrong", [-1, 1])
def test_a_wrong_limit_of_the_uncertainty_is_noticed(wrong):
    """At the threshold at which the frame is just plausible: 256 times the uncertainty over the normal force."""
    codes = contact_codes(FORCES, 1, seed=4)
    outputs = next(iter(FORCES.model.traces(codes))).total[0]
    limit = -(-(max(0, int(outputs[1, 0])) << 8) // abs(int(outputs[0, 0])))
    assert limit > 1
    design, other = (replace(FORCES, threshold=t / 256) for t in (limit, limit + wrong))
    check(design, codes)
    check(other, codes)
    assert (design.model(codes).words != other.model(codes).words).any() == (wrong < 0)


@pytest.mark.parametrize(
    "codes",
    [
        np.array([[0, -3, 0], [0, 0, 0]]),
        np.array([[-2048, -2048, -2048], [-2048, -2048, -2048]]),
        np.array([[-2048, 2047, -2048], [2047, -2048, 2047]]),
        np.array([[-1, 0, 0], [0, 0, 1]]),
    ],
)
def test_corners(codes):
    check(replace(FORCES, adc=Adc(12, contact_threshold=0)), codes[None])


def even_forces():
    """A design whose field vanishes: its inverse operator is zero, so every taxel gets the same share."""
    design = replace(FORCES)
    (first, *others) = design.stacks["first"].operators[::-1]
    none = replace(first, rows=np.zeros_like(first.rows))
    design.stacks["first"] = replace(design.stacks["first"], operators=(*others[::-1], none))
    return design


def test_even_shares():
    design, codes = even_forces(), contact_codes(FORCES, 2, seed=3)
    assert next(iter(design.model.traces(codes))).field.share.even.all()
    check(design, codes)


def test_ten_by_ten_equals_the_model_and_fits_a_small_fpga():
    """iCE40UP5K: 1024 instructions and 768 words; 2,000 frames/s at 29 MHz are 14,500 cycles a frame."""
    check(LEARNED_TEN, scenes(LEARNED_TEN, seed=2)[::12])
    code = program(LEARNED_TEN)
    assert lengths(LEARNED_TEN) == code.lengths == (25, 48, 24)
    assert len(code.instructions) <= 1024
    assert len(code.memory) <= 768
    assert code.operands <= 256
    assert len(store_image(LEARNED_TEN)) == 4 * (17 * 25 + 9 * 48 + 24)
    assert code.interval <= 14_500


def test_ten_by_ten_with_forces():
    design = replace(LEARNED_TEN, taxel_forces=True)
    check(design, scenes(design, seed=2)[::24])
    assert len(program(design).instructions) <= 1024


def test_the_first_words_do_not_wait_for_the_forces():
    """Only the product for the field is before them."""
    whole, short = (program(replace(LEARNED_TEN, taxel_forces=forces)) for forces in (True, False))
    assert whole.first - short.first < 1000 < whole.last - short.last


def test_a_wrong_coefficient_is_noticed():
    codes = contact_codes(FORCES, 1, seed=1)
    for start in bases(FORCES).values():
        image = store_image(FORCES)
        image[start, 0] ^= 1 << 14
        assert (interpret(FORCES, codes, image)[0] != FORCES.model(codes).words).any()


@pytest.mark.parametrize("design", LEARNED.values(), ids=LEARNED)
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
    ("size", "counts", "what"),
    [
        (20, (150, 20), "2048 words, more are needed"),
        (10, (250, 4), "2048 words, more are needed"),
        (4, (100, 160), "store holds 16384 words of coefficients, 23296"),
    ],
)
def test_designs_that_do_not_fit_are_refused(size, counts, what):
    design = made(size, size, counts, architecture=SERIAL)
    with pytest.raises(ValueError, match=f"^architecture.kind: the serial core.*{what}"):
        _ = program(design), store_image(design)
