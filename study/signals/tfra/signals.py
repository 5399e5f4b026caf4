"""Signals between the stages of the bit-accurate model: integers by name, and the weights of their LSBs."""

import numpy as np

from tfra.model.arrays import Floats, Ints
from tfra.model.fixed.design import Design
from tfra.model.fixed.tfra.dependent import gather_sums
from tfra.model.fixed.tfra.pipeline import Stage, Trace
from tfra.model.fixed.widths import force_drop, scalar_fraction

_STAGES = {
    Stage.NORMALISER: ("stress", "b", "magnitude"),
    Stage.CENTROIDS: ("moment", "direction"),
    Stage.WEIGHTS: ("n",),
    Stage.DEPENDENT: ("sums", "quotient", "alpha", "beta"),
    Stage.COMBINE: ("d0", "d_dep", "e0", "e1", "d"),
    Stage.SWEEP: ("p", "q", "candidate", "b_z", "b_xy"),
    Stage.FRICTION: ("mu_ind", "mu_dep", "mu_x", "mu_y"),
    Stage.RESULTANT: ("f_star",),
    Stage.GAIN: ("gain", "mu"),
    Stage.FORCES: ("unscaled", "force", "planes"),
    Stage.ANGLE: ("phi",),
    Stage.SCALING: ("resultant", "forces"),
}

FOLDED = (
    "c33_inv", "n", "c33", "c31", "c32", "e0", "e1", "normal0", "normal1", "d", "pinv1", "pinv2", "pinv3",
)  # fmt: skip
"""Folded vectors over the array."""


def stage_of(signal: str) -> Stage:
    """The stage of ``signal``; signals of no other stage are products and their operands."""
    quantity = signal.partition(".")[0]
    if signal == "force.operand":
        return Stage.MATVEC
    return next((stage for stage, names in _STAGES.items() if quantity in names), Stage.MATVEC)


def words(design: Design, trace: Trace) -> dict[str, Ints]:
    """The integers of every signal; those of a frame's vectors are folded, ``(n, Q, 4)``."""
    by_b, by_n, by_d = (
        design.stacks[name].split(results)
        for name, results in (("contact", trace.contact), ("residual", trace.residual), ("force", trace.force))
    )
    sums_b, sums_n, affine, chosen = by_b["sums_b"], by_n["sums_n"], trace.affine, trace.chosen
    return {
        "stress": trace.frame.stress,
        "magnitude": trace.frame.magnitude,
        "direction": np.stack([trace.direction.cos, trace.direction.sin], axis=1),
        "c33_inv": by_b["c33_inv"],
        "sums_b": gather_sums(sums_b, 0 * sums_n)[:, :, 0],
        "n": trace.n,
        "sums_n": gather_sums(0 * sums_b, sums_n),
        **{name: by_n[name] for name in ("c33", "c31", "c32")},
        **{"sums": affine.sums, "alpha": affine.alpha, "beta": affine.beta},
        **{"e0": trace.e0, "e1": trace.e1, "normal0": trace.normal[0], "normal1": trace.normal[1]},
        **{"p": trace.p, "q": trace.q, "b_z": trace.swept.b_z, "b_xy": trace.swept.b_xy},
        **{"mu_ind": chosen.mu_ind, "mu_x": chosen.mu_x, "mu_y": chosen.mu_y},
        **{"d": trace.d, **by_d, "planes": trace.planes, "f_star": trace.total.words},
        **{"gain": trace.factor.mantissa, "mu": trace.factor.mu, "phi": trace.phi},
        **{"resultant": trace.scaled.resultant, "forces": trace.scaled.forces},
    }


def last_bits(design: Design, trace: Trace) -> dict[str, Floats]:
    """Weight of a signal's LSB where that is not 1; it has the signal's number of axes.

    Stress is in converter codes of the normalised frame, vectors are on the vector grid, p and q on a quarter of it;
    directions are unit vectors, phi is in turns, results are in codes times a taxel's area.
    """
    fields_of = {f.name: np.array(2.0**-f.fraction) for f in design.layout}
    drop, scalar = force_drop(design), np.array(2.0 ** -scalar_fraction(design))
    factor, total, affine = trace.factor, trace.total, trace.affine
    cos, sin = trace.direction.cos, trace.direction.sin
    shift = factor.force_shift - 2 + drop + design.formats.force_fraction
    return {
        "direction": 1 / np.hypot(cos, sin)[:, None],
        "sums": 2.0 ** (affine.significant - (design.formats.bits("sums") - 1))[:, None, None],
        **{name: scalar for name in ("alpha", "beta", "mu_ind")},
        **{name: fields_of[name] for name in ("mu_x", "mu_y", "mu", "phi", "resultant", "forces")},
        "planes": np.array(2.0**drop / 4),
        "f_star": 2.0 ** -total.exponent[:, None],
        "gain": 2.0**-shift,
    }
