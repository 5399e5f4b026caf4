"""Word lengths: no word of any frame is longer than proven, and the proofs are not far off."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.model.fixed.learned.cases import codes_of, learned_design
from tfra.model.choices import Adc, Formats
from tfra.model.fixed.learned.bounds import bounds, total_bits
from tfra.model.fixed.learned.design import LearnedDesign
from tfra.model.fixed.learned.operators import unit_gain
from tfra.model.fixed.numbers import signed_bits


def wild(design: LearnedDesign, count: int, seed: int) -> np.ndarray:
    """Codes at the ends of their range, with signs at random or those of an operator's rows."""
    top, rng = 1 << (design.adc.bits - 1), np.random.default_rng(seed)
    shape = (count, design.sensor.rows, design.sensor.columns)
    return np.where(rng.random(shape) < rng.random((count, 1, 1)), -top, top - 1)


@settings(deadline=None, max_examples=40)
@given(st.integers(2, 6), st.integers(2, 6), st.integers(1, 5), st.integers(1, 4), st.integers(0, 2**32 - 1))
def test_words_hold(rows: int, columns: int, c1: int, c2: int, seed: int) -> None:
    design = learned_design(rows, columns, (c1, c2), seed)
    codes = np.concatenate([wild(design, 60, seed), codes_of(design, 60, seed)])
    most, widths = bounds(design, design.stacks), design.widths
    for trace in design.model.traces(codes):
        assert trace.field is not None
        for vector in (trace.first, trace.h1, trace.second, trace.h2, trace.read, trace.total, trace.field.p0):
            assert signed_bits(max(vector.max(), ~vector.min())) <= widths.vector
        assert trace.h1.max() <= 4 * most["h1"]
        assert trace.h2.max() <= 4 * most["h2"]
        assert trace.field.p0.max() <= 4 * most["p0"]
        assert trace.field.p.max() <= most["p"] < 2 ** (widths.force - 1)
        assert int(trace.field.p.sum(axis=1).max()).bit_length() <= total_bits(design, widths)
        assert (trace.field.share.shift >= 0).all()
        assert (np.abs(trace.field.share.mantissa) < 2 ** (design.formats.bits("scalar") - 1)).all()


@pytest.mark.parametrize(("size", "spare"), [(1e-4, 2), (1e4, 4)])
def test_words_hold_whatever_is_the_longest(size: float, spare: int) -> None:
    """Units, or outputs, whose bound takes all parities of a vector to be at their largest at a time."""
    design = learned_design(4, 4, (3, 2), seed=3)
    for name in ("direct", "read1", "read2"):
        getattr(design.weights, name)[:] *= size
    signs = [np.sign(weights).reshape(-1, 4, 4) for weights in (design.weights.first, design.weights.direct)]
    codes = np.where(np.concatenate(signs) < 0, -2048, 2047)
    trace, bits = next(iter(design.model.traces(codes))), design.widths.vector
    assert trace.field is not None
    vectors = {"h1": trace.h1, "h2": trace.h2, "p0": trace.field.p0, "total": trace.total}
    longest = {name: signed_bits(max(vector.max(), ~vector.min())) for name, vector in vectors.items()}
    assert bits - spare <= max(longest.values()) <= bits
    assert (longest["total"] == max(longest.values())) == (size > 1)


def test_the_first_layer_reaches_its_bound() -> None:
    """Codes with the signs of a unit's weights: the bound allows for roundings alone."""
    design = learned_design(4, 4, (3, 2), seed=3)
    signs = np.sign(design.weights.first).reshape(-1, 4, 4)
    codes = np.where(signs < 0, -2048, 2047)
    h1 = next(iter(design.model.traces(codes))).h1
    assert h1.max() > 0.98 * bounds(design, design.stacks)["h1"]


@given(st.integers(-40, 40))
@settings(deadline=None, max_examples=20)
def test_units_have_one_size_whatever_the_weights_are(exponent: int) -> None:
    """Larger weights of a layer and smaller ones behind it are the same network, and the same words."""
    design, other = learned_design(seed=4), learned_design(seed=4)
    other.weights.first[:] *= 2.0**exponent
    other.weights.read1[:] /= 2.0**exponent
    other.weights.second[:] /= 2.0**exponent
    codes = codes_of(design, 30, seed=1)
    assert np.array_equal(design.model(codes).words, other.model(codes).words)


@pytest.mark.parametrize("bits", [6, 8, 10])
def test_units_fill_short_words(bits: int) -> None:
    """The largest coefficient of each unit of a layer is the largest that its operator may have."""
    formats = Formats("short", coefficient=bits, operand=18, vector_fraction=9, force_fraction=4)
    design = learned_design(6, 6, (5, 4), seed=4, formats=formats)
    for stack in ("first", "second"):
        largest = np.abs(design.stacks[stack].operators[0].rows).max(axis=(1, 2))
        most = (1 << (bits - 1)) - 2
        assert (np.abs(largest - most) <= 1).all()  # the running sum moves a coefficient by one


def test_units_of_long_words_have_one_range() -> None:
    design = learned_design(6, 6, (5, 4), seed=4)
    first, second = (gains(design, stack) for stack in ("first", "second"))
    assert first == pytest.approx(8.0, rel=1e-3)
    assert second == pytest.approx(1.0, rel=1e-3)


def gains(design: LearnedDesign, stack: str) -> np.ndarray:
    """Largest magnitude of each unit of a layer for operands up to one."""
    op = design.stacks[stack].operators[0]
    return unit_gain(op.rows) / 2.0**op.fraction


def test_weights_of_zero() -> None:
    design = learned_design(seed=4)
    for name in ("first", "second", "read2", "read1", "direct"):
        getattr(design.weights, name)[:] = 0.0
    words = design.model(codes_of(design, 20, seed=1))
    assert not words.stages["total"].any()


def test_formats_that_are_too_long() -> None:
    formats = Formats("custom", coefficient=27, operand=27, vector_fraction=16, force_fraction=0)
    with pytest.raises(ValueError, match=r"formats: \w+ can overflow: \d+ bits are needed, 63 are supported"):
        _ = learned_design(9, 9, (40, 20), seed=1, formats=formats, adc=Adc(bits=20)).widths


def test_signals_have_names() -> None:
    formats = Formats("custom", 18, 18, 9, 4, signals=(("coefficient.frist", 12),))
    with pytest.raises(ValueError, match=r"coefficient\.frist: unknown signal, the nearest is coefficient\.first"):
        learned_design(formats=formats)
    short = Formats("custom", 18, 18, 9, 4, signals=(("coefficient.first", 12), ("operand.second", 14)))
    design, plain = learned_design(formats=short), learned_design()
    codes = codes_of(plain, 50, seed=2)
    near = np.abs(design.model(codes).stages["total"] - plain.model(codes).stages["total"])
    assert 0 < near.max() < 0.02 * np.abs(plain.model(codes).stages["total"]).max()
