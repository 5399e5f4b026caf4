"""Verify a core: every word of every frame against the bit-accurate model, its timing, and the float reference."""

import math
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from tfra.hdl.cores import microarchitecture
from tfra.model.arrays import Bools, Ints
from tfra.model.converter import quantise
from tfra.model.cover.scenes import wild_codes
from tfra.model.fixed.design import Design
from tfra.model.fixed.words import scaled
from tfra.model.metrics import errors
from tfra.model.tfra import Result, Status
from tfra.sim import tools
from tfra.sim.pattern_run import PATTERNS, PatternRun
from tfra.sim.report import NOT_RETURNED, UNKNOWN, Account, ContactErrors, FloatErrors, Report, Timing
from tfra.sim.run import Netlist
from tfra.sim.stimuli import Stimuli, mixture

Reasons = npt.NDArray[np.object_]
"""Texts why each frame ``(n,)`` is left out of a comparison; empty where it is not."""

SPECIAL = (Status.NO_CONTACT, Status.COMPRESSION_ONLY, Status.OUTPUT_SATURATED)
"""Frames with one of these are not compared with double precision: there was nothing to find, or words were limited."""


def verify(
    design: Design,
    frames: npt.ArrayLike | None = None,
    simulator: str | None = None,
    seed: int = 0,
    random: int = 200,
    references: Mapping[str, npt.ArrayLike] | None = None,
    progress: Callable[[int, int], None] | None = None,
    *,
    core: Netlist | Any = None,
    waves: Path | None = None,
) -> Report:
    """Simulate the core of ``design`` and compare every result word with the bit-accurate model.

    Args:
        frames: Stresses ``(n, rows, columns)`` in Pa; without any (None or n = 0), simulated contacts and directed
            frames are made up.
        simulator: As for :func:`tfra.sim.run.simulate`.
        seed: Of made-up frames and of stalls.
        random: Random frames to add.
        references: Ground truth of ``frames``, by the keys of a frames file (``REFERENCES``).
        progress: Called with numbers of frames that have finished, and of all.
        core: Another core to verify, as for ``simulate``.
        waves: A VCD file to write: the signals of the first frame that differs, with the ones before it where it is
            right alone; of the run that broke a stream's rules; else of the first frame.

    Raises ``InputError`` for an unusable simulator, ``ValueError`` for frames of a wrong shape or over full scale, and
    ``SimulationError`` when the simulation can't be carried out.  Faults of the core are in the report.
    """
    stimuli = _stimuli(design, frames, seed, random, references)
    count = len(stimuli.codes)
    chosen = tools.choose(simulator)
    runs = [PatternRun(design, stimuli, number, chosen, seed, core) for number in range(min(count, len(PATTERNS)))]
    for run in runs:
        run.simulate((lambda finished: progress(finished, count)) if progress else None)
    return _report(runs, waves)


