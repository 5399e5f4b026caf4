"""The bit-accurate TFRA: the hardware's blocks in dataflow order."""

from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from tfra.model.arrays import Ints
from tfra.model.fixed.butterfly import butterfly, to_quads, to_taxels
from tfra.model.fixed.combine import combine
from tfra.model.fixed.cordic import cordic
from tfra.model.fixed.design import FixedModel
from tfra.model.fixed.gain import Gain, Resultant, gain
from tfra.model.fixed.matvec import matvec
from tfra.model.fixed.normaliser import Normalised, normaliser
from tfra.model.fixed.scaling import Scaled, scaling
from tfra.model.fixed.tfra.centroids import Direction, centroids
from tfra.model.fixed.tfra.dependent import Dependent, dependent, gather_sums
from tfra.model.fixed.tfra.forces import forces
from tfra.model.fixed.tfra.friction import Friction, friction
from tfra.model.fixed.tfra.resultant import resultant
from tfra.model.fixed.tfra.sweep import Sweep, sweep
from tfra.model.fixed.tfra.weights import weights
from tfra.model.fixed.words import encode
from tfra.model.tfra import Status


class Stage(StrEnum):
    """Names of the blocks in the model, in the gateware and in a report, in dataflow order."""

    NORMALISER = "normaliser"
    CENTROIDS = "centroids"
    MATVEC = "matvec"
    WEIGHTS = "weights"
    DEPENDENT = "dependent"
    COMBINE = "combine"
    SWEEP = "sweep"
    FRICTION = "friction"
    RESULTANT = "resultant"
    GAIN = "gain"
    FORCES = "forces"
    ANGLE = "angle"
    SCALING = "scaling"


@dataclass(frozen=True)
class Trace:
    """Results of every block for some frames, in dataflow order; vectors are folded, ``(n, Q, 4)``."""

    codes: Ints
    """Converter codes ``(n, m)``."""
    frame: Normalised
    direction: Direction
    stress: Ints
    """Normalised stress of taxels, as quads."""
    b: Ints
    contact: Ints
    n: Ints
    residual: Ints
    affine: Dependent
    e0: Ints
    e1: Ints
    normal: tuple[Ints, Ints]
    """C33 A3-dagger times e0, and times e1."""
    p: Ints
    """``(n, m)``, times four, as ``q``."""
    q: Ints
    swept: Sweep
    chosen: Friction
    d: Ints
    force: Ints
    planes: Ints
    """Unscaled forces ``(n, 3, m)``."""
    total: Resultant
    factor: Gain
    phi: Ints
    scaled: Scaled


