"""Cycles that blocks take, independent of the data."""

from __future__ import annotations

import gc
import warnings
from dataclasses import dataclass

from amaranth.hdl import UnusedElaboratable

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
class BlockCycles:
    """Cycles as the blocks state them: latencies unless noted."""

    normaliser: int
    centroids: int
    weights: int
    dependent: int
    combine: int
    sweep: int
    turn: int
    """From e0's last quad at the sweep's queue to the first of e1 that it can take."""
    e0: int
    """Between quads of e0 at the sweep."""
    quad: int
    """Between quads of e1 at the sweep."""
    frame_interval: int
    """Between frames at the sweep."""
    friction: int
    resultant: int
    gain: int
    scaling: int
    plane: int
    """From a plane's last force product to its first result word."""
    read: int
    """From reading a force to its result word."""
    busy: int
    """In which the lanes multiply, of a frame."""

    @classmethod
    def of(cls, design: Design) -> BlockCycles:
        """Read them from every block of ``design``."""
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UnusedElaboratable)
            found = cls._ask(design)
            gc.collect()  # a block that was never elaborated warns when it is deleted: delete it here
        return found

    @classmethod
    def _ask(cls, design: Design) -> BlockCycles:
        combine, sweep, forces, scaling = Combine(design), Sweep(design), Forces(design), Scaling(design)
        return cls(
            normaliser=Normaliser(design).latency,
            centroids=Centroids(design).latency,
            weights=Weights(design).latency,
            dependent=Dependent(design).latency,
            combine=combine.force_latency,
            sweep=sweep.latency,
            turn=sweep.turn,
            e0=sweep.e0_interval,
            quad=sweep.quad_interval,
            frame_interval=sweep.frame_interval,
            friction=Friction(design).latency,
            resultant=Resultant(design).latency,
            gain=Gain(design).latency,
            scaling=scaling.latency,
            plane=combine.force_latency + forces.latency + scaling.force_latency,
            read=scaling.force_latency + forces.read_latency,
            busy=MatVec(design, PLAN).busy_cycles,
        )
