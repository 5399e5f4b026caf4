"""Verify a core: every word of every frame against the bit-accurate model, its timing, and the float reference."""

import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from tfra.hdl.cores import microarchitecture
from tfra.model.converter import quantise
from tfra.model.cover.scenes import wild_codes
from tfra.model.fixed.design import Design
from tfra.model.fixed.words import scaled
from tfra.model.tfra import Status
from tfra.sim import tools
from tfra.sim.account import Returned, accounts, contact_errors, first_flags, float_errors, status_counts
from tfra.sim.pattern_run import PATTERNS, PatternRun
from tfra.sim.report import NOT_RETURNED, Report, Timing
from tfra.sim.run import Netlist
from tfra.sim.stimuli import Stimuli, mixture

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
    count = len(stimuli.codes)
    wrong = next((run for run in runs if run.first is not None), None)
    recorded = (wrong or next((run for run in runs if run.violations), first)).record(waves) if waves else None
    back = Returned.of(design, count, runs)
    result, returned = scaled(design, back.words), stimuli[back.whole]
    special = first_flags(result.status, SPECIAL)
    unfit = first_flags(result.status, Status, returned.known)
    reasons = {"model": np.where(back.compared, "", NOT_RETURNED)}
    reasons |= {"float": back.of_all(special), "contact": back.of_all(unfit)}
    return Report(
        name=design.name,
        simulator=first.simulator,
        seed=first.seed,
        kinds=dict(Counter(stimuli.kinds.tolist())),
        words=count * design.frame_words,
        compared=sum(run.compared for run in runs),
        mismatches=sum(run.mismatches for run in runs),
        first=wrong.first_mismatch() if wrong else None,
        violations=tuple(f"stalls {run.pattern}: {note}" for run in runs for note in run.violations),
        timing=_timing(first),
        status=status_counts(design, result),
        against_float=float_errors(design, returned, result, special == ""),
        against_contact=contact_errors(returned, result, unfit == ""),
        accounts=accounts(stimuli.kinds, reasons),
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


def _timing(first: PatternRun) -> Timing:
    """Of the run without stalls: latency of a single frame, interval over the frames that the stated one covers."""
    latency = interval = None
    stated = microarchitecture(first.design)
    if first.run is not None:
        latency = first.single_latency()
        if len(first.run.words) >= stated.enough:
            interval = math.ceil(first.run.interval[stated.settled].mean())
    return Timing(latency, interval, *_stated(first.design, first.core))


def _stated(design: Design, core: Any) -> tuple[int | None, int | None]:
    if core is None:
        stated = microarchitecture(design)
        return stated.latency, stated.initiation_interval
    facts = core.sidecar if isinstance(core, Netlist) else {}
    return facts.get("latency_cycles", {}).get("first_word"), facts.get("interval_cycles")
