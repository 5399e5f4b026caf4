"""The microarchitectures.  Only this module reads ``design.architecture.kind``."""

from __future__ import annotations

from tfra.hdl.interface.microarchitecture import Microarchitecture
from tfra.hdl.parallel.tfra.parallel import Parallel
from tfra.hdl.serial.serial import Serial
from tfra.model.fixed.design import Design

_KINDS: dict[str, type[Parallel] | type[Serial]] = {"parallel": Parallel, "serial": Serial}


def microarchitecture(design: Design) -> Microarchitecture:
    """The microarchitecture of ``design``, without building a core."""
    return _KINDS[design.architecture.kind](design)
