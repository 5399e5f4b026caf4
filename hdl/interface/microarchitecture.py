"""The interface of a core for the other packages, whatever its microarchitecture."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from tfra.model.arrays import Ints
from tfra.model.fixed.design import Design


@dataclass(frozen=True)
class Probe:
    """A stream between blocks that a simulation may watch: ``probe_STAGE`` is high for every transfer of it.

    ``probe_STAGE_words`` then holds the payload's members ``keys``, the first lowest; ``words`` are their bits and
    sign.  A frame has ``transfers`` of them, equal to the model's stage of the same name; those of frames that are in
    the core at the same time may interleave.
    """

    stage: str
    port: str
    keys: tuple[int | str, ...]
    words: tuple[tuple[int, bool], ...]
    transfers: int


class Microarchitecture(Protocol):
    """Builds the core of a design, and states its properties without building it.

    Every core has the streams ``taxel`` and ``result``; one that is loaded has ``load``, too.  Properties are computed
    on first access and stay with the object.
    """

    @property
    def design(self) -> Design:
        """The design that the core computes."""

    def check(self) -> None:
        """Raise ``ValueError`` for a design whose words can overflow or that the core's memories can't hold."""

    def build(self) -> Any:
        """The core as an Amaranth component; raises as :meth:`check`."""

    @property
    def intake(self) -> int:
        """Cycles from the first taxel of a frame to its last, one being always offered and the core idle."""

    @property
    def latency(self) -> int:
        """Cycles from the last taxel of a frame to its first result word, the core being idle."""

    @property
    def frame_latency(self) -> int:
        """Cycles from the last taxel of a frame to its last result word, the core being idle."""

    @property
    def initiation_interval(self) -> int:
        """Cycles from one frame to the next when frames come back to back, on average."""

    @property
    def intervals(self) -> Sequence[int]:
        """Cycles between the last result words of frames that come back to back, as they follow each other."""

    def queued(self, ahead: int) -> tuple[int, int]:
        """Most cycles to the first and to the last result word of a frame when frames come back to back.

        They count from the last taxel of the frame that is ``ahead`` frames before it.
        """

    @property
    def settled(self) -> slice:
        """The times between frames of a simulation whose mean is the initiation interval."""

    @property
    def enough(self) -> int:
        """Frames that a simulation needs to show the initiation interval."""

    @property
    def lanes(self) -> int:
        """Multiply-accumulate lanes."""

    @property
    def lane_choices(self) -> tuple[int, ...]:
        """Numbers of lanes that the sensor allows, ascending; empty if there is no choice."""

    def choices(self) -> "Iterator[Microarchitecture]":
        """This core with every number of lanes that the sensor allows, upwards; itself if they are not to be chosen."""

    @property
    def probes(self) -> tuple[Probe, ...]:
        """Streams between blocks that a simulation may watch, in the order in which data reach them."""

    @property
    def cell_models(self) -> tuple[Path, ...]:
        """Verilog files with models of the cells that the core instantiates."""

    @property
    def coefficients(self) -> Ints:
        """Every word of the coefficient memories, ``(memories, depth)`` or ``(depth, lanes)``."""

    @property
    def loaded(self) -> Ints | None:
        """Coefficients in the order in which the core loads them after a reset, one a transfer; None if it loads
        none."""

    @property
    def load_order(self) -> str:
        """That order, described in text."""
