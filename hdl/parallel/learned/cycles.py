"""Cycles that blocks take, independent of the data."""

from __future__ import annotations

import gc
import warnings
from dataclasses import dataclass

from amaranth.hdl import UnusedElaboratable

from tfra.hdl.parallel.learned.activation import Activation
from tfra.hdl.parallel.learned.field import Field
from tfra.hdl.parallel.learned.forces import Forces
from tfra.hdl.parallel.learned.friction import Friction
from tfra.hdl.parallel.learned.resultant import Resultant
from tfra.hdl.parallel.learned.share import Share
from tfra.hdl.parallel.learned.words import Words
from tfra.hdl.parallel.normaliser import Normaliser
from tfra.model.fixed.learned.design import LearnedDesign


@dataclass(frozen=True)
class Cycles:
    """Cycles as the blocks state them: latencies unless noted."""

    normaliser: int
    activation: int
    resultant: int
    friction: int
    words: int
    vectors: int
    """From a frame's last product to the first cycle in which its field may begin."""
    field: int
    """From there to its last quad of p."""
    field_interval: int
    share: int
    share_interval: int
    """Between mantissas."""
    forces: int

    @classmethod
    def of(cls, design: LearnedDesign) -> Cycles:
        """Read them from every block of ``design``."""
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UnusedElaboratable)
            found = cls._ask(design)
            gc.collect()  # a block that was never elaborated warns when it is deleted: delete it here
        return found

    @classmethod
    def _ask(cls, design: LearnedDesign) -> Cycles:
        field, share = Field(design), Share(design)
        return cls(
            normaliser=Normaliser(design).latency,
            activation=Activation(design).latency,
            resultant=Resultant(design).latency,
            friction=Friction(design).latency,
            words=Words(design).latency,
            vectors=field.vectors_latency,
            field=field.latency,
            field_interval=field.interval,
            share=share.latency,
            share_interval=share.interval,
            forces=Forces(design).latency,
        )
