"""The whole bit-accurate model against the float model, and its own symmetries."""

from dataclasses import replace

import numpy as np
import pytest

from tests.model.cases import make_design
from tfra.model.choices import Adc, Formats
from tfra.model.cover.scenes import SENSORS, contact_codes, directed_codes, wild_codes
from tfra.model.fixed.tfra.pipeline import FixedTfra
from tfra.model.fixed.words import decode, encode, field
from tfra.model.tfra import Status, Tfra

SWEPT = Status.NO_CONTACT | Status.COMPRESSION_ONLY | Status.NO_DIRECTION
ADDED = Status.INPUT_SATURATED | Status.OUTPUT_SATURATED


def both(design, codes):
    """Decoded fixed-point and float results of the same codes."""
    got = decode(design, FixedTfra(design)(codes).words)
    return got, Tfra.of(design)(codes * design.adc.lsb)


@pytest.mark.parametrize(("formats", "share"), [("standard", 0.97), ("wide", 0.995)])
@pytest.mark.parametrize("name", SENSORS)
def test_random_contacts(name, formats, share):
    design = make_design(SENSORS[name], formats)
    got, exact = both(design, contact_codes(design, 300, seed=17))
    assert (got.status == exact.status).all()
    swept = (exact.status & SWEPT) == 0
    step = np.abs(got.sweep_index - exact.sweep_index)
    assert swept.sum() > 150
    assert (step[swept] == 0).mean() >= share
    assert step.max() <= 1
    same = step == 0
    modulus = np.linalg.norm(exact.resultant, axis=1)
    assert (np.abs(got.forces - exact.forces).max(axis=(1, 2, 3)) <= 2e-3 * modulus)[same].all()
    assert (np.abs(got.resultant - exact.resultant).max(axis=1) <= 2e-3 * modulus)[same].all()
    turn = (got.phi_deg - exact.phi_deg + 180) % 360 - 180
    assert np.abs(turn).max() <= 0.02
    assert np.abs(got.mu - exact.mu)[same].max() < 1e-3
    sums = got.forces.sum(axis=(2, 3)) - got.resultant
    assert (np.abs(sums).max(axis=1) <= 2e-3 * modulus).all()


def test_directed_frames_have_the_float_models_status():
    for sensor in SENSORS.values():
        design = make_design(sensor)
        got, exact = both(design, directed_codes(design))
        assert (got.status & ~ADDED == exact.status).all()
    flags = np.bitwise_or.reduce(got.status)
    assert flags & Status.NO_CONTACT
    assert flags & Status.COMPRESSION_ONLY
    assert flags & Status.NO_DIRECTION
    assert flags & Status.INPUT_SATURATED


def test_noise_is_handled_like_any_frame():
    design = make_design(SENSORS["4×6, 5×3 mm, h 2 mm"])
    got, exact = both(design, wild_codes(design, 500, seed=3))
    clean = (exact.status & SWEPT == 0) & (got.status & Status.OUTPUT_SATURATED == 0)
    step = np.abs(got.sweep_index - exact.sweep_index)[clean]
    assert (step == 0).mean() > 0.97


def test_scaled_frames_give_the_same_words_with_another_exponent():
    design = make_design(SENSORS["4×6, 5×3 mm, h 2 mm"])
    codes = contact_codes(design, 50, seed=6) // 8
    small, large = (FixedTfra(design)(c).words for c in (codes, codes * 4))
    for f in design.layout:
        difference = field(design, small, f.name) - field(design, large, f.name)
        assert (difference == (2 if f.name == "exponent" else 0)).all()


def test_words_fit_their_fields_and_chunks_do_not_matter():
    design = make_design(SENSORS["4×6, 5×3 mm, h 2 mm"])
    codes = np.concatenate([wild_codes(design, 2100, seed=1), directed_codes(design)])
    words = FixedTfra(design)(codes).words
    assert words.shape == (len(codes), design.frame_words)
    for f in design.layout:
        column = field(design, words, f.name)
        low, high = (-(1 << (f.bits - 1)), (1 << (f.bits - 1)) - 1) if f.signed else (0, (1 << f.bits) - 1)
        assert column.min() >= low, f.name
        assert column.max() <= high, f.name
        assert f.bits + (not f.signed) <= design.word_bits
    assert (encode(design, {f.name: field(design, words, f.name) for f in design.layout}) == words).all()
    tail = FixedTfra(design)(codes[2090:], first_frame=2090).words
    assert (tail == words[2090:]).all()


def test_an_unsigned_field_that_is_the_longest_has_a_place_for_its_sign():
    formats = Formats("short", coefficient=18, operand=18, vector_fraction=4, force_fraction=0)
    design = replace(make_design(SENSORS["4×6, 5×3 mm, h 2 mm"]), adc=Adc(6), formats=formats)
    assert max(f.bits for f in design.layout) == 18
    assert design.word_bits == 19


def test_no_frames_give_no_words():
    design = make_design(SENSORS["4×6, 5×3 mm, h 2 mm"])
    words = FixedTfra(design)(np.empty((0, 4, 6), dtype=np.int64)).words
    assert words.shape == (0, design.frame_words)
    assert decode(design, words).forces.shape == (0, 3, 4, 6)
