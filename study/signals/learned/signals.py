"""Signals between the stages of the learned estimator: integers by name, and the weights of their LSBs."""

import numpy as np

from tfra.model.arrays import Floats, Ints
from tfra.model.fixed.learned.design import LearnedDesign
from tfra.model.fixed.learned.operators import outputs
from tfra.model.fixed.learned.pipeline import Stage, Trace
from tfra.model.fixed.widths import scalar_fraction

_STAGES = {
    Stage.NORMALISER: ("stress", "b"),
    Stage.ACTIVATION: ("h1", "h2", "p0"),
    Stage.TOTAL: ("outputs",),
    Stage.RESULTANT: ("force", "resultant", "uncertainty"),
    Stage.ANGLE: ("phi",),
    Stage.FRICTION: ("mu", "mu_x", "mu_y"),
    Stage.FIELD: ("p", "shear"),
    Stage.SHARE: ("total", "share", "forces"),
}

FOLDED = ("inverse", "p0", "shear_x", "shear_y")
"""Folded vectors over the array; others are over the units of a layer."""


def stage_of(signal: str) -> Stage:
    """The stage of ``signal``; signals of no other stage are products and their operands."""
    quantity = signal.partition(".")[0]
    return next((stage for stage, names in _STAGES.items() if quantity in names), Stage.MATVEC)


def words(design: LearnedDesign, trace: Trace) -> dict[str, Ints]:
    """The integers of every signal; those of vectors are folded, ``(n, quads, 4)``."""
    by_b, by_h1 = (
        design.stacks[name].split(results) for name, results in (("first", trace.first), ("second", trace.second))
    )
    found = {
        "stress": trace.frame.stress,
        "first": by_b["first"],
        "h1": trace.h1,
        "second": by_h1["second"],
        "h2": trace.h2,
        "outputs": outputs(trace.total),
        "resultant": trace.judged.words,
        "uncertainty": trace.judged.uncertainty,
        "phi": trace.turned.phi,
        **{name: getattr(trace.friction, name) for name in ("mu", "mu_x", "mu_y")},
    }
    if (at_taxels := trace.field) is not None:
        by_p0 = design.stacks["field"].split(at_taxels.sheared)
        found |= {"inverse": by_b["inverse"], "p0": at_taxels.p0, **by_p0}
        found |= {"p": at_taxels.p, "forces": at_taxels.forces}
    return found


def last_bits(design: LearnedDesign) -> dict[str, Floats]:
    """Weight of a signal's LSB where that is not 1.

    Stress is in converter codes of the normalised frame, vectors are on the vector grid; phi is in turns, results are
    in codes times a taxel's area.
    """
    fields_of = {f.name: np.array(2.0**-f.fraction) for f in design.layout}
    scalar = np.array(2.0 ** -scalar_fraction(design))
    results = ("resultant", "uncertainty", "forces", "phi")
    return {name: fields_of[name] for name in results if name in fields_of} | dict.fromkeys(
        ("mu", "mu_x", "mu_y"), scalar
    )
