"""Verify a core: every word of every frame against the bit-accurate model, its timing, and the float reference."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from tfra.hdl.cores import microarchitecture
from tfra.model.cover.scenes import wild_codes
from tfra.model.fixed.design import Design
from tfra.model.fixed.numbers import Ints
from tfra.model.fixed.tfra.pipeline import FixedResult, FixedTfra
from tfra.model.fixed.words import decode, quantise
from tfra.model.metrics import errors
from tfra.model.tfra import Bools, Result, Status, Tfra
from tfra.sim import tools
from tfra.sim.report import NOT_RETURNED, UNKNOWN, Account, ContactErrors, FloatErrors, Mismatch, Report, Timing
from tfra.sim.run import Netlist, Progress, ProtocolError, Run, SimulationError, simulate
from tfra.sim.stimuli import Stimuli, mixture

PATTERNS = ("none", "random", "bursts")
"""Stalls on both ports; each pattern gets every third frame."""

LAST_STAGE = "scaling"
"""Where words go wrong that no probe saw."""

SPECIAL = (Status.NO_CONTACT, Status.COMPRESSION_ONLY, Status.OUTPUT_SATURATED)
"""Frames with one of these are not compared with float TFRA: nothing was looked for, or words were limited."""


def verify(
    design: Design,
    frames: npt.ArrayLike | None = None,
    simulator: str | None = None,
    seed: int = 0,
    random: int = 200,
    references: Mapping[str, npt.ArrayLike] | None = None,
    progress: Progress | None = None,
    *,
    core: Netlist | Any = None,
) -> Report:
    """Simulate the core of ``design`` and compare every result word with the bit-accurate model.

    Args:
        frames: Stresses ``(n, rows, columns)`` in Pa; without any (None or n = 0), simulated contacts and directed
            frames are made up.
        simulator: As for :func:`tfra.sim.run.simulate`.
        seed: Of made-up frames and of stalls.
        random: Random frames to add.
        references: What is known of ``frames``, by the keys of a frames file (``REFERENCES``).
        progress: Called with numbers of finished frames.
        core: Another core to verify, as for ``simulate``.

    Raises ``InputError`` for an unusable simulator, ``ValueError`` for frames of a wrong shape or over full scale, and
    ``SimulationError`` when the simulation can't be carried out.  What the core does wrong is in the report.
    """
    chosen = tools.choose(simulator)
    stimuli = _stimuli(design, frames, seed, random, references)
    thirds = [_Third(design, stimuli, number, chosen, seed, core, progress) for number in range(len(PATTERNS))]
    thirds = [third for third in thirds if third.frames]
    bad = next((third for third in thirds if third.first is not None), None)
    back = _Returned.of(design, len(stimuli.codes), thirds)
    result, seen = decode(design, back.words), stimuli[back.whole]
    known = np.asarray(np.isfinite(seen.resultant).all(axis=1))
    special, unfit = _reasons(result.status, SPECIAL), _reasons(result.status, Status, known)
    why = {
        "model": np.where(back.compared, "", NOT_RETURNED),
        "float": back.why(special),
        "contact": back.why(unfit),
    }
    return Report(
        name=design.name,
        simulator=chosen,
        seed=seed,
        kinds={str(kind): int((stimuli.kinds == kind).sum()) for kind in dict.fromkeys(stimuli.kinds)},
        words=len(stimuli.codes) * design.frame_words,
        compared=sum(third.compared for third in thirds),
        mismatches=sum(third.mismatches for third in thirds),
        first=bad.located() if bad else None,
        violations=tuple(f"stalls {third.pattern}: {note}" for third in thirds for note in third.violations),
        timing=_timing(design, thirds[0], core),
        status=_histogram(result),
        against_float=_float_errors(design, seen, result, special == ""),
        against_contact=_contact_errors(seen, result, unfit == ""),
        accounts=_accounts(stimuli.kinds, why),
    )


def _stimuli(
    design: Design,
    frames: npt.ArrayLike | None,
    seed: int,
    random: int,
    references: Mapping[str, npt.ArrayLike] | None,
) -> Stimuli:
    given = np.empty(0) if frames is None else np.asarray(frames, dtype=np.float64)
    if not given.size:
        return mixture(design, seed, random)
    known = Stimuli.of(quantise(design, given), "given", references)
    return known + Stimuli.of(wild_codes(design, random, seed), "random")


class _Third:
    """Every third frame, with one pattern of stalls."""

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
        self._codes, self._model = stimuli.codes[self.part], FixedTfra(design)
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
        )

    def alone(self) -> int:
        """Latency of the first frame in an idle core: frames behind it would delay it."""
        run = self._again(self._codes[:1], self._model(self._codes[:1]).words)
        return int(run.latency[0])

    def located(self) -> Mismatch:
        """Return the first mismatch with everything that a second run with probes can tell."""
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

    def _stage(self, frame: int) -> tuple[str | None, int | None]:
        """Rerun the frame with probes, alone or, if that goes well, behind the ones before it."""
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
        """Return a simulator that can watch probes; Amaranth's own does not know the Verilog's names.

        Gates have no probes: synthesis keeps no signal between blocks by its name.
        """
        if isinstance(self._core, Netlist) and not self._core.probes:
            return None
        if self._simulator != "amaranth":
            return self._simulator
        other = tools.choose()
        return other if other != "amaranth" and self._core is None else None


def first_difference(run: Run, model: FixedResult, frame: int) -> tuple[str | None, int | None]:
    """Return the first stage, in the order of the data, whose transfers of ``frame`` differ, and the first of them."""
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
    return LAST_STAGE, None


def _timing(design: Design, third: _Third, core: Any) -> Timing:
    """Latency of a frame that is alone, and the interval over the frames that the design's statement is about."""
    latency = interval = None
    stated = microarchitecture(design)
    if third.run is not None:
        latency = third.alone()
        if len(third.run.words) >= stated.enough:
            interval = math.ceil(third.run.interval[stated.settled].mean())
    return Timing(latency, interval, *_stated(design, core))