def _report(runs: Sequence[PatternRun], waves: Path | None) -> Report:
    """Evaluate finished ``runs`` of the same stimuli; ``waves`` as for :func:`verify`."""
    first = runs[0]
    design, stimuli = first.design, first.stimuli
    wrong = next((run for run in runs if run.first is not None), None)
    recorded = (wrong or next((run for run in runs if run.violations), first)).record(waves) if waves else None
    whole, compared, words = _returned(runs)
    result, returned = scaled(design, words[whole]), stimuli[whole]
    special, unfit = _first_flags(result.status, SPECIAL), _first_flags(result.status, Status)
    unfit[~returned.known] = UNKNOWN
    reasons = {"model": np.where(compared, "", NOT_RETURNED)}
    for against, why in (("float", special), ("contact", unfit)):
        reasons[against] = np.full(len(whole), NOT_RETURNED, dtype=object)
        reasons[against][whole] = why
    flagged = {str(flag.name): int((result.status & flag != 0).sum()) for flag in design.status_bits}
    return Report(
        name=design.name,
        simulator=first.simulator,
        seed=first.seed,
        kinds=dict(Counter(stimuli.kinds.tolist())),
        words=words.size,
        compared=sum(run.compared for run in runs),
        mismatches=sum(run.mismatches for run in runs),
        first=wrong.first_mismatch() if wrong else None,
        violations=tuple(f"stalls {run.pattern}: {note}" for run in runs for note in run.violations),
        timing=_timing(first),
        status={"none": int((result.status == 0).sum()), **flagged},
        against_float=_float_errors(design, returned, result, special == ""),
        against_contact=_contact_errors(returned, result, unfit == ""),
        accounts=_accounts(stimuli.kinds, reasons),
        recorded=recorded,
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


def _returned(runs: Sequence[PatternRun]) -> tuple[Bools, Bools, Ints]:
    """Which of the stimuli's n frames came back, and which were compared bit by bit; words ``(n, frame_words)``."""
    count, length = len(runs[0].stimuli.codes), runs[0].design.frame_words
    words = np.zeros((count, length), dtype=np.int64)
    whole, compared = np.zeros((2, count), dtype=np.bool_)
    for run in runs:
        if run.run is not None:
            whole[run.part] = True
            words[run.part] = run.run.words
        compared[np.arange(count)[run.part][: run.compared // length]] = True
    return whole, compared, words


def _first_flags(status: Ints, flags: Iterable[Status]) -> Reasons:
    """The first of ``flags`` that each frame has."""
    reasons = np.full(len(status), "", dtype=object)
    for flag in reversed(list(flags)):
        reasons[status & flag != 0] = flag.name
    return reasons


def _accounts(kinds: npt.NDArray[np.str_], reasons: Mapping[str, Reasons]) -> tuple[Account, ...]:
    """Numbers of frames by kind and by comparison, whose ``reasons`` to leave frames out are given."""
    rows = []
    for kind in dict.fromkeys(kinds.tolist()):
        for against, why in reasons.items():
            counts = Counter(why[kinds == kind].tolist())
            compared = counts.pop("", 0)
            rows.append(Account(kind, against, compared + counts.total(), compared, dict(counts)))
    return tuple(rows)


def _float_errors(design: Design, stimuli: Stimuli, result: Result, regular: Bools) -> dict[str, FloatErrors]:
    """Errors against double precision on the same codes, by the kind of the ``regular`` frames."""
    exact = design.float_model(stimuli.codes * design.adc.lsb)
    every = errors(exact, result)
    distance = np.abs(exact.sweep_index - result.sweep_index)
    by_kind = {}
    for kind in dict.fromkeys(stimuli.kinds.tolist()):
        chosen = regular & (stimuli.kinds == kind)
        if chosen.any():
            largest = {key: float(error[chosen].max()) for key, error in every.items()}
            equal = float((distance[chosen] == 0).mean()) if design.sweeps else None
            farthest = int(distance[chosen].max()) if design.sweeps else None
            by_kind[kind] = FloatErrors(int(chosen.sum()), equal, farthest, largest)
    return by_kind


def _contact_errors(stimuli: Stimuli, result: Result, known: Bools) -> ContactErrors | None:
    """Errors against the contacts' true values where they are ``known``."""
    if not known.any():
        return None
    every = {key: error[known] for key, error in errors(stimuli, result).items()}
    median = {key: float(np.median(error)) for key, error in every.items()}
    largest = {key: float(error.max()) for key, error in every.items()}
    return ContactErrors(int(known.sum()), median, largest)


def _timing(first: PatternRun) -> Timing:
    """Of the run without stalls: latency of a single frame, interval over the frames that the stated one covers."""
    latency = interval = None
    stated = microarchitecture(first.design)
    if first.run is not None:
        latency = first.single_latency()
        if len(first.run.words) >= stated.enough:
            interval = math.ceil(first.run.interval[stated.settled].mean())
    if first.core is None:
        return Timing(latency, interval, stated.latency, stated.initiation_interval)
    facts = first.core.sidecar if isinstance(first.core, Netlist) else {}
    return Timing(latency, interval, facts.get("latency_cycles", {}).get("first_word"), facts.get("interval_cycles"))
