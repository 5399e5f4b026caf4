"""What the stages of a frame leave in the memory is what the model's blocks hand on."""

from functools import cache

import numpy as np
import pytest

from tests.hdl.serial.designs import DESIGNS, LEARNED
from tests.hdl.serial.memories import memories, scalars, three, vector
from tfra.hdl.serial.program.learned import frame as learned_frame
from tfra.hdl.serial.program.learned.memory import LearnedMap
from tfra.hdl.serial.program.learned.words import status
from tfra.hdl.serial.program.routines import label
from tfra.hdl.serial.program.tfra import frame as tfra_frame
from tfra.hdl.serial.program.tfra.memory import TfraMap
from tfra.model.cover.scenes import contact_codes
from tfra.model.fixed.butterfly import butterfly

DESIGN = {"TFRA": DESIGNS["3×4"], "learned": LEARNED["5×7, forces"]}
CODES = {kind: contact_codes(design, 1, seed=6) for kind, design in DESIGN.items()}
STAGES = {
    "TFRA": (*tfra_frame.ANALYSIS, *tfra_frame.RESULT),
    "learned": (*learned_frame.ANALYSIS, *learned_frame.HEADER, *learned_frame.FORCES, status),
}
TFRA, NETWORK = TfraMap(DESIGN["TFRA"]), LearnedMap(DESIGN["learned"])
Q, LEARNED_Q = (design.quads for design in DESIGN.values())
C1, C2 = DESIGN["learned"].weights.counts


@cache
def memory(kind):
    """Words at the end of every stage."""
    return memories(DESIGN[kind], CODES[kind])


@cache
def blocks():
    """What each block of TFRA's model gives."""
    return {name: values[0] for name, values in DESIGN["TFRA"].model(CODES["TFRA"]).stages.items()}


@cache
def traced():
    """What each block of the learned estimator's model gives."""
    return next(iter(DESIGN["learned"].model.traces(CODES["learned"])))


def combined(part):
    return lambda: blocks()["combine"].reshape(-1, 4)[part * Q : (part + 1) * Q]


@pytest.mark.parametrize(
    ("kind", "stage", "start", "quads", "wanted"),
    [
        ("TFRA", "weights.weights", TFRA.result, Q, lambda: blocks()["weights"].reshape(-1, 4)),
        ("TFRA", "combine.residuals", TFRA.d, Q, combined(0)),
        ("TFRA", "combine.residuals", TFRA.independent, Q, combined(1)),
        ("TFRA", "combine.winner", TFRA.d, Q, combined(2)),
        ("learned", "layers.first", NETWORK.vector, C1, lambda: traced().h1[0]),
        ("learned", "layers.second", NETWORK.vector, C2, lambda: traced().h2[0]),
        ("learned", "layers.first", NETWORK.still, LEARNED_Q, lambda: traced().first[0, -LEARNED_Q:]),
    ],
)
def test_vectors(kind, stage, start, quads, wanted):
    assert (vector(memory(kind)[stage], start, quads) == wanted()).all()
    assert (vector(memory(kind)["normaliser.fold"], start, quads) != wanted()).any()


def test_the_folds():
    found = vector(memory("TFRA")["normaliser.fold"], TFRA.d, Q)
    fraction = DESIGN["TFRA"].formats.vector_fraction
    assert (found == butterfly(blocks()["normaliser"].reshape(-1, 4)) << fraction).all()
    found = vector(memory("learned")["normaliser.fold"], NETWORK.vector, LEARNED_Q)
    assert (found << traced().frame.exponent[0] == butterfly(traced().stress[0])).all()


def test_the_field():
    unfolded = np.maximum(butterfly(vector(memory("learned")["field.shear"], NETWORK.still, LEARNED_Q)), 0)
    p = memory("learned")["field.unfold"][NETWORK.p : NETWORK.p + DESIGN["learned"].sensor.taxels]
    assert p == traced().field.p[0].tolist()
    assert set(p) == set(unfolded.ravel().tolist())


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
def test_scalars_of_tfra(stage, names, block):
    assert scalars(DESIGN["TFRA"], memory("TFRA")[stage], *names) == blocks()[block].tolist()
    assert scalars(DESIGN["TFRA"], memory("TFRA")["reset"], *names) != blocks()[block].tolist()


@pytest.mark.parametrize(
    ("stage", "name", "wanted"),
    [
        ("normaliser.normaliser", "exponent", lambda: traced().frame.exponent[0]),
        ("layers.total", "uncertain", lambda: max(0, traced().total[0, 1, 0])),
        ("friction.angle", "phi", lambda: traced().turned.phi[0]),
        ("friction.angle", "modulus", lambda: traced().turned.modulus[0]),
        ("friction.friction", "mu", lambda: traced().friction.mu[0]),
        ("friction.friction", "mu_x", lambda: traced().friction.mu_x[0]),
        ("friction.friction", "mu_y", lambda: traced().friction.mu_y[0]),
        ("share.share", "force_shift", lambda: traced().field.share.shift[0]),
    ],
)
def test_scalars_of_the_learned_estimator(stage, name, wanted):
    assert scalars(DESIGN["learned"], memory("learned")[stage], name) == [wanted()]


@pytest.mark.parametrize(
    ("kind", "stage", "name", "wanted"),
    [
        ("TFRA", "resultant.resultant", "total", lambda: blocks()["resultant"]),
        ("learned", "layers.total", "force", lambda: traced().total[0, 0, [1, 2, 0]]),
        ("learned", "resultant.resultant", "total", lambda: traced().force.words[0]),
        ("learned", "share.share", "mantissa", lambda: traced().field.share.mantissa[0]),
    ],
)
def test_forces(kind, stage, name, wanted):
    assert three(DESIGN[kind], memory(kind)[stage], name) == wanted().tolist()
    assert three(DESIGN[kind], memory(kind)["reset"], name) != wanted().tolist()


@pytest.mark.parametrize("kind", DESIGN)
def test_stages_follow_each_other_as_in_the_table(kind):
    names = [label(stage) for stage in STAGES[kind]]
    assert list(memory(kind))[3:-1] == names[:-1]
    assert len(set(names)) == len(names)
