"""The cores of every estimator.  Only this module reads ``design.architecture.kind``."""

from collections.abc import Callable
from typing import Any

from tfra.hdl.interface.microarchitecture import Microarchitecture
from tfra.hdl.parallel.learned.core import LearnedParallel
from tfra.hdl.parallel.tfra.core import TfraParallel
from tfra.hdl.serial.program.learned.frame import program as learned_program
from tfra.hdl.serial.program.program import Program
from tfra.hdl.serial.program.tfra.frame import program as tfra_program
from tfra.hdl.serial.serial import Serial
from tfra.model.fixed.design import Design
from tfra.model.fixed.learned.design import LearnedDesign
from tfra.model.fixed.tfra.design import TfraDesign

CORES: dict[type[Design], tuple[Callable[[Any], Microarchitecture], Callable[[Any], Program]]] = {
    TfraDesign: (TfraParallel, tfra_program),
    LearnedDesign: (LearnedParallel, learned_program),
}
"""By the estimator, a line each: its parallel core, and the program of its serial core."""

_KEPT = "microarchitecture"


def microarchitecture(design: Design) -> Microarchitecture:
    """The microarchitecture of ``design``, without building a core.

    It stays with the design, as all does that is computed from one: its cycles are asked for again and again.
    """
    kept = vars(design)
    if _KEPT not in kept:
        parallel, _ = CORES[type(design)]
        kept[_KEPT] = as_serial(design) if design.architecture.kind == "serial" else parallel(design)
    core: Microarchitecture = kept[_KEPT]
    return core


def as_serial(design: Design) -> Serial:
    """The serial core of ``design``, whatever its architecture."""
    _, program = CORES[type(design)]
    return Serial(design, program)


def program(design: Design) -> Program:
    """The serial core's program of ``design``; raises ``ValueError`` when it does not fit the memories."""
    return CORES[type(design)][1](design)
