"""The serial core's program: one frame of TFRA, in the order of :mod:`tfra.model.fixed.tfra.pipeline`.

Stages are in files named after the model's blocks; they pass results in words of the memory map and in registers, as
their docstrings state.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from tfra.hdl.serial.isa import NOTHING, Instruction
from tfra.hdl.serial.program import cordic, gain, intake, matvec, normaliser, scaling, words
from tfra.hdl.serial.program.routines import Writer, label
from tfra.hdl.serial.program.tfra import centroids, combine, dependent, forces, friction, resultant, sweep, weights
from tfra.model.fixed.design import Design

Stage = Callable[[Writer], None]

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
    cordic.angle,
)
"""From a frame's last taxel to its first result word."""

RESULT: tuple[Stage, ...] = (words.header, scaling.resultant_words, forces.forces, words.status)
"""The words of the result."""


@dataclass(frozen=True)
class Program:
    """The program of a frame, and its cycles, none of which depends on data."""

    instructions: tuple[Instruction, ...]
    subroutines: int
    """Instructions before the first subroutine; after it there are only subroutines."""
    memory: tuple[int, ...]
    """Initial contents of the data memory."""
    operands: int
    """The lowest words of the memory, of which the lanes have a copy."""
    names: dict[int, str]
    """Names of words of the memory, by address."""
    first: int
    """Cycles from the instruction that takes a frame's last taxel to that of its first result word."""
    last: int
    """Cycles from the instruction that takes a frame's last taxel to that of its last result word."""
    interval: int
    """Cycles from frame to frame."""
    taxel: int
    """Cycles from a taxel to the next one of its row."""


def program(design: Design) -> Program:
    """The program of ``design``; raises ``ValueError`` when it does not fit the memories."""
    w = Writer(design)
    a = w.assembler
    a.stage = "reset"
    a.move(w.at("counter"), NOTHING)
    start, before = len(a.program), a.cycles
    a.stage = label(intake.codes)
    taken, taxel = intake.codes(w)
    _write(w, ANALYSIS)
    first = a.cycles - taken + 1  # the header fetches the counter, its first word, with its first instruction
    _write(w, RESULT)
    last = a.cycles - taken - 1
    a.jump(start)
    interval = a.cycles - before
    subroutines = a.link()
    w.map.reserve(2)  # a product looks for a fifth parity after its table
    memory = tuple(w.map.words)
    return Program(
        tuple(a.program), subroutines, memory, w.map.operands, w.map.names, first, last, interval, taxel
    )


def _write(w: Writer, stages: tuple[Stage, ...]) -> None:
    for stage in stages:
        w.assembler.stage = label(stage)
        stage(w)
