"""Limits of friction, shares and plausibility, by a network whose outputs are plain sums over four taxels."""

from dataclasses import replace

import numpy as np
import pytest

from tests.hdl.serial.interpreted import check
from tests.model.fixed.learned.cases import learned_design
from tfra.model.choices import SERIAL, Adc, Formats
from tfra.model.fixed.words import field
from tfra.model.learned.network import Weights
from tfra.model.tfra import Status

BITS = 12


def sums(inverse: int = 1, factor: float = 1.0, **choices):
    """2×2 taxels: F_x, F_y and F_z are a quarter of sums with signs, the uncertainty is -F_z / 4.

    ``inverse`` multiplies p, ``factor`` F_x.
    """
    direct = np.array([[1, -1, 1, -1], [1, 1, -1, -1], [1, 1, 1, 1], [-0.25] * 4]) / 4
    direct[0] *= factor
    given = {"adc": Adc(BITS, contact_threshold=0), "formats": Formats("sums", 16, BITS, 6, 3), "threshold": 0.25}
    design = learned_design(2, 2, (1, 1), architecture=SERIAL, **given | choices)
    weights = Weights(np.zeros((1, 4)), np.zeros((4, 1, 1)), np.zeros((4, 1)), np.zeros((4, 1)), direct)
    design = replace(design, weights=weights)
    first = design.stacks["first"]
    *others, last = first.operators
    design.stacks["first"] = replace(first, operators=(*others, replace(last, rows=last.rows * inverse)))
    return design


def scaled(design, factors):
    """The same with the rows of its direct weights times ``factors``."""
    direct = design.weights.direct * np.array(factors)[:, None]
    return replace(design, weights=replace(design.weights, direct=direct))


def implausible(design, codes):
    """Whether each of the frames is, once all words are checked."""
    check(design, codes)
    return (field(design, design.model(codes).words, "status")[:, 0] & Status.IMPLAUSIBLE != 0).tolist()


def frames(resultants):
    """Codes whose sums are four times ``resultants (n, 3)``."""
    x, y, z = np.array(resultants).T[:, :, None, None]
    return z + x * np.array([[1, -1], [1, -1]]) + y * np.array([[1, 1], [-1, -1]])


RATIOS = [
    (x, y, -z)
    for z in (0, 1, 255)
    for x in (0, 1, -1, 2 * z, -2 * z - 1, 3 * z, 4 * z - 1, 4 * z, 4 * z + 1)
    for y in (0, z, -3, 3 * z, -4 * z)
    if abs(x) + abs(y) + z < 1 << (BITS - 1)
]
"""Ratios on either side of 2 and 4, of all signs, and of a force with none."""

TWISTED = np.array([[500, -500], [-500, 500]])
"""A contact without force."""


def test_friction_at_its_limits():
    """2 limits the friction of the field, 4 the words; a pulling frame and one without any force have no limit."""
    design, codes = sums(), np.concatenate([frames([*RATIOS, (300, 200, 150)]), TWISTED[None]])
    check(design, codes)
    words = design.model(codes).words
    top = (1 << (BITS - 1)) - 1
    for name in ("mu", "mu_x", "mu_y"):
        assert {0, top} <= set(np.abs(field(design, words, name)).ravel().tolist())
    trace = next(iter(design.model.traces(codes)))
    longer = trace.judged.limited | trace.field.limited
    assert {(False, False), (False, True)} == set(zip(longer.tolist(), trace.friction.overflow.tolist(), strict=True))


def test_a_ratio_that_is_rounded_to_its_limit():
    """4 - 2^-11 is not over the limit, but no scalar of 12 bits has it."""
    design, codes = sums(factor=4 - 2.0**-11), frames([(200, 0, -200), (-200, 0, -200)])
    check(design, codes)
    assert field(design, design.model(codes).words, "mu_x").tolist() == [[2047], [-2047]]
    x, _, z = np.abs(next(iter(design.model.traces(codes))).force.words).T
    assert (x < 4 * z).all()


@pytest.mark.parametrize(("threshold", "over"), [(64, False), (63, True)])
def test_an_uncertainty_at_the_threshold(threshold, over):
    """4 times the uncertainty is the normal force exactly; a frame that neither presses nor pulls is implausible."""
    codes = frames([(3, 5, -7), (-1, 2, -1000), (5, 0, 0)])
    assert implausible(sums(threshold=threshold / 256), codes) == [over, over, True]


@pytest.mark.parametrize(
    ("threshold", "uncertainty", "over"),
    [(0, 0, False), (0, 1, True), (255 / 256, 1, True), (1, 1, False), (257 / 256, 1, False), (1, 2, True)],
)
def test_the_least_force_that_presses(threshold, uncertainty, over):
    """F_z is -1 on the vector grid, beside a large F_x; at the threshold all bits of what is compared are ones."""
    design = scaled(sums(threshold=threshold), [1, 1, 1 / 256, uncertainty / 64])
    codes = frames([(1500, 0, -1)])
    assert implausible(design, codes) == [over]
    assert next(iter(design.model.traces(codes))).total[0, :, 0].tolist() == [-1, uncertainty]


@pytest.mark.parametrize(("threshold", "over"), [(0, True), (1 / 256, True), (1, False), (200, False)])
def test_words_hold_outputs_that_are_larger_than_all_else(threshold, over):
    """The uncertainty is as large as F_z; it is moved, and F_z is multiplied, before they are compared."""
    design = scaled(sums(threshold=threshold, formats=Formats("sums", 16, BITS, 0, 3)), [1 << 12] * 3 + [1 << 14])
    assert implausible(design, frames([(0, 0, -2048), (3, -5, -2000)])) == [over, over]


@pytest.mark.parametrize("inverse", [0, 1])
def test_shares(inverse):
    """With p = 0 everywhere shares are even: four taxels have a power of two, which the last frame almost has, too."""
    design, codes = sums(inverse), frames([(0, 0, -5), (100, 20, -300)])
    codes = np.concatenate([codes, TWISTED[None] - 1, [[[-2048, -2048], [-2048, -2047]]]])
    assert next(iter(design.model.traces(codes))).field.share.even.all() == (inverse == 0)
    check(design, codes)


def test_shares_of_hardly_anything():
    """p is not zero, but its sum is too short."""
    design = sums()
    first = design.stacks["first"]
    *others, last = first.operators
    found = []
    for less in range(0, 30, 3):
        operators = (*others, replace(last, fraction=last.fraction + less))
        design.stacks["first"] = replace(first, operators=operators)
        codes = frames([(20, 10, -900), (0, 0, -2000)])
        check(design, codes)
        at_taxels = next(iter(design.model.traces(codes))).field
        found += zip(at_taxels.share.even.tolist(), (at_taxels.p.sum(axis=1) > 0).tolist(), strict=True)
    assert {(False, True), (True, True), (True, False)} == set(found)
