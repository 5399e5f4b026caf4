"""The serial microarchitecture: one instruction of a program a cycle."""

from collections.abc import Callable, Iterator
from functools import cached_property
from pathlib import Path
from typing import Any

from tfra.hdl.interface.microarchitecture import Probe
from tfra.hdl.primitives import cell_models
from tfra.hdl.serial.core import SerialCore
from tfra.hdl.serial.program.memory import lengths, store_image
from tfra.hdl.serial.program.program import Program
from tfra.hdl.serial.sizes import lane_count
from tfra.model.arrays import Ints
from tfra.model.fixed.design import Design

_PORTS = 4
"""Cycles of the registers at both ports and of the datapath's pipeline."""

_REFILL = 2
"""Cycles from a taxel that leaves its buffer to the next one in it."""


class Serial:
    """:class:`tfra.hdl.interface.microarchitecture.Microarchitecture` of one core and its program.

    The assembler counts the cycles, none of which depends on data.  What others ask of it is described there.
    """

    settled = slice(None)
    enough = 2
    lane_choices: tuple[int, ...] = ()
    probes: tuple[Probe, ...] = ()

    def __init__(self, design: Design, program: Callable[[Any], Program]) -> None:
        self.design, self._program = design, program

    def check(self) -> None:
        _ = self.design.widths, self.program, self.coefficients

    def build(self) -> SerialCore:
        return SerialCore(self.design, self.program, self.coefficients)

    @cached_property
    def program(self) -> Program:
        return self._program(self.design)

    @property
    def intake(self) -> int:
        return self.program.intake - self.program.taxel + _REFILL

    @property
    def latency(self) -> int:
        return self._waits + self.program.first

    @property
    def frame_latency(self) -> int:
        return self._waits + self.program.last

    @property
    def initiation_interval(self) -> int:
        return self.program.interval

    @property
    def intervals(self) -> tuple[int]:
        return (self.program.interval,)

    def queued(self, ahead: int) -> tuple[int, int]:
        waits = ahead * self.initiation_interval
        return waits + self.latency, waits + self.frame_latency

    @property
    def _waits(self) -> int:
        """Cycles of a frame's last taxel at the ports and in its buffer, until the program takes it."""
        return _PORTS + self.program.taxel - _REFILL

    @property
    def lanes(self) -> int:
        return lane_count(self.design)

    def choices(self) -> "Iterator[Serial]":
        yield self

    @property
    def cell_models(self) -> tuple[Path, ...]:
        return cell_models(self.design.target, "store")

    @cached_property
    def coefficients(self) -> Ints:
        """Words ``(depth, lanes)`` of the store in the order in which they are loaded and read."""
        return store_image(self.design)

    @property
    def loaded(self) -> Ints:
        return self.coefficients.ravel()

    @property
    def load_order(self) -> str:
        times = " or ".join(map(str, lengths(self.design)))
        return (
            f"for every operator, parity of its results and group of {self.lanes} result quads (the last one filled up "
            f"with zeros): {times} times, once for each quad of the operand, a coefficient of each quad of the group"
        )
