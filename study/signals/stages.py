"""Precision of every stage of a bit-accurate model, against the same stage in float64.

A stage's own error is what it adds to its inputs; its whole error is that from the converter codes on.  Both take over
the model's decisions; frames for which float decides differently are counted separately.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import polars as pl

from tfra.model.arrays import Floats, Ints
from tfra.study.signals.instrument import Instrument


@dataclass
class StageErrors:
    """Errors of ``frames``; those ``left_out`` have none: they can't be compared.

    Parts of a set of frames can be measured apart: ``+=`` adds them up.
    """

    frames: int = 0
    left_out: int = 0
    sums: dict[tuple[str, str], Floats] = field(default_factory=dict)
    """By signal and reference: words, signal squared, errors squared, errors, and the largest error, all in LSB."""
    flips: dict[str, Ints] = field(default_factory=dict)
    """By decision: frames compared, and those where float decides otherwise."""

    def __iadd__(self, other: "StageErrors") -> "StageErrors":
        self.frames += other.frames
        self.left_out += other.left_out
        for key, sums in other.sums.items():
            own = self.sums.setdefault(key, np.zeros(5))
            own[:4] += sums[:4]
            own[4] = max(own[4], sums[4])
        for decision, counts in other.flips.items():
            self.flips[decision] = self.flips.get(decision, 0) + counts
        return self

    def document(self) -> dict[str, Any]:
        """All of it in plain values, which :meth:`of` takes back bit for bit."""
        sums = [[*key, *map(float, values)] for key, values in self.sums.items()]
        flips = {decision: [int(count) for count in counts] for decision, counts in self.flips.items()}
        return {"frames": self.frames, "left_out": self.left_out, "sums": sums, "flips": flips}

    @classmethod
    def of(cls, document: Mapping[str, Any]) -> "StageErrors":
        """The object that ``document`` describes."""
        sums = {(signal, reference): np.array(values) for signal, reference, *values in document["sums"]}
        flips = {decision: np.array(counts) for decision, counts in document["flips"].items()}
        return cls(document["frames"], document["left_out"], sums, flips)

    def errors(self, watched: Instrument[Any]) -> pl.DataFrame:
        """A row for each signal and each reference, ``codes`` and ``inputs``.

        Columns are ``stage``, ``signal``, ``reference``, ``words`` compared, ``exact`` (no word differs), ``sqnr_db``
        (null where exact), and ``max_error_lsb``, ``rms_error_lsb``, ``bias_lsb`` in units of the signal's last bit.
        """
        rows = []
        for (name, reference), (count, signal, square, total, largest) in self.sums.items():
            row = {"stage": str(watched.stage(name)), "signal": name, "reference": reference, "words": int(count)}
            row |= {"exact": bool(largest == 0), "sqnr_db": 10 * np.log10(signal / square) if square else None}
            row |= {"max_error_lsb": largest, "rms_error_lsb": np.sqrt(square / count), "bias_lsb": total / count}
            rows.append(row)
        return pl.DataFrame(rows)

    def decisions(self) -> pl.DataFrame:
        """A row for each ``decision``: ``frames`` where those before it agree, and ``flips`` of them."""
        rows = [(name, int(frames), int(flips)) for name, (frames, flips) in self.flips.items()]
        return pl.DataFrame(rows, schema=["decision", "frames", "flips"], orient="row")


def measure_stages(watched: Instrument[Any], codes: Ints) -> StageErrors:
    """Errors of every stage for converter codes ``(n, rows, columns)``."""
    total = StageErrors()
    for trace in watched.traces(codes):
        frames = watched.comparable(trace)
        compared = watched.compare(trace, frames) if frames.any() else {}
        sums = {key: _sums(*values) for key, values in compared.items()}
        total += StageErrors(len(frames), int((~frames).sum()), sums, dict(watched.flips(trace)))
    return total


def _sums(exact: Floats, error: Floats) -> Floats:
    squares = (np.square(values, dtype=np.float64).sum() for values in (exact, error))
    return np.array([error.size, *squares, error.sum(), np.abs(error).max()])
