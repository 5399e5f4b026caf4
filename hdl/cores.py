"""The microarchitectures.  Only this module reads ``design.architecture.kind``."""

from __future__ import annotations

from tfra.hdl.interface.microarchitecture import Microarchitecture
from tfra.hdl.parallel.learned.parallel import LearnedParallel
from tfra.hdl.parallel.tfra.parallel import TfraParallel
from tfra.hdl.serial.serial import Serial
from tfra.model.fixed.design import Design
from tfra.model.fixed.learned.design import LearnedDesign


def microarchitecture(design: Design) -> Microarchitecture:
    """The microarchitecture of ``design``, without building a core."""
    if design.architecture.kind == "serial":
        return Serial(design)
    return LearnedParallel(design) if isinstance(design, LearnedDesign) else TfraParallel(design)
