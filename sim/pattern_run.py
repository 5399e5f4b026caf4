"""Frames through the core with one pattern of stalls, compared with the model; the first wrong word and its stage."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from tfra.model.arrays import Ints
from tfra.model.fixed.design import Design
from tfra.model.fixed.result import FixedResult
from tfra.sim import tools
from tfra.sim.report import Mismatch
from tfra.sim.run import Netlist, Progress, ProtocolError, Run, SimulationError, simulate
from tfra.sim.stimuli import Stimuli

PATTERNS = ("none", "random", "bursts")
"""Stalls on both ports; each pattern gets every third frame."""


class PatternRun:
    """Every third frame of the stimuli, simulated with one pattern of stalls and compared with the model."""

    def __init__(
        self,
        design: Design,
        stimuli: Stimuli,
        number: int,
        simulator: str,
        seed: int,
        core: Any,
        progress: Progress | None,
    ) -> None:
        self.pattern, self.number = PATTERNS[number], number
        self.part = slice(number, None, len(PATTERNS))
        self._codes, self._model = stimuli.codes[self.part], design.model
        self._design, self._simulator, self._seed, self._core = design, simulator, seed, core
        self.frames = len(self._codes)
        self.run: Run | None = None
        self.violations: list[str] = []
        self.words: Ints = np.empty((0, design.frame_words), dtype=np.int64)
        self.compared = self.mismatches = 0
        self.first: tuple[int, int] | None = None
        if self.frames:
            self._simulate(progress)

    def _simulate(self, progress: Progress | None) -> None:
        expected = self._model(self._codes).words
        try:
            self.run = self._again(self._codes, expected, progress=progress)
        except ProtocolError as error:
            self.violations = error.violations
            self.compared, self.mismatches = error.compared, error.mismatches
            return
        self.words = self.run.words
        different = self.words != expected
        self.compared, self.mismatches = self.run.compared, int(different.sum())
        if self.run.mismatches != self.mismatches:
            raise SimulationError(
                f"the testbench counted {self.run.mismatches} mismatches, there are {self.mismatches}"
            )
        if self.mismatches:
            frame, word = np.argwhere(different)[0].tolist()
            self.first = frame, word

    def _again(
        self,
        codes: Ints,
        expected: Ints,
        simulator: str | None = None,
        probes: bool = False,
        progress: Progress | None = None,
        waves: Path | None = None,
    ) -> Run:
        chosen = simulator or self._simulator
        return simulate(
            self._design,
            codes,
            chosen,
            self._seed + self.number,
            self.pattern,
            self.pattern,
            progress=progress,
            expected=expected,
            core=self._core if chosen == "amaranth" or isinstance(self._core, Netlist) else None,
            probes=probes,
            waves=waves,
        )

    def alone(self) -> int:
        """Latency of the first frame in an idle core: frames after it would delay it."""
        run = self._again(self._codes[:1], self._model(self._codes[:1]).words)
        return int(run.latency[0])

    def located(self) -> Mismatch:
        """Return the first mismatch with the results of a second run with probes."""
        assert self.first is not None
        frame, word = self.first
        expected, observed = int(self._model(self._codes).words[frame, word]), int(self.words[frame, word])
        field = next(f for f in self._design.layout if f.start <= word < f.start + f.count)
        taxel = None
        if field.name == "forces":
            place = (word - field.start) % self._design.sensor.taxels
            taxel = divmod(place, self._design.sensor.columns)
        stage, transfer = self._stage(frame)
        original = self.number + frame * len(PATTERNS)
        name = f"forces.{'xyz'[(word - field.start) // self._design.sensor.taxels]}" if taxel else field.name
        return Mismatch(original, self.pattern, name, taxel, word, expected, observed, stage, transfer)

    def record(self, waves: Path) -> int:
        """Write the signals of the wrong frame, or of the first one; return that frame's number."""
        if self.first is None:
            codes = self._codes if self.violations else self._codes[:1]
            self._recorded(codes, waves)
            return self.number
        frame = self.first[0]
        if not self._recorded(self._codes[frame : frame + 1], waves):
            self._recorded(self._codes[: frame + 1], waves)
        return self.number + frame * len(PATTERNS)

    def _recorded(self, codes: Ints, waves: Path) -> bool:
        """Simulate with waves; true if a word was wrong."""
        try:
            return self._again(codes, self._model(codes).words, waves=waves).mismatches > 0
        except ProtocolError:
            return True

    def _stage(self, frame: int) -> tuple[str | None, int | None]:
        """The first wrong stage and transfer: of the frame alone or, if it is right then, after the ones before it."""
        simulator = self._probing()
        if simulator is None:
            return None, None
        for start in (frame, 0):
            codes = self._codes[start : frame + 1]
            model = self._model(codes)
            try:
                run = self._again(codes, model.words, simulator, probes=True)
            except (ProtocolError, SimulationError):
                return None, None
            if run.mismatches:
                return first_difference(run, model, frame - start)
        return None, None

    def _probing(self) -> str | None:
        """Return a simulator that can watch probes; Amaranth's own does not have the Verilog's names.

        Gates have no probes: synthesis keeps no signal between blocks by its name.
        """
        if isinstance(self._core, Netlist) and not self._core.probes:
            return None
        if self._simulator != "amaranth":
            return self._simulator
        other = tools.choose()
        return other if other != "amaranth" and self._core is None else None


def first_difference(run: Run, model: FixedResult, frame: int) -> tuple[str | None, int | None]:
    """Return the first stage in dataflow order whose transfers of ``frame`` differ, and the first of them."""
    if not run.probes:
        return None, None
    for stage, found in run.probes.items():
        expected = model.stages[stage][frame]
        words = expected.reshape(-1)
        if frame >= len(found) or found.shape[1] != words.size:
            return stage, None
        different = np.flatnonzero(found[frame] != words)
        if len(different):
            per_transfer = expected.shape[-1] if expected.ndim > 1 else words.size
            return stage, int(different[0]) // per_transfer
    return next(reversed(model.stages)), None  # no probe saw it
