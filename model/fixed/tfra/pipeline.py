"""The bit-accurate TFRA: the hardware's blocks in the order data flows through them."""

from __future__ import annotations

import numpy as np

from tfra.model.arrays import Ints
from tfra.model.fixed.butterfly import butterfly, to_quads, to_taxels
from tfra.model.fixed.cordic import cordic
from tfra.model.fixed.design import Design
from tfra.model.fixed.gain import gain
from tfra.model.fixed.layout import COUNTER_BITS
from tfra.model.fixed.matvec import matvec
from tfra.model.fixed.normaliser import Normalised, normaliser
from tfra.model.fixed.result import FixedResult
from tfra.model.fixed.scaling import Scaled, scaling
from tfra.model.fixed.tfra.centroids import Direction, centroids
from tfra.model.fixed.tfra.combine import combine
from tfra.model.fixed.tfra.dependent import Dependent, dependent, gather_sums
from tfra.model.fixed.tfra.forces import forces
from tfra.model.fixed.tfra.friction import Friction, friction
from tfra.model.fixed.tfra.resultant import resultant
from tfra.model.fixed.tfra.stages import Stage
from tfra.model.fixed.tfra.sweep import sweep
from tfra.model.fixed.tfra.weights import weights
from tfra.model.fixed.words import encode
from tfra.model.tfra import Status

_CHUNK = 512  # frames at once: bounds memory, and keeps their vectors in a cache


class FixedTfra:
    """Bit-accurate model of one design."""

    def __init__(self, design: Design) -> None:
        self.design = design

    def __call__(self, codes: Ints, first_frame: int = 0) -> FixedResult:
        """Result words of converter ``codes (n, rows, columns)``; frames count from ``first_frame``."""
        flat = np.asarray(codes, dtype=np.int64).reshape(-1, self.design.sensor.taxels)
        parts = [
            self._chunk(flat[start : start + _CHUNK], first_frame + start)
            for start in range(0, max(1, len(flat)), _CHUNK)
        ]
        return FixedResult(np.concatenate([words for words, _ in parts]), tuple(stages for _, stages in parts))

    def _chunk(self, codes: Ints, first_frame: int) -> tuple[Ints, dict[str, Ints]]:
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
        normal = [matvec(design, "normal", e) for e in (e0, e1)]
        p, slope = (to_taxels(design, butterfly(quads)) for quads in (normal[0] - g, normal[1]))
        found = sweep(design, frame.stress, p, slope, direction.negative, frame.exponent)
        chosen = friction(design, found.index, direction, affine, frame.regular)
        d = combine(design, e0, chosen.mu_ind, e1)
        force = matvec(design, "force", d)
        unscaled = forces(design, force, chosen, n)
        total = resultant(design, affine, chosen, frame.regular)
        factor = gain(design, total, frame)
        planes = to_taxels(design, unscaled)
        scaled = scaling(design, frame, factor, planes, total)
        guard = design.formats.bits("division") - design.formats.bits("direction")
        _, phi = cordic(design, direction.cos << guard, direction.sin << guard)
        words = encode(
            design,
            {
                "frame": (first_frame + np.arange(len(codes))) % (1 << COUNTER_BITS),
                "exponent": frame.exponent,
                "sweep_index": chosen.index,
                "phi": np.where(frame.regular, phi, 0),
                "mu": factor.mu,
                "mu_x": chosen.mu_x,
                "mu_y": chosen.mu_y,
                "resultant": scaled.resultant,
                "forces": scaled.forces.reshape(len(codes), 3 * design.sensor.taxels),
                "status": status(frame, direction, affine, chosen, scaled),
            },
        )
        stages: dict[str, Ints] = {
            Stage.NORMALISER: stress,
            Stage.CENTROIDS: np.stack([direction.cos, direction.sin], axis=1),
            Stage.MATVEC: np.concatenate([contact, residual, *normal, force], axis=1),
            Stage.WEIGHTS: n,
            Stage.DEPENDENT: np.stack([affine.alpha, affine.beta], axis=1),
            Stage.COMBINE: np.concatenate([e0, e1, d], axis=1),
            Stage.SWEEP: found.index[:, None],
            Stage.FRICTION: np.stack([chosen.mu_ind, chosen.mu_x, chosen.mu_y], axis=1),
            Stage.RESULTANT: total.words,
            Stage.GAIN: np.stack([factor.mantissa, factor.mu], axis=1),
            Stage.FORCES: planes.reshape(len(codes), 3 * design.sensor.taxels, 1),
            Stage.ANGLE: phi[:, None],
            Stage.SCALING: words,
        }
        return words, stages


def ordered(direction: Direction, d1: Ints, d2: Ints) -> tuple[Ints, Ints]:
    """What mu_ind and what mu_dep multiplies: d1 and d2, or the other way round where mu_y is swept."""
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
