"""Smoothing: heights of the model for any codes, a taxel a cycle."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from tests.hdl.skin.skins import skin_of
from tfra.hdl.skin.smoothing import Smoothing
from tfra.model.skin.smoothing import smoothing
from tfra.sim.harness import PATTERNS, flowing, run

CODES = st.integers(-2048, 2047) | st.sampled_from((-2048, 0, 2047))


@settings(max_examples=10)
@given(
    codes=st.tuples(st.integers(2, 5), st.integers(3, 6)).flatmap(lambda s: arrays(np.int64, (2, *s), elements=CODES)),
    stalls=st.sampled_from(PATTERNS),
)
def test_heights_are_those_of_the_model(codes, stalls):
    block = Smoothing(skin_of(*codes.shape[1:]))
    seen = run(block, {"i": codes.ravel().tolist()}, {"o": codes.size}, stall_in=stalls)
    assert seen.values["o"] == smoothing(codes).ravel().tolist()


@pytest.mark.parametrize("code", [-2048, 2047])
def test_ends_of_the_range_and_the_stated_latency(code):
    codes, block = np.full((2, 4, 5), code), Smoothing(skin_of(4, 5))
    seen = run(block, {"i": codes.ravel().tolist()}, {"o": codes.size}, stall_in=flowing)
    assert seen.values["o"] == smoothing(codes).ravel().tolist()
    assert seen.cycles["o"][-1] - seen.cycles["i"][-1] == block.latency
