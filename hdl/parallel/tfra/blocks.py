"""Every block of the core."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields
from typing import Any

from tfra.hdl.lib.butterfly import Butterfly
from tfra.hdl.parallel.angle import Angle
from tfra.hdl.parallel.gain import Gain
from tfra.hdl.parallel.matvec.unit import MatVec
from tfra.hdl.parallel.normaliser import Normaliser
from tfra.hdl.parallel.scaling import Scaling
from tfra.hdl.parallel.tfra.centroids import Centroids
from tfra.hdl.parallel.tfra.combine.unit import Combine
from tfra.hdl.parallel.tfra.dependent import Dependent
from tfra.hdl.parallel.tfra.forces import Forces
from tfra.hdl.parallel.tfra.friction import Friction
from tfra.hdl.parallel.tfra.plan import PLAN
from tfra.hdl.parallel.tfra.resultant import Resultant
from tfra.hdl.parallel.tfra.sweep.unit import Sweep
from tfra.hdl.parallel.tfra.weights import Weights
from tfra.model.fixed.design import Design


@dataclass(frozen=True)
class Blocks:
    """The blocks in dataflow order; a field's name is that of the instance."""

    normaliser: Normaliser
    centroids: Centroids
    fold: Butterfly
    weights: Weights
    matvec: MatVec
    dependent: Dependent
    combine: Combine
    sweep: Sweep
    friction: Friction
    resultant: Resultant
    gain: Gain
    forces: Forces
    angle: Angle
    scaling: Scaling

    @classmethod
    def of(cls, design: Design) -> Blocks:
        """The blocks of ``design``."""
        return cls(
            Normaliser(design),
            Centroids(design),
            Butterfly(design.widths.stress),
            Weights(design),
            MatVec(design, PLAN),
            Dependent(design),
            Combine(design),
            Sweep(design),
            Friction(design),
            Resultant(design),
            Gain(design),
            Forces(design),
            Angle(design),
            Scaling(design),
        )

    def __iter__(self) -> Iterator[tuple[str, Any]]:
        return ((field.name, getattr(self, field.name)) for field in fields(self))
