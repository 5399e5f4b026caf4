"""The microarchitectures: ``design.architecture.kind`` chooses, and nothing else looks at it."""

from __future__ import annotations

from tfra.hdl.interface.microarchitecture import Microarchitecture
from tfra.hdl.parallel.tfra.parallel import Parallel
from tfra.hdl.serial.serial import Serial
from tfra.model.fixed.design import Design

_KINDS: dict[str, type[Parallel] | type[Serial]] = {"parallel": Parallel, "serial": Serial}


def microarchitecture(design: Design) -> Microarchitecture:
    """The core of ``design``; computes nothing yet."""
    return _KINDS[design.architecture.kind](design)
