"""Frames through the core with one pattern of stalls, compared with the model; the first wrong word and its stage."""

from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from tfra.model.arrays import Ints
from tfra.model.fixed.design import Design, FixedResult
from tfra.sim import tools
from tfra.sim.protocol import STALLS
from tfra.sim.report import Mismatch
from tfra.sim.run import Netlist, Progress, ProtocolError, Run, SimulationError, simulate
from tfra.sim.stimuli import Stimuli

PATTERNS = tuple(STALLS)
"""Stalls on both ports; each pattern gets every third frame."""


@dataclass
class PatternRun:
    """Every third frame of the stimuli, from frame ``number`` on, with the stalls ``PATTERNS[number]``."""

    design: Design
    stimuli: Stimuli
    number: int
    simulator: str
    seed: int
    core: Any
    """As for ``simulate``."""
    run: Run | None = None
    """None where the core broke a rule of its streams: ``violations`` says which."""
    violations: list[str] = field(default_factory=list)
    compared: int = 0
    """Words that were compared with the model's."""
    mismatches: int = 0
    first: tuple[int, int] | None = None
    """Frame, among those of this run, and word of the first mismatch."""

    @property
    def pattern(self) -> str:
        """Name of the pattern of stalls."""
        return PATTERNS[self.number]

    @property
    def part(self) -> slice:
        """Which of the stimuli's frames are run."""
        return slice(self.number, None, len(PATTERNS))

    @property
    def codes(self) -> Ints:
        """Converter codes ``(n, rows, columns)`` of the frames."""
        return self.stimuli.codes[self.part]

    @cached_property
    def expected(self) -> Ints:
        """The model's words ``(n, frame_words)`` of the frames."""
        return self.design.model(self.codes).words

    def simulate(self, progress: Progress | None) -> None:
        """Run all frames and compare every word."""
        try:
            self.run = self._simulate(slice(None), progress=progress)
        except ProtocolError as error:
            self.violations = error.outcome.violations
            self.compared = error.outcome.compared
            self.mismatches = error.outcome.mismatches
            return
        different = np.argwhere(self.run.words != self.expected)
        self.compared = self.run.compared
        self.mismatches = len(different)
        if self.run.mismatches != self.mismatches:
            raise SimulationError(
                f"the testbench counted {self.run.mismatches} mismatches, there are {self.mismatches}"
            )
        if self.mismatches:
            frame, word = different[0].tolist()
            self.first = frame, word

    def single_latency(self) -> int:
        """Latency of the first frame in an idle core: frames after it would delay it."""
        return int(self._simulate(slice(1)).latency[0])

    def first_mismatch(self) -> Mismatch:
        """The first mismatch, with its stage from a second run with probes."""
        assert self.first is not None
        assert self.run is not None
        frame, word = self.first
        sensor = self.design.sensor
        part = next(f for f in self.design.layout if f.start <= word < f.start + f.count)
        name, taxel = part.name, None
        if name == "forces":
            plane, place = divmod(word - part.start, sensor.taxels)
            name, taxel = f"forces.{'xyz'[plane]}", divmod(place, sensor.columns)
        where = (self._original(frame), self.pattern, name, taxel, word)
        return Mismatch(*where, int(self.expected[frame, word]), int(self.run.words[frame, word]), *self._stage(frame))

    def record(self, waves: Path) -> int:
        """Write the signals of the wrong frame, or of the first one; return that frame's number."""
        if self.first is None:
            self._is_wrong(slice(None) if self.violations else slice(1), waves)
            return self._original(0)
        frame = self.first[0]
        if not self._is_wrong(slice(frame, frame + 1), waves):
            self._is_wrong(slice(frame + 1), waves)
        return self._original(frame)

    def _original(self, frame: int) -> int:
        """Number among the stimuli of a frame of this run."""
        return self.number + frame * len(PATTERNS)

    def _simulate(self, part: slice, simulator: str | None = None, **options: Any) -> Run:
        """A part of the frames with this run's stalls."""
        chosen = simulator or self.simulator
        core = self.core if chosen == "amaranth" or isinstance(self.core, Netlist) else None
        seed, codes = self.seed + self.number, self.codes[part]
        # Frames are numbered from reset on, in a word of theirs.
        expected = self.design.model(codes).words if part.start else self.expected[part]
        options |= {"expected": expected, "core": core}
        return simulate(self.design, codes, chosen, seed, self.pattern, self.pattern, **options)

    def _is_wrong(self, part: slice, waves: Path) -> bool:
        """Simulate a part of the frames with waves; true if a word was wrong."""
        try:
            return self._simulate(part, waves=waves).mismatches > 0
        except ProtocolError:
            return True

    def _stage(self, frame: int) -> tuple[str | None, int | None]:
        """The first wrong stage and transfer: of the frame alone or, if it is right then, after the ones before it."""
        simulator = self._probing_simulator()
        if simulator is None:
            return None, None
        for start in (frame, 0):
            part = slice(start, frame + 1)
            try:
                run = self._simulate(part, simulator, probes=True)
            except (ProtocolError, SimulationError):
                return None, None
            if run.mismatches:
                return first_difference(run, self.design.model(self.codes[part]), frame - start)
        return None, None

    def _probing_simulator(self) -> str | None:
        """A simulator that can watch probes; Amaranth's own does not have the Verilog's names.

        Gates have no probes: synthesis keeps no signal between blocks by its name.
        """
        if isinstance(self.core, Netlist) and not self.core.probes:
            return None
        if self.simulator != "amaranth":
            return self.simulator
        other = tools.choose()
        return other if other != "amaranth" and self.core is None else None


def first_difference(run: Run, model: FixedResult, frame: int) -> tuple[str | None, int | None]:
    """Return the first stage in dataflow order whose transfers of ``frame`` differ, and the first of them."""
    if not run.probes:
        return None, None
    for stage, observed in run.probes.items():
        expected = model.stages[stage][frame]
        words = expected.reshape(-1)
        if frame >= len(observed) or observed.shape[1] != words.size:
            return stage, None
        different = np.flatnonzero(observed[frame] != words)
        if len(different):
            per_transfer = expected.shape[-1] if expected.ndim > 1 else words.size
            return stage, int(different[0]) // per_transfer
    return next(reversed(model.stages)), None  # no probe saw it
