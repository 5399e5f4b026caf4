"""The numbers of a verification's report: which comparisons were made, and why frames were left out."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tfra.model.arrays import Bools, Ints
from tfra.model.fixed.design import Design
from tfra.model.metrics import errors
from tfra.model.tfra import Result, Status
from tfra.sim.pattern_run import PatternRun
from tfra.sim.report import NOT_RETURNED, UNKNOWN, Account, ContactErrors, FloatErrors
from tfra.sim.stimuli import Stimuli


@dataclass(frozen=True)
class Returned:
    """The frames ``(n,)`` of the stimuli that came back whole, those that were compared bit by bit, and the words of
    the former."""

    whole: Bools
    compared: Bools
    words: Ints

    @classmethod
    def of(cls, design: Design, count: int, runs: Sequence[PatternRun]) -> Returned:
        length = design.frame_words
        words, (whole, compared) = np.zeros((count, length), dtype=np.int64), np.zeros((2, count), dtype=np.bool_)
        for run in runs:
            if len(run.words) == run.frames:
                whole[run.part] = True
                words[run.part] = run.words
            compared[np.arange(count)[run.part][: run.compared // length]] = True
        return cls(whole, compared, words[whole])

    def why(self, reasons: npt.NDArray[np.str_]) -> npt.NDArray[np.str_]:
        """``reasons`` of the whole frames to leave them out, spread over all ``(n,)``; empty for compared ones."""
        every = np.full(len(self.whole), NOT_RETURNED, dtype=object)
        every[self.whole] = reasons
        return every.astype(np.str_)


def reasons(status: Ints, flags: Iterable[Status], known: Bools | None = None) -> npt.NDArray[np.str_]:
    """The first of ``flags`` that each frame has, ``(n,)``; ``UNKNOWN`` before that, and nothing where none holds."""
    why = np.full(len(status), "", dtype=object)
    for flag in reversed(list(flags)):
        why[status & flag != 0] = flag.name
    if known is not None:
        why[~known] = UNKNOWN
    return why.astype(np.str_)


def accounts(kinds: npt.NDArray[np.str_], why: Mapping[str, npt.NDArray[np.str_]]) -> tuple[Account, ...]:
    """Count the reasons ``why`` frames ``(n,)`` are left out of each comparison, by kind."""
    found = []
    for kind in dict.fromkeys(kinds.tolist()):
        for against, reasons in why.items():
            counts = Counter(reasons[kinds == kind].tolist())
            compared = counts.pop("", 0)
            found.append(Account(kind, against, compared + counts.total(), compared, dict(counts)))
    return tuple(found)


def histogram(design: Design, result: Result) -> dict[str, int]:
    counts = {"none": int((result.status == 0).sum())}
    return counts | {str(flag.name): int((result.status & flag != 0).sum()) for flag in design.status_bits}


def float_errors(design: Design, seen: Stimuli, result: Result, regular: Bools) -> dict[str, FloatErrors]:
    exact = design.float_model(seen.codes * design.adc.lsb)
    every = errors(exact, result)
    found = {}
    for kind in dict.fromkeys(seen.kinds.tolist()):
        pick = regular & (seen.kinds == kind)
        if pick.any():
            distance = np.abs(exact.sweep_index - result.sweep_index)[pick]
            largest = {key: float(error[pick].max()) for key, error in every.items()}
            equal, apart = float((distance == 0).mean()), int(distance.max())
            index = (equal, apart) if design.sweeps else (None, None)
            found[kind] = FloatErrors(int(pick.sum()), index[0], index[1], largest)
    return found


def contact_errors(seen: Stimuli, result: Result, known: Bools) -> ContactErrors | None:
    if not known.any():
        return None
    every = errors(seen, result)
    median, largest = (
        {key: float(of(error[known])) for key, error in every.items()} for of in (np.median, np.max)
    )
    return ContactErrors(int(known.sum()), median, largest)
