"""The programs of the estimators.  Only this module knows which estimators the serial core computes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from tfra.hdl.serial.program.learned.frame import program as learned
from tfra.hdl.serial.program.program import Program
from tfra.hdl.serial.program.tfra.frame import program as tfra
from tfra.model.fixed.design import Design
from tfra.model.fixed.learned.design import LearnedDesign
from tfra.model.fixed.tfra.design import TfraDesign

_PROGRAMS: dict[type[Design], Callable[[Any], Program]] = {TfraDesign: tfra, LearnedDesign: learned}


def program(design: Design) -> Program:
    """The program of ``design``; raises ``ValueError`` when it does not fit the memories."""
    return _PROGRAMS[type(design)](design)
