"""The contact threshold: where it lies, what it changes, and that float and fixed agree on it to the code."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tfra.model.choices import Adc, Architecture, Formats, Search
from tfra.model.cover.scenes import directed_codes, wild_codes
from tfra.model.fixed.design import Design
from tfra.model.fixed.normaliser import normaliser
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.fixed.tfra.pipeline import FixedTfra
from tfra.model.fixed.words import field
from tfra.model.sensor import SensorArray
from tfra.model.tfra import Status, Tfra
from tfra.model.two_variable import TwoVariable

SENSOR = SensorArray(3, 4, 4e-3, 2e-3, 3e-3)
FORMATS = Formats("long", 20, 20, 9, 4)


def design(bits: int = 14, threshold: int | None = None, full_scale: float = 200e3) -> Design:
    adc = Adc(bits, full_scale, threshold)
    return TfraDesign(SENSOR, adc=adc, search=Search(10), formats=FORMATS, architecture=Architecture(4))


@pytest.mark.parametrize(
    ("bits", "codes"), [(6, 4), (8, 4), (9, 4), (10, 4), (11, 8), (12, 16), (14, 64), (16, 256), (20, 4096)]
)
def test_by_default_it_is_a_share_of_full_scale_but_some_codes(bits: int, codes: int) -> None:
    assert Adc(bits).threshold == codes
    assert replace(Adc(bits), contact_threshold=3).threshold == 3
    assert Adc(bits, contact_threshold=0).threshold == 0


@pytest.mark.parametrize("threshold", [0, 1, 4, 31])
def test_where_it_lies(threshold: int) -> None:
    """Both ends of no contact, one code beyond each, and a frame that nothing presses."""
    frames = np.zeros((4, 12), dtype=np.int64)
    frames[:, [2, 7]] = [-threshold, max(threshold - 1, 0)], [-threshold - 1, 0], [-1, threshold], [0, 31]
    facts = normaliser(design(6, threshold), frames)
    assert facts.contact.tolist() == [False, True, True, False]
    assert facts.regular.tolist() == [False, False, threshold > 0, False]


@settings(deadline=None)
@given(bits=st.integers(6, 20), data=st.data())
def test_it_is_the_folded_code_of_the_block_exponent(bits: int, data: st.DataObject) -> None:
    top = (1 << (bits - 1)) - 1
    threshold = data.draw(st.integers(0, top))
    near = st.integers(-threshold - 3, threshold + 3).map(lambda code: min(max(code, -top - 1), top))
    codes = data.draw(st.lists(st.one_of(near, st.integers(-top - 1, top)), min_size=12, max_size=12))
    largest = max(code if code >= 0 else -code - 1 for code in codes)
    facts = normaliser(design(bits, threshold), np.array([codes]))
    assert facts.contact[0] == (min(codes) < 0 and largest >= threshold)


@settings(max_examples=15, deadline=None)
@given(
    threshold=st.integers(0, 8191),
    full_scale=st.floats(1e-3, 1e9),
    seed=st.integers(0, 2**32),
    level=st.floats(0.3, 3),
)
def test_float_and_fixed_agree_on_every_code(threshold: int, full_scale: float, seed: int, level: float) -> None:
    made = design(14, threshold, full_scale)
    noise = np.random.default_rng(seed).normal(0, max(1.0, level * threshold / 2), (20, 3, 4))
    codes = np.concatenate([directed_codes(made)[-4:], np.clip(np.rint(noise), -8192, 8191).astype(np.int64)])
    found = field(made, FixedTfra(made)(codes).words, "status")[:, 0] & Status.NO_CONTACT
    stress = codes * made.adc.lsb
    assert (Tfra.of(made)(stress).status & Status.NO_CONTACT == found).all()
    assert threshold == 0 or found[:4].tolist() == [1, 1, 0, 0]


def test_the_other_method_agrees() -> None:
    made = design(10)
    codes = np.concatenate([directed_codes(made)[-4:], wild_codes(made, 30, 1)])
    found, expected = (kind.of(made)(codes * made.adc.lsb).status & Status.NO_CONTACT for kind in (TwoVariable, Tfra))
    assert (found == expected).all()
    assert 2 < found.sum() < 30


@settings(max_examples=15, deadline=None)
@given(threshold=st.integers(1, 8191), seed=st.integers(0, 2**32))
def test_below_all_is_zero_and_above_nothing_changes(threshold: int, seed: int) -> None:
    made, off = design(14, threshold), design(14, 0)
    codes = np.concatenate([directed_codes(made), wild_codes(made, 20, seed)])
    words, plain = FixedTfra(made)(codes).words, FixedTfra(off)(codes).words
    below = np.where(codes < 0, -codes - 1, codes).max(axis=(1, 2)) < threshold
    np.testing.assert_array_equal(words[~below], plain[~below])
    for name in (f.name for f in made.layout):
        seen, before = (field(made, w, name)[below] for w in (words, plain))
        if name in ("frame", "exponent"):
            np.testing.assert_array_equal(seen, before)
        else:
            assert (seen == (Status.NO_CONTACT if name == "status" else 0)).all(), name


@pytest.mark.parametrize("wrong", [-1, 1])
@pytest.mark.parametrize("threshold", [1, 4, 64, 8190])
def test_directed_frames_tell_a_threshold_from_its_neighbours(threshold: int, wrong: int) -> None:
    """Every verification and every generated testbench has these frames."""
    made, other = design(14, threshold), design(14, threshold + wrong)
    codes = directed_codes(made)[-4:]
    expected, seen = (field(d, FixedTfra(d)(codes).words, "status")[:, 0] & Status.NO_CONTACT for d in (made, other))
    assert expected.tolist() == [1, 1, 0, 0]
    assert seen.tolist() == ([0, 0, 0, 0] if wrong < 0 else [1, 1, 1, 1])
