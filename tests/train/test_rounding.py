"""Rounding in a forward pass: the words of the core, its results, and a gradient that passes straight."""

from dataclasses import replace

import numpy as np
import pytest

from tests.model.fixed.learned.cases import codes_of, learned_design
from tfra.model.choices import Formats
from tfra.model.fixed.learned import operators
from tfra.model.fixed.learned.design import LearnedDesign
from tfra.model.learned.network import NAMES, Folded
from tfra.train.network import Shape, estimates, loss_and_gradient
from tfra.train.rounding import Rounding

SIGNALS = (("coefficient.second", 7), ("operand.first", 9), ("operand.second", 8), ("operand.read", 7))
SHORT = Formats("short", coefficient=8, operand=12, vector_fraction=9, force_fraction=4, signals=SIGNALS)
LONG = Formats("long", coefficient=8, operand=27, vector_fraction=9, force_fraction=4)


def case(rows: int, columns: int, formats: Formats = SHORT) -> tuple[LearnedDesign, Rounding, Shape]:
    design = learned_design(rows, columns, (6, 5), seed=2, formats=formats, taxel_forces=False)
    return design, Rounding(design), Shape(design.sensor, (6, 5))


@pytest.mark.parametrize(("rows", "columns"), [(4, 4), (4, 5), (3, 5)])
def test_the_parameters_are_the_words_of_the_core(rows: int, columns: int) -> None:
    design, rounding, shape = case(rows, columns)
    found = dict(zip(NAMES, rounding.forward(shape.split(rounding.start)).parameters, strict=True))
    words = {op.name: op.rows / 2.0**op.fraction for stack in design.stacks.values() for op in stack.operators}
    for name in ("first", "second"):
        assert np.array_equal(found[name], np.moveaxis(words[name], 0, -1)), name
    for name in ("read2", "read1", "direct"):
        assert np.array_equal(operators.output_rows(found[name]), words[name]), name


@pytest.mark.parametrize(("rows", "columns"), [(4, 4), (4, 5), (3, 5)])
def test_the_outputs_are_those_of_the_core(rows: int, columns: int) -> None:
    """But for the grid of its vectors, which is finer by far than its words."""
    design, rounding, shape = case(rows, columns)
    codes = codes_of(design, 60, seed=3)
    codes = codes[np.abs(codes).max(axis=(1, 2)) > 100]
    (trace,) = design.model.traces(codes)
    grid = np.exp2(design.formats.vector_fraction + trace.frame.exponent)[:, None]
    core = operators.outputs(trace.total) / grid
    there = trace.frame.contact
    inputs = shape.folded(codes.reshape(len(codes), -1).astype(np.float32))
    parameters = shape.split(rounding.start)
    found = estimates(parameters, rounding.operand("first", inputs), rounding)
    other = np.abs(found - core)[there].max(axis=1)
    without = np.abs(estimates(parameters, inputs) - core)[there].max(axis=1)
    assert there.sum() > 20
    assert np.median(other) < 0.02 * np.median(without)
    assert other.max() < without.max() / 2


def test_the_gradient_is_that_of_the_rounded_network() -> None:
    _, rounding, shape = case(4, 5, LONG)
    rng = np.random.default_rng(4)
    n, forces = rng.normal(size=(9, 20)).astype(np.float32), rng.normal(size=(9, 3)).astype(np.float32)
    batch = shape.folded(n), forces, np.ones((9, 1), np.float32)
    vector = shape.split(rounding.start)
    rounded, scale = rounding.forward(vector)
    same = Folded(*(part / each for part, each in zip(rounded, scale, strict=True)))
    assert not np.allclose(same.first, vector.first, rtol=1e-3)
    assert np.abs(same.first - vector.first).max() < 0.05 * np.abs(vector.first).max()
    loss, gradient = loss_and_gradient(vector, *batch, rounding)
    expected, parts = loss_and_gradient(same, *batch)
    assert loss == pytest.approx(expected, rel=1e-4)
    for found, part in zip(gradient, parts, strict=True):
        np.testing.assert_allclose(found, part, rtol=1e-3, atol=1e-4 * np.abs(part).max())


def test_facts_tell_word_lengths_and_weights_apart() -> None:
    design, rounding, _ = case(4, 5)
    assert rounding.facts["coefficient.second"] == 7
    assert rounding.facts["coefficient.first"] == 8
    assert rounding.facts["operand.read"] == 7
    others = (
        replace(design, formats=LONG),
        replace(design, weights=replace(design.weights, direct=design.weights.direct + 1)),
    )
    assert all(Rounding(other).facts != rounding.facts for other in others)
