"""The serial core's program: one frame of TFRA, in the order of :mod:`tfra.model.fixed.tfra.pipeline`.

Stages are in files named after the model's blocks; they pass results in words of the memory map and in registers, as
their docstrings state.
"""

from collections.abc import Callable

from tfra.hdl.serial.program import gain, scaling, words
from tfra.hdl.serial.program.program import Program, write
from tfra.hdl.serial.program.tfra import (
    angle,
    centroids,
    combine,
    dependent,
    forces,
    friction,
    intake,
    matvec,
    normaliser,
    resultant,
    status,
    sweep,
    weights,
)
from tfra.hdl.serial.program.tfra.memory import TfraWriter
from tfra.model.fixed.design import Design

Stage = Callable[[TfraWriter], None]

ANALYSIS: tuple[Stage, ...] = (
    normaliser.normaliser,
    normaliser.fold,
    centroids.centroids,
    centroids.direction,
    matvec.contact,
    weights.weights,
    matvec.residual,
    dependent.sums,
    dependent.fractions,
    dependent.dependent,
    combine.residuals,
    matvec.normal,
    sweep.unfold,
    sweep.clear,
    sweep.terms,
    sweep.running_sums,
    sweep.choose,
    friction.friction,
    friction.dependent_friction,
    combine.winner,
    resultant.resultant,
    gain.modulus,
    gain.gain,
    gain.factors,
    gain.shifts,
    gain.mu,
    angle.angle,
)
"""From a frame's last taxel to its first result word."""

RESULT: tuple[Stage, ...] = (words.header, scaling.resultant_words, forces.forces, status.status)
"""The words of the result."""


def program(design: Design) -> Program:
    """The program of ``design``; raises ``ValueError`` when it does not fit the memories."""
    return write(TfraWriter(design), intake.codes, ANALYSIS, RESULT)
