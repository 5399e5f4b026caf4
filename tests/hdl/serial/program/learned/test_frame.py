"""The learned estimator's program in the interpreter: any weights, thresholds, corners, even shares."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.hdl.serial.designs import LEARNED, LEARNED_TEN
from tests.hdl.serial.interpreted import check, scenes
from tests.model.fixed.learned.cases import codes_of, learned_design
from tfra.hdl.cores import program
from tfra.model.choices import SERIAL, Adc, Formats
from tfra.model.cover.scenes import contact_codes
from tfra.model.tfra import Status

FORCES = LEARNED["2×3, forces"]


def test_the_scenes_have_many_statuses_in_each_design_and_every_one_in_all():
    statuses = [design.model(scenes(design, seed=1)).words[:, -1] for design in LEARNED.values()]
    many = Status.NO_CONTACT | Status.IMPLAUSIBLE | Status.INPUT_SATURATED
    assert all(np.bitwise_or.reduce(words) & many == many for words in statuses)
    seen = np.concatenate(statuses)
    assert np.bitwise_or.reduce(seen) == many | Status.NO_DIRECTION | Status.OUTPUT_SATURATED
    assert 0 in seen


@settings(deadline=None, max_examples=12)
@given(
    st.tuples(st.integers(2, 7), st.integers(2, 7)),
    st.tuples(st.integers(1, 14), st.integers(1, 9)),
    st.booleans(),
    st.integers(0, 2**32 - 1),
)
def test_any_array_any_weights(size, counts, taxel_forces, seed):
    design = learned_design(*size, counts, seed, architecture=SERIAL, taxel_forces=taxel_forces)
    check(design, codes_of(design, 4, seed))


@pytest.mark.parametrize(("outputs", "fraction"), [(1e-40, 6), (1e-12, 6), (1e-3, 0), (1e3, 0), (300, 6)])
def test_weights_of_any_size(outputs, fraction):
    """Sums that are shifted to the left, far to the right, or out of every word."""
    formats = Formats("other", 18, 18, fraction, 3)
    design = learned_design(3, 4, (4, 3), seed=2, architecture=SERIAL, formats=formats)
    size = {name: getattr(design.weights, name) * outputs for name in ("direct", "read1", "read2")}
    design = replace(design, weights=replace(design.weights, **size))
    check(design, codes_of(design, 12, seed=1))


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


def test_the_first_words_do_not_wait_for_the_forces():
    """Only the product for the field is before them."""
    whole, short = (program(replace(LEARNED_TEN, taxel_forces=forces)) for forces in (True, False))
    assert whole.first - short.first < 1000 < whole.last - short.last
