"""The whole bit-accurate learned estimator against the float one, and its own symmetries."""

from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.model.fixed.learned.cases import codes_of, learned_design
from tfra.codegen.config.weights import read_weights
from tfra.model.choices import Adc
from tfra.model.cover.scenes import contact_codes
from tfra.model.fixed.learned.design import LearnedDesign
from tfra.model.fixed.learned.resultant import resultant
from tfra.model.fixed.learned.share import even_word, share, shared
from tfra.model.fixed.words import decode, field
from tfra.model.learned.network import Learned
from tfra.model.sensor import SensorArray
from tfra.model.tfra import Result, Status

ADDED = Status.INPUT_SATURATED | Status.OUTPUT_SATURATED


def both(design: LearnedDesign, codes: np.ndarray) -> tuple[Result, Result]:
    """Decoded fixed-point and float results of the same codes."""
    exact = Learned(design.sensor, design.weights, design.threshold, design.adc.threshold * design.adc.lsb)
    return decode(design, design.model(codes).words), exact(codes * design.adc.lsb)


@settings(deadline=None, max_examples=40)
@given(st.integers(2, 6), st.integers(2, 6), st.integers(1, 6), st.integers(1, 4), st.integers(0, 2**32 - 1))
def test_any_array_any_weights(rows: int, columns: int, c1: int, c2: int, seed: int) -> None:
    design = learned_design(rows, columns, (c1, c2), seed)
    codes = codes_of(design, 60, seed)
    got, exact = both(design, codes)
    peak = design.sensor.taxel_area * design.adc.lsb * np.abs(codes).max(axis=(1, 2))
    size = np.linalg.norm(exact.resultant, axis=1) + peak
    assert (got.status & Status.OUTPUT_SATURATED == 0).mean() > 0.3
    clear = (np.abs(exact.resultant[:, 2]) > 0.05 * size) & (exact.status & Status.NO_CONTACT == 0) & (exact.mu < 3)
    assert (np.abs(got.mu - exact.mu)[clear] < 0.05).all()
    size[got.status & Status.OUTPUT_SATURATED != 0] = np.inf
    assert (np.abs(got.resultant - exact.resultant).max(axis=1) <= 1e-3 * size).all()
    assert got.uncertainty is not None
    assert exact.uncertainty is not None
    clear &= got.status & Status.OUTPUT_SATURATED == 0
    shares = [each.uncertainty_share[clear] for each in (got, exact)]
    np.testing.assert_allclose(*shares, rtol=0.05, atol=0.05)
    assert (np.abs(got.uncertainty - exact.uncertainty) <= 1e-3 * size).all()
    assert np.array_equal(got.status & Status.NO_CONTACT, exact.status & Status.NO_CONTACT)
    assert got.threshold == pytest.approx(design.threshold, abs=2**-9)


def test_the_example_is_as_exact_as_its_converter() -> None:
    sensor = SensorArray(10, 10, 4e-3, 2e-3, 3e-3)
    trained = read_weights(Path(__file__).parents[4] / "examples" / "hertz_40x20.weights.npz", sensor)
    design = LearnedDesign(sensor, adc=Adc(16, 100e3), weights=trained.weights, threshold=trained.threshold)
    got, exact = both(design, contact_codes(design, 400, seed=17))
    assert np.abs(got.mu - exact.mu).max() < 5e-4
    turn = np.abs((got.phi_deg - exact.phi_deg + 180) % 360 - 180)
    assert turn[exact.mu > 0.1].max() < 0.1
    modulus = np.linalg.norm(exact.resultant, axis=1)
    assert (np.linalg.norm(got.resultant - exact.resultant, axis=1) < 5e-4 * modulus).all()
    off = np.linalg.norm((got.forces - exact.forces).reshape(len(modulus), -1), axis=1)
    assert (off < 1e-3 * np.linalg.norm(exact.forces.reshape(len(modulus), -1), axis=1)).all()
    assert np.array_equal(got.status & ~ADDED, exact.status)
    assert (got.sweep_index == -1).all()


