"""Every block of the core."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields
from typing import Any

from tfra.hdl.lib.butterfly import Butterfly
from tfra.hdl.parallel.learned.activation import Activation
from tfra.hdl.parallel.learned.angle import Angle
from tfra.hdl.parallel.learned.field import Field
from tfra.hdl.parallel.learned.forces import Forces
from tfra.hdl.parallel.learned.friction import Friction
from tfra.hdl.parallel.learned.plan import plan
from tfra.hdl.parallel.learned.resultant import Resultant
from tfra.hdl.parallel.learned.share import Share
from tfra.hdl.parallel.learned.total import Total
from tfra.hdl.parallel.learned.words import Words
from tfra.hdl.parallel.matvec.unit import MatVec
from tfra.hdl.parallel.normaliser import Normaliser
from tfra.model.fixed.learned.design import LearnedDesign


@dataclass(frozen=True)
class AtTaxels:
    """The blocks that only the forces at the taxels need."""

    field: Field
    share: Share
    forces: Forces


@dataclass(frozen=True)
class Blocks:
    """The blocks in dataflow order; a field's name is that of the instance."""

    normaliser: Normaliser
    fold: Butterfly
    matvec: MatVec
    activation: Activation
    total: Total
    resultant: Resultant
    angle: Angle
    friction: Friction
    at_taxels: AtTaxels | None
    words: Words

    @classmethod
    def of(cls, design: LearnedDesign) -> Blocks:
        """The blocks of ``design``."""
        return cls(
            Normaliser(design),
            Butterfly(design.widths.stress),
            MatVec(design, plan(design)),
            Activation(design),
            Total(design),
            Resultant(design),
            Angle(design),
            Friction(design),
            AtTaxels(Field(design), Share(design), Forces(design)) if design.taxel_forces else None,
            Words(design),
        )

    def __iter__(self) -> Iterator[tuple[str, Any]]:
        for field in fields(self):
            block = getattr(self, field.name)
            if isinstance(block, AtTaxels):
                yield from ((part.name, getattr(block, part.name)) for part in fields(block))
            elif block is not None:
                yield field.name, block
