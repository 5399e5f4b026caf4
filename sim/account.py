"""The numbers of a verification's report: which comparisons were made, and why frames were left out."""

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

Reasons = npt.NDArray[np.str_]
"""Why each frame ``(n,)`` is left out of a comparison; empty where it is not."""


@dataclass(frozen=True)
class Returned:
    """Frames that came back: ``whole (n,)`` and ``compared (n,)`` bit by bit; ``words (whole frames, words)``."""

    whole: Bools
    compared: Bools
    words: Ints

    @classmethod
    def of(cls, design: Design, count: int, runs: Sequence[PatternRun]) -> "Returned":
        """What ``runs`` returned of ``count`` frames."""
        length = design.frame_words
        words = np.zeros((count, length), dtype=np.int64)
        whole = np.zeros(count, dtype=np.bool_)
        compared = np.zeros(count, dtype=np.bool_)
        for run in runs:
            if run.run is not None:
                whole[run.part] = True
                words[run.part] = run.run.words
            compared[np.arange(count)[run.part][: run.compared // length]] = True
        return cls(whole, compared, words[whole])

    def of_all(self, reasons: Reasons) -> Reasons:
        """``reasons`` of the whole frames, and that of the others."""
        every = np.full(len(self.whole), NOT_RETURNED, dtype=object)
        every[self.whole] = reasons
        return every.astype(np.str_)


def first_flags(status: Ints, flags: Iterable[Status], known: Bools | None = None) -> Reasons:
    """The first of ``flags`` that each frame has; before that, ``UNKNOWN`` where nothing is ``known``."""
    reasons = np.full(len(status), "", dtype=object)
    for flag in reversed(list(flags)):
        reasons[status & flag != 0] = flag.name
    if known is not None:
        reasons[~known] = UNKNOWN
    return reasons.astype(np.str_)


def accounts(kinds: npt.NDArray[np.str_], reasons: Mapping[str, Reasons]) -> tuple[Account, ...]:
    """Numbers of frames by kind and by comparison, whose ``reasons`` to leave frames out are given."""
    rows = []
    for kind in dict.fromkeys(kinds.tolist()):
        for against, why in reasons.items():
            counts = Counter(why[kinds == kind].tolist())
            compared = counts.pop("", 0)
            rows.append(Account(kind, against, compared + counts.total(), compared, dict(counts)))
    return tuple(rows)


def status_counts(design: Design, result: Result) -> dict[str, int]:
    """Numbers of frames without status, and with each bit of it."""
    counts = {"none": int((result.status == 0).sum())}
    return counts | {str(flag.name): int((result.status & flag != 0).sum()) for flag in design.status_bits}


def float_errors(design: Design, stimuli: Stimuli, result: Result, regular: Bools) -> dict[str, FloatErrors]:
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


def contact_errors(stimuli: Stimuli, result: Result, known: Bools) -> ContactErrors | None:
    """Errors against the contacts' true values where they are ``known``."""
    if not known.any():
        return None
    every = {key: error[known] for key, error in errors(stimuli, result).items()}
    median = {key: float(np.median(error)) for key, error in every.items()}
    largest = {key: float(error.max()) for key, error in every.items()}
    return ContactErrors(int(known.sum()), median, largest)
