"""Latency and interval of the serial core, which the assembler counts: no cycle depends on data."""

from __future__ import annotations

from functools import cached_property

from tfra.hdl.serial.program.frame import Program, program
from tfra.model.design import Design
from tfra.model.fixed.coefficients import multiplications

_PORTS = 4
"""Cycles of the two ports and of the datapath, beside the instructions between them."""

_REFILL = 2
"""Cycles in which the taxels' buffer hands one on and takes the next."""


class Timing:
    """Latency and initiation interval of a serial core, in cycles, if neither stream of frames stalls."""

    def __init__(self, design: Design) -> None:
        self.design = design

    @cached_property
    def _program(self) -> Program:
        return program(self.design)

    @property
    def latency(self) -> int:
        """Cycles from the last taxel of a frame, which waits for the program in a buffer, to the first result word."""
        return self._waits + self._program.first

    @property
    def frame_latency(self) -> int:
        """Cycles from the last taxel of a frame to its last result word."""
        return self._waits + self._program.last

    @property
    def initiation_interval(self) -> int:
        """Cycles from one frame to the next."""
        return self._program.interval

    @property
    def multiplications(self) -> int:
        """Real products of a frame in the lanes."""
        return multiplications(self.design)

    @property
    def _waits(self) -> int:
        return _PORTS + self._program.taxel - _REFILL
