"""What the stages of a frame leave in the memory is what the model's blocks hand on."""

from __future__ import annotations

import pytest

from tests.hdl.serial.designs import DESIGNS
from tests.hdl.serial.memories import memories, scalars, three, vector
from tfra.hdl.serial.program.routines import label
from tfra.hdl.serial.program.tfra.frame import ANALYSIS, RESULT
from tfra.hdl.serial.program.tfra.memory import TfraMap
from tfra.model.cover.scenes import contact_codes
from tfra.model.fixed.butterfly import butterfly
from tfra.model.fixed.tfra.pipeline import FixedTfra

DESIGN = DESIGNS["3×4"]
CODES = contact_codes(DESIGN, 1, seed=6)
MAP = TfraMap(DESIGN)
Q = DESIGN.quads


@pytest.fixture(scope="module", name="memories")
def memories_of_the_frame():
    return memories(DESIGN, CODES)


@pytest.fixture(scope="module")
def model():
    return {name: values[0] for name, values in FixedTfra(DESIGN)(CODES).stages.items()}


@pytest.mark.parametrize(
    ("stage", "start", "block", "quads"),
    [
        ("weights.weights", MAP.result, "weights", slice(None)),
        ("combine.residuals", MAP.d, "combine", slice(0, Q)),
        ("combine.residuals", MAP.independent, "combine", slice(Q, 2 * Q)),
        ("combine.winner", MAP.d, "combine", slice(2 * Q, 3 * Q)),
    ],
)
def test_vectors(memories, model, stage, start, block, quads):
    want = model[block].reshape(-1, 4)[quads]
    assert (vector(memories[stage], start, Q) == want).all()
    assert (vector(memories["normaliser.fold"], start, Q) != want).any()


def test_the_fold(memories, model):
    want = butterfly(model["normaliser"].reshape(-1, 4)) << DESIGN.formats.vector_fraction
    assert (vector(memories["normaliser.fold"], MAP.d, Q) == want).all()


@pytest.mark.parametrize(
    ("stage", "names", "block"),
    [
        ("centroids.direction", ("cos", "sin"), "centroids"),
        ("dependent.dependent", ("alpha", "beta"), "dependent"),
        ("friction.friction", ("sweep_index",), "sweep"),
        ("friction.dependent_friction", ("mu_ind", "mu_x", "mu_y"), "friction"),
        ("gain.mu", ("normal_factor", "mu"), "gain"),
    ],
)
def test_scalars(memories, model, stage, names, block):
    assert scalars(DESIGN, memories[stage], *names) == model[block].tolist()
    assert scalars(DESIGN, memories["reset"], *names) != model[block].tolist()


def test_the_resultant(memories, model):
    assert three(DESIGN, memories["resultant.resultant"], "total") == model["resultant"].tolist()


def test_stages_follow_each_other_as_in_the_table(memories):
    names = [label(stage) for stage in (*ANALYSIS, *RESULT)]
    assert list(memories)[3:-1] == names[:-1]
    assert len(set(names)) == len(names)
