"""What the stages of a frame leave in the memory is what the model's blocks hand on."""

from __future__ import annotations

import numpy as np
import pytest

from tests.hdl.serial.designs import LEARNED
from tests.hdl.serial.memories import memories, scalars, three, vector
from tfra.hdl.serial.program.learned.frame import ANALYSIS, FORCES, HEADER
from tfra.hdl.serial.program.learned.memory import LearnedMap
from tfra.hdl.serial.program.learned.words import status
from tfra.hdl.serial.program.routines import label
from tfra.model.cover.scenes import contact_codes
from tfra.model.fixed.butterfly import butterfly

DESIGN = LEARNED["5×7, forces"]
CODES = contact_codes(DESIGN, 1, seed=6)
MAP = LearnedMap(DESIGN)
Q, (C1, C2) = DESIGN.quads, DESIGN.weights.counts


@pytest.fixture(scope="module", name="memories")
def memories_of_the_frame():
    return memories(DESIGN, CODES)


@pytest.fixture(scope="module")
def traced():
    return next(iter(DESIGN.model.traces(CODES)))


def test_the_fold(memories, traced):
    found = vector(memories["normaliser.fold"], MAP.vector, Q)
    assert (found << traced.frame.exponent[0] == butterfly(traced.stress[0])).all()


@pytest.mark.parametrize(("stage", "quads", "block"), [("layers.first", C1, "h1"), ("layers.second", C2, "h2")])
def test_units(memories, traced, stage, quads, block):
    assert (vector(memories[stage], MAP.vector, quads) == getattr(traced, block)[0]).all()
    assert (vector(memories["normaliser.fold"], MAP.vector, quads) != getattr(traced, block)[0]).any()


def test_the_field(memories, traced):
    still = traced.first[0, -Q:]
    assert (vector(memories["layers.first"], MAP.still, Q) == still).all()
    unfolded = np.maximum(butterfly(vector(memories["field.shear"], MAP.still, Q)), 0)
    p = memories["field.unfold"][MAP.p : MAP.p + DESIGN.sensor.taxels]
    assert p == traced.field.p[0].tolist()
    assert set(p) == set(unfolded.ravel().tolist())


@pytest.mark.parametrize(
    ("stage", "name", "words"),
    [
        ("layers.total", "force", lambda traced: [int(traced.total[0, 0, parity]) for parity in (1, 2, 0)]),
        ("resultant.resultant", "total", lambda traced: traced.force.words[0].tolist()),
        ("share.share", "mantissa", lambda traced: traced.field.share.mantissa[0].tolist()),
    ],
)
def test_three_words(memories, traced, stage, name, words):
    assert three(DESIGN, memories[stage], name) == words(traced)
    assert three(DESIGN, memories["reset"], name) != words(traced)


@pytest.mark.parametrize(
    ("stage", "name", "word"),
    [
        ("normaliser.normaliser", "exponent", lambda traced: traced.frame.exponent[0]),
        ("layers.total", "uncertain", lambda traced: max(0, traced.total[0, 1, 0])),
        ("friction.angle", "phi", lambda traced: traced.turned.phi[0]),
        ("friction.angle", "modulus", lambda traced: traced.turned.modulus[0]),
        ("friction.friction", "mu", lambda traced: traced.friction.mu[0]),
        ("friction.friction", "mu_x", lambda traced: traced.friction.mu_x[0]),
        ("friction.friction", "mu_y", lambda traced: traced.friction.mu_y[0]),
        ("share.share", "force_shift", lambda traced: traced.field.share.shift[0]),
    ],
)
def test_scalars(memories, traced, stage, name, word):
    assert scalars(DESIGN, memories[stage], name) == [word(traced)]


def test_stages_follow_each_other_as_in_the_table(memories):
    names = [label(stage) for stage in (*ANALYSIS, *HEADER, *FORCES, status)]
    assert list(memories)[3:-1] == names[:-1]
    assert len(set(names)) == len(names)