class FixedTfra(FixedModel[Trace]):
    """Bit-accurate model of one design."""

    def _trace(self, codes: Ints) -> Trace:
        design = self.design
        frame = normaliser(design, codes)
        direction = centroids(design, codes)
        stress = to_quads(design, frame.stress)
        b = butterfly(stress) << design.formats.vector_fraction
        contact = matvec(design, "contact", b)
        by_b = design.stacks["contact"].split(contact)
        n = weights(by_b["c33_inv"], frame.regular)
        residual = matvec(design, "residual", n)
        by_n = design.stacks["residual"].split(residual)
        g, d1, d2 = (by_n[name] for name in ("c33", "c31", "c32"))
        affine = dependent(design, gather_sums(by_b["sums_b"], by_n["sums_n"]), direction, frame.regular)
        d_ind, d_dep = ordered(direction, d1, d2)
        e0 = combine(design, b + g, affine.alpha, d_dep)
        e1 = combine(design, d_ind, affine.beta, d_dep)
        normal = matvec(design, "normal", e0), matvec(design, "normal", e1)
        p, q = (to_taxels(design, butterfly(quads)) for quads in (normal[0] - g, normal[1]))
        swept = sweep(design, frame.stress, p, q, direction.negative, frame.exponent)
        chosen = friction(design, swept.index, direction, affine, frame.regular)
        d = combine(design, e0, chosen.mu_ind, e1)
        force = matvec(design, "force", d)
        planes = to_taxels(design, forces(design, force, chosen, n))
        total = resultant(design, affine, chosen, frame.regular)
        factor = gain(design, total, frame)
        guard = design.formats.bits("division") - design.formats.bits("direction")
        _, phi = cordic(design, direction.cos << guard, direction.sin << guard)
        scaled = scaling(design, frame, factor, planes, total)
        return Trace(
            codes, frame, direction, stress, b, contact, n, residual, affine, e0, e1, normal, p, q,
            swept, chosen, d, force, planes, total, factor, phi, scaled,
        )  # fmt: skip

    def _words(self, trace: Trace, first_frame: int) -> Ints:
        frame, chosen, scaled = trace.frame, trace.chosen, trace.scaled
        count = len(frame.exponent)
        return encode(
            self.design,
            {
                "frame": first_frame + np.arange(count),
                "exponent": frame.exponent,
                "sweep_index": chosen.index,
                "phi": np.where(frame.regular, trace.phi, 0),
                "mu": trace.factor.mu,
                "mu_x": chosen.mu_x,
                "mu_y": chosen.mu_y,
                "resultant": scaled.resultant,
                "forces": scaled.forces.reshape(count, 3 * self.design.sensor.taxels),
                "status": status(frame, trace.direction, trace.affine, chosen, scaled),
            },
        )

    def _stages(self, trace: Trace, words: Ints) -> dict[str, Ints]:
        """Output stream of every block: the frame first, the words of a transfer last."""
        direction, affine, chosen, factor = trace.direction, trace.affine, trace.chosen, trace.factor
        return {
            Stage.NORMALISER: trace.stress,
            Stage.CENTROIDS: np.stack([direction.cos, direction.sin], axis=1),
            Stage.MATVEC: np.concatenate([trace.contact, trace.residual, *trace.normal, trace.force], axis=1),
            Stage.WEIGHTS: trace.n,
            Stage.DEPENDENT: np.stack([affine.alpha, affine.beta], axis=1),
            Stage.COMBINE: np.concatenate([trace.e0, trace.e1, trace.d], axis=1),
            Stage.SWEEP: trace.swept.index[:, None],
            Stage.FRICTION: np.stack([chosen.mu_ind, chosen.mu_x, chosen.mu_y], axis=1),
            Stage.RESULTANT: trace.total.words,
            Stage.GAIN: np.stack([factor.mantissa, factor.mu], axis=1),
            Stage.FORCES: trace.planes.reshape(len(trace.planes), 3 * trace.planes.shape[2], 1),
            Stage.ANGLE: trace.phi[:, None],
            Stage.SCALING: words,
        }


def ordered(direction: Direction, d1: Ints, d2: Ints) -> tuple[Ints, Ints]:
    """The factors of mu_ind and of mu_dep: d1 and d2, or d2 and d1 where mu_y is swept."""
    swap = direction.sweep_y[:, None, None]
    return np.where(swap, d2, d1), np.where(swap, d1, d2)


def status(frame: Normalised, direction: Direction, affine: Dependent, chosen: Friction, scaled: Scaled) -> Ints:
    """Status bits of every frame, ``(n,)``."""
    bits = (
        np.where(frame.contact, 0, Status.NO_CONTACT)
        | np.where(frame.contact & ~frame.traction, Status.COMPRESSION_ONLY, 0)
        | np.where(frame.regular & direction.vanishing, Status.NO_DIRECTION, 0)
        | np.where(frame.regular & affine.vanishing, Status.VANISHING_DENOMINATOR, 0)
        | np.where(frame.regular & chosen.out_of_range, Status.DEPENDENT_OUT_OF_RANGE, 0)
        | np.where(frame.saturated, Status.INPUT_SATURATED, 0)
        | np.where(scaled.saturated, Status.OUTPUT_SATURATED, 0)
    )
    return np.asarray(bits, dtype=np.int64)