def test_a_core_without_forces_at_the_taxels_has_the_same_header() -> None:
    whole, short = learned_design(), learned_design(taxel_forces=False)
    codes = codes_of(whole, 100, seed=3)
    many, few = whole.model(codes).words, short.model(codes).words
    assert few.shape[1] == many.shape[1] - 60 == 11
    assert short.products == ("first", "second", "read")
    for name in ("frame", "exponent", "phi", "mu", "mu_x", "mu_y", "resultant", "uncertainty"):
        assert np.array_equal(field(whole, many, name), field(short, few, name)), name
    assert (decode(whole, many).resultant_alone, decode(short, few).resultant_alone) == (False, True)
    assert np.isnan(decode(short, few).forces).all()


@settings(deadline=None, max_examples=30)
@given(st.integers(0, 2**32 - 1))
def test_forces_are_exact_shares(seed: int) -> None:
    """Against fractions: F times p over the sum of p, within the mantissa and half an LSB."""
    design = learned_design(3, 4, (3, 2), seed)
    for trace in design.model.traces(codes_of(design, 20, seed)):
        assert trace.field is not None
        drop = design.formats.vector_fraction - design.formats.force_fraction
        for frame in range(20):
            p = trace.field.p[frame]
            if trace.field.share.even[frame]:
                p = np.full_like(p, even_word(design))
            outputs = trace.total[frame, 0]
            for axis, parity in enumerate((1, 2, 0)):
                whole = Fraction(int(outputs[parity]), 1 << drop)
                found = trace.field.forces[frame, axis]
                limit = 1 << (design.widths.output - 1)
                for taxel, word in enumerate(found):
                    exact = whole * Fraction(int(p[taxel]), int(p.sum()))
                    allowed = Fraction(1, 2) + max(abs(Fraction(int(x))) for x in outputs) / (1 << (drop + 15))
                    assert abs(max(-limit, min(limit - 1, exact)) - int(word)) <= allowed


@pytest.mark.parametrize("p", [0, 1])
def test_even_shares_where_hardly_anything_is_pressed(p: int) -> None:
    design = learned_design(8, 9, (30, 20), seed=1)
    outputs = np.array([[500, -300, -4 << 10]]) << (design.widths.vector - 15)
    found = share(design, resultant(design, outputs), np.full((1, 72), p))
    forces, _ = shared(design, found, np.full((1, 72), p))
    drop = design.formats.vector_fraction - design.formats.force_fraction
    assert found.even.all()
    assert found.shift >= 0
    limit = 1 << (design.widths.output - 1)
    exact = np.clip(outputs / 72 / 2**drop, -limit, limit - 1)[:, :, None]
    assert np.abs(forces - exact).max() <= 1 + 2.0 ** (design.widths.vector - 18 - drop) / 72
    assert not share(design, resultant(design, outputs), np.full((1, 72), 1 << (design.widths.force - 3))).even.any()


def test_the_threshold_is_compared_exactly() -> None:
    design = learned_design(seed=5)
    codes = codes_of(design, 400, seed=6)
    trace = next(iter(design.model.traces(codes)))
    uncertainty = np.maximum(trace.total[:, 1, 0], 0)
    for threshold in (0.1, 0.4, 1.0, 300.0):
        other = learned_design(seed=5, threshold=threshold)
        found = field(other, other.model(codes).words, "status")[:, 0] & Status.IMPLAUSIBLE != 0
        word = min(round(256 * threshold), 65535)
        expected = [
            contact and (z >= 0 or Fraction(int(u)) > Fraction(word, 256) * abs(int(z)))
            for contact, z, u in zip(trace.frame.contact, trace.total[:, 0, 0], uncertainty, strict=True)
        ]
        assert found.tolist() == expected
    assert 0 < found.sum() < found.size


def test_frames_come_in_chunks_and_none_at_all() -> None:
    design = learned_design()
    codes = np.concatenate([codes_of(design, 400, seed=7)] * 3)
    words = design.model(codes).words
    assert np.array_equal(words, design.model.words(codes))
    assert np.array_equal(words[600:, 1:], design.model(codes[600:]).words[:, 1:])
    assert words[-1, 0] == 1199
    assert design.model(codes[:0]).words.shape == (0, design.frame_words)


def test_weights_of_another_array_are_refused() -> None:
    design = learned_design()
    with pytest.raises(ValueError, match=r"estimator\.weights: are for 20 taxels, the sensor has 12"):
        replace(design, sensor=SensorArray(3, 4, 4e-3, 3e-3, 2.5e-3))
