"""The bit-accurate learned estimator: the hardware's blocks in dataflow order."""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from tfra.model.arrays import Bools, Ints
from tfra.model.fixed.butterfly import butterfly, to_quads
from tfra.model.fixed.design import Design, FixedModel
from tfra.model.fixed.gain import Resultant
from tfra.model.fixed.learned.activation import activation
from tfra.model.fixed.learned.field import field
from tfra.model.fixed.learned.friction import Angle, Friction, angle, friction
from tfra.model.fixed.learned.operators import outputs
from tfra.model.fixed.learned.resultant import Judged, judged, resultant
from tfra.model.fixed.learned.share import Share, share, shared
from tfra.model.fixed.matvec import matvec
from tfra.model.fixed.normaliser import Normalised, normaliser
from tfra.model.fixed.words import encode
from tfra.model.tfra import Status


class Stage(StrEnum):
    """Names of the blocks in the model, in the gateware and in a report, in dataflow order."""

    NORMALISER = "normaliser"
    MATVEC = "matvec"
    ACTIVATION = "activation"
    TOTAL = "total"
    RESULTANT = "resultant"
    ANGLE = "angle"
    FRICTION = "friction"
    FIELD = "field"
    SHARE = "share"
    WORDS = "words"


@dataclass(frozen=True)
class Field:
    """What the forces at the taxels take: ``p0`` folded ``(n, Q, 4)``, ``sheared`` the products of it, ``p (n, m)``,
    and ``forces (n, 3, m)`` in result words, ``limited (n,)`` where one was saturated."""

    p0: Ints
    sheared: Ints
    p: Ints
    share: Share
    forces: Ints
    limited: Bools


@dataclass(frozen=True)
class Trace:
    """Results of every block for some frames, in dataflow order; vectors are folded, ``(n, quads, 4)``."""

    codes: Ints
    """Converter codes ``(n, m)``."""
    frame: Normalised
    stress: Ints
    """Normalised stress of taxels, as quads."""
    first: Ints
    h1: Ints
    second: Ints
    h2: Ints
    read: Ints
    total: Ints
    """Two quads: sums of the three products' parts of the outputs."""
    force: Resultant
    judged: Judged
    turned: Angle
    friction: Friction
    field: Field | None


class FixedLearned(FixedModel[Trace]):
    """Bit-accurate model of one design; ``threshold`` is a word of :mod:`tfra.model.fixed.learned.resultant`."""

    def __init__(self, design: Design, threshold: int, taxel_forces: bool) -> None:
        super().__init__(design)
        self._threshold, self._taxel_forces = threshold, taxel_forces

    def _trace(self, codes: Ints) -> Trace:
        design = self.design
        frame = normaliser(design, codes)
        stress = to_quads(design, frame.stress)
        b = butterfly(stress) << design.formats.vector_fraction
        first = matvec(design, "first", b)
        by_b = design.stacks["first"].split(first)
        h1 = activation(by_b["first"])
        second = matvec(design, "second", h1)
        by_h1 = design.stacks["second"].split(second)
        h2 = activation(by_h1["second"])
        read = matvec(design, "read", h2)
        total = (by_b["direct"] + by_h1["read1"] + read) * frame.contact[:, None, None]
        results = outputs(total)
        force = resultant(design, results[:, :3])
        turned = angle(design, force)
        mu = friction(design, force, turned)
        at_taxels = self._field(by_b["inverse"], force, mu) if self._taxel_forces else None
        return Trace(
            codes, frame, stress, first, h1, second, h2, read, total,
            force, judged(design, results, self._threshold), turned, mu, at_taxels,
        )  # fmt: skip

    def _field(self, still: Ints, force: Resultant, mu: Friction) -> Field:
        design = self.design
        p0 = activation(still)
        sheared = matvec(design, "field", p0)
        by_axis = design.stacks["field"].split(sheared)
        p = field(design, still, (by_axis["shear_x"], by_axis["shear_y"]), mu)
        part = share(design, force, p)
        forces, limited = shared(design, part, p)
        return Field(p0, sheared, p, part, forces, limited)

    def _words(self, trace: Trace, first_frame: int) -> Ints:
        frame, mu, at_taxels = trace.frame, trace.friction, trace.field
        count = len(frame.exponent)
        values = {
            "frame": first_frame + np.arange(count),
            "exponent": frame.exponent,
            "phi": trace.turned.phi,
            "mu": mu.mu,
            "mu_x": mu.mu_x,
            "mu_y": mu.mu_y,
            "resultant": trace.judged.words,
            "uncertainty": trace.judged.uncertainty,
            "status": status(trace),
        }
        return encode(self.design, values | ({} if at_taxels is None else {"forces": at_taxels.forces}))

    def _stages(self, trace: Trace, words: Ints) -> Mapping[str, Ints]:
        """Output stream of every block: the frame first, the words of a transfer last."""
        mu, at_taxels = trace.friction, trace.field
        products, units = [trace.first, trace.second, trace.read], [trace.h1, trace.h2]
        of_forces: dict[str, Ints] = {}
        if at_taxels is not None:
            products, units = [*products, at_taxels.sheared], [trace.h1, at_taxels.p0, trace.h2]
            p = to_quads(self.design, at_taxels.p)
            of_forces = {Stage.FIELD: p, Stage.SHARE: at_taxels.share.mantissa[:, :, None]}
        return {
            Stage.NORMALISER: trace.stress,
            Stage.MATVEC: np.concatenate(products, axis=1),
            Stage.ACTIVATION: np.concatenate(units, axis=1),
            Stage.TOTAL: trace.total,
            Stage.RESULTANT: trace.force.words,
            Stage.ANGLE: trace.turned.phi[:, None],
            Stage.FRICTION: np.stack([mu.mu, mu.mu_x, mu.mu_y], axis=1),
            **of_forces,
            Stage.WORDS: words,
        }


def status(trace: Trace) -> Ints:
    """Status bits of every frame, ``(n,)``."""
    frame, judged, at_taxels = trace.frame, trace.judged, trace.field
    limited = judged.limited | trace.friction.overflow | (False if at_taxels is None else at_taxels.limited)
    bits = (
        np.where(frame.contact, 0, Status.NO_CONTACT)
        | np.where(frame.contact & trace.turned.still, Status.NO_DIRECTION, 0)
        | np.where(frame.contact & judged.implausible, Status.IMPLAUSIBLE, 0)
        | np.where(frame.saturated, Status.INPUT_SATURATED, 0)
        | np.where(limited, Status.OUTPUT_SATURATED, 0)
    )
    return np.asarray(bits, dtype=np.int64)
