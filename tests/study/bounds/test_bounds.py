"""Bounds on errors: never exceeded in exact fractions, and exceeded by one coefficient or rounding that is off."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from bench.exactness.designs import untrained
from tests.study.bounds.exact import candidate, offset
from tfra.model.choices import Adc, Architecture, Formats, Search
from tfra.model.cover.scenes import wild_codes
from tfra.model.fixed import cordic, matvec
from tfra.model.fixed.numbers import round_shift
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.rounding import Rounding
from tfra.model.sensor import SensorArray
from tfra.study.bounds.bounds import MARGIN, violations
from tfra.study.bounds.estimators import error_bounds

SENSORS = (
    SensorArray(2, 2, 4e-3, 2e-3, 3e-3),
    SensorArray(2, 3, 3e-3, 3.1e-3, 2e-3),
    SensorArray(3, 2, 2e-3, 5e-3, 4e-3),
)


@st.composite
def frames(draw):
    """A tiny design and a frame of codes."""
    sensor, bits = draw(st.sampled_from(SENSORS)), draw(st.integers(6, 10))
    formats = Formats(
        "any", draw(st.integers(8, 14)), draw(st.integers(10, 16)), draw(st.integers(0, 8)), draw(st.integers(0, 6)),
        rounding=draw(st.sampled_from(Rounding)),
    )  # fmt: skip
    adc, search = Adc(bits, contact_threshold=0), Search(draw(st.integers(1, 9)))
    design = TfraDesign(sensor, "tiny", adc=adc, search=search, formats=formats, architecture=Architecture(4))
    codes = st.integers(-(1 << (bits - 1)), (1 << (bits - 1)) - 1)
    return design, np.array(draw(st.lists(codes, min_size=sensor.taxels, max_size=sensor.taxels)))


@settings(deadline=None, max_examples=25)
@given(frames())
def test_no_error_from_fractions_exceeds_its_bound(drawn):
    design, codes = drawn
    bounds = error_bounds(design)
    trace = next(bounds.traces(codes[None]))
    assume(len(trace.codes))
    found, exact = bounds.bounds(trace), candidate(design, trace)
    words, lsb = bounds.inside.words(trace), bounds.inside.last_bits(trace)
    for name, values in exact.items():
        limit, word = found["before the decision", name][0], words[name].reshape(-1)
        value = [float(value) / float(np.ravel(lsb.get(name, 1.0))[0]) for value in values]
        most = max(map(abs, value))
        for one, other, most_off in zip(word, value, limit, strict=True):
            assert abs(one - other) <= most_off * (1 + MARGIN) + MARGIN * most
    if not trace.direction.vanishing[0]:
        x, y = offset(design, [int(code) for code in codes])
        turns = math.atan2(y, x) / (2 * math.pi) - trace.phi[0] / 2.0 ** design.formats.bits("cordic")
        assert abs((turns + 0.5) % 1 - 0.5) * 2.0 ** design.formats.bits("cordic") <= found["phi", "phi"][0, 0] + 1e-3


def exceeded(bounds, traces) -> int:
    """Errors in ``traces`` over the bounds."""
    count = 0
    for trace in traces:
        limits = bounds.bounds(trace)
        count += sum(violations(limits[key], *pair) for key, pair in bounds.errors(trace).items())
    return count


ESTIMATORS = ("tfra", "learned")
SHORT, LONG = Formats("short", 10, 16, 6, 4), Formats("long", 24, 24, 0, 4)
"""Coefficients decide the errors of one, the roundings of results those of the other."""


def designs(formats: Formats) -> list:
    choices = {"adc": Adc(10), "formats": formats, "architecture": Architecture(4)}
    tfra = TfraDesign(SensorArray(3, 4, 4e-3, 2e-3, 3e-3), "c", search=Search(8), **choices)
    return [tfra, untrained(3, 4, (3, 4), **choices)]


def off_by_one(design, sign: int):
    """``design`` with one coefficient that is one unit off, ahead of its own error."""
    name, stack = next(iter(design.stacks.items()))
    op, wrong = stack.operators[0], replace(design)
    rows = op.rows.copy()
    rows[0, 1, 0] += sign
    stacks = {name: replace(stack, operators=(replace(op, rows=rows), *stack.operators[1:]))}
    wrong.__dict__.update(stacks=design.stacks | stacks, widths=design.widths)
    return wrong


@pytest.mark.parametrize("design", designs(SHORT), ids=ESTIMATORS)
def test_a_coefficient_that_is_one_unit_off_exceeds_its_bound(design):
    bounds, codes = error_bounds(design), wild_codes(design, 200, 1)
    assert exceeded(bounds, bounds.traces(codes)) == 0
    assert any(exceeded(bounds, error_bounds(off_by_one(design, sign)).traces(codes)) > 0 for sign in (-1, 1))


@pytest.mark.parametrize("design", designs(LONG), ids=ESTIMATORS)
def test_results_rounded_down_instead_of_half_up_exceed_their_bound(design, monkeypatch):
    bounds, codes = error_bounds(design), wild_codes(design, 200, 1)
    assert exceeded(bounds, bounds.traces(codes)) == 0
    monkeypatch.setattr(matvec, "round_shift", lambda value, shift, _: round_shift(value, shift, Rounding.TRUNCATE))
    assert exceeded(bounds, bounds.traces(codes)) > 0


def test_a_cordic_without_its_last_rotations_exceeds_its_bound(monkeypatch):
    design, _ = designs(LONG)
    bounds, codes, table = error_bounds(design), wild_codes(design, 60, 1), cordic.angle_table(design)
    monkeypatch.setattr(cordic, "angle_table", lambda _: table[:-4] + [0] * 4)
    assert exceeded(bounds, bounds.traces(codes)) > 0
