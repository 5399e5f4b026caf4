"""The program of the learned estimator, in the order of :mod:`tfra.model.fixed.learned.pipeline`.

Stages are in files named after the model's blocks; they pass results in words of the memory map and in registers, as
their docstrings state.  The first words of a result leave before the forces at the taxels are computed.
"""

from collections.abc import Callable

from tfra.hdl.serial.program import words as shared
from tfra.hdl.serial.program.learned import field, friction, layers, normaliser, resultant, share, words
from tfra.hdl.serial.program.learned.memory import LearnedWriter
from tfra.hdl.serial.program.program import Program, write
from tfra.model.fixed.learned.design import LearnedDesign

Stage = Callable[[LearnedWriter], None]

ANALYSIS: tuple[Stage, ...] = (
    normaliser.normaliser,
    normaliser.fold,
    layers.first,
    layers.second,
    layers.read,
    layers.total,
    resultant.resultant,
    resultant.plausible,
    friction.angle,
    friction.friction,
)
"""From a frame's last taxel to its first result word."""

HEADER: tuple[Stage, ...] = (shared.header, words.resultant_words)
"""The words of the resultant."""

FORCES: tuple[Stage, ...] = (field.shear, field.unfold, share.share, share.forces)
"""The forces at the taxels."""


def program(design: LearnedDesign) -> Program:
    """The program of ``design``; raises ``ValueError`` when it does not fit the memories."""
    forces = FORCES if design.taxel_forces else ()
    return write(LearnedWriter(design), normaliser.codes, ANALYSIS, (*HEADER, *forces, words.status))