def _stated(design: Design, core: Any) -> tuple[int | None, int | None]:
    if core is None:
        stated = microarchitecture(design)
        return stated.latency, stated.initiation_interval
    facts = core.sidecar if isinstance(core, Netlist) else {}
    return facts.get("latency_cycles"), facts.get("interval_cycles")


def _histogram(result: Result) -> dict[str, int]:
    counts = {"none": int((result.status == 0).sum())}
    return counts | {str(flag.name): int((result.status & flag != 0).sum()) for flag in Status}


def _float_errors(design: Design, seen: Stimuli, result: Result, regular: Bools) -> dict[str, FloatErrors]:
    exact = Tfra.of(design)(seen.codes * design.adc.lsb)
    every = errors(exact, result)
    found = {}
    for kind in dict.fromkeys(seen.kinds.tolist()):
        pick = regular & (seen.kinds == kind)
        if pick.any():
            distance = np.abs(exact.sweep_index - result.sweep_index)[pick]
            largest = {key: float(error[pick].max()) for key, error in every.items()}
            found[kind] = FloatErrors(int(pick.sum()), float((distance == 0).mean()), int(distance.max()), largest)
    return found


def _contact_errors(seen: Stimuli, result: Result, known: Bools) -> ContactErrors | None:
    if not known.any():
        return None
    every = errors(seen, result)
    median, largest = (
        {key: float(of(error[known])) for key, error in every.items()} for of in (np.median, np.max)
    )
    return ContactErrors(int(known.sum()), median, largest)


@dataclass(frozen=True)
class _Returned:
    """Which frames ``(n,)`` of the stimuli came back whole, which were compared bit by bit; words of the former."""

    whole: Bools
    compared: Bools
    words: Ints

    @classmethod
    def of(cls, design: Design, count: int, thirds: list[_Third]) -> _Returned:
        length = design.frame_words
        words, (whole, compared) = np.zeros((count, length), dtype=np.int64), np.zeros((2, count), dtype=np.bool_)
        for third in thirds:
            if len(third.words) == third.frames:
                whole[third.part] = True
                words[third.part] = third.words
            compared[np.arange(count)[third.part][: third.compared // length]] = True
        return cls(whole, compared, words[whole])

    def why(self, reasons: npt.NDArray[np.str_]) -> npt.NDArray[np.str_]:
        """``reasons`` of the whole frames to leave them out, spread over all ``(n,)``; empty for compared ones."""
        every = np.full(len(self.whole), NOT_RETURNED, dtype=object)
        every[self.whole] = reasons
        return every.astype(np.str_)


def _reasons(status: Ints, flags: Iterable[Status], known: Bools | None = None) -> npt.NDArray[np.str_]:
    """The first of ``flags`` that each frame has, ``(n,)``; ``UNKNOWN`` before that, and nothing where none holds."""
    why = np.full(len(status), "", dtype=object)
    for flag in reversed(list(flags)):
        why[status & flag != 0] = flag.name
    if known is not None:
        why[~known] = UNKNOWN
    return why.astype(np.str_)


def _accounts(kinds: npt.NDArray[np.str_], why: Mapping[str, npt.NDArray[np.str_]]) -> tuple[Account, ...]:
    """Count the reasons ``why`` frames ``(n,)`` are left out of each comparison, by kind."""
    found = []
    for kind in dict.fromkeys(kinds.tolist()):
        for against, reasons in why.items():
            counts = Counter(reasons[kinds == kind].tolist())
            compared = counts.pop("", 0)
            found.append(Account(kind, against, compared + counts.total(), compared, dict(counts)))
    return tuple(found)
