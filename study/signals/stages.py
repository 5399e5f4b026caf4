"""Precision of every stage of the bit-accurate model, against the same stage in float64.

A stage's own error is what it adds to its inputs; its whole error is that from the converter codes on.  Both take over
the model's decisions; frames for which float decides differently are counted separately.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import polars as pl

from tfra.model.arrays import Bools, Floats, Ints
from tfra.model.fixed.butterfly import butterfly, to_quads
from tfra.model.fixed.design import Design
from tfra.model.fixed.tfra.operators import exact_operators
from tfra.model.fixed.tfra.pipeline import FixedTfra, Trace
from tfra.model.tfra import TIE, Status, Tfra
from tfra.study.signals.reference import Decisions, Reference, Values
from tfra.study.signals.signals import SIGNALS, last_bits, only, words

REFERENCES = ("codes", "inputs")
"""Input of a reference: the converter codes, or the model's own inputs of the stage."""


@dataclass
class StageErrors:
    """Errors of ``frames``; those ``left_out`` have none: they are not swept, or a result of theirs is limited.

    Parts of a set of frames can be measured apart: ``+=`` adds them up.
    """

    frames: int = 0
    left_out: int = 0
    sums: dict[tuple[str, str], Floats] = field(default_factory=dict)
    """By signal and reference: words, signal squared, errors squared, errors, and the largest error, all in LSB."""
    flips: dict[str, Ints] = field(default_factory=dict)
    """By decision: frames compared, and those where float decides otherwise."""

    def __iadd__(self, other: StageErrors) -> StageErrors:
        self.frames += other.frames
        self.left_out += other.left_out
        for key, sums in other.sums.items():
            mine = self.sums.setdefault(key, np.zeros(5))
            mine[:4] += sums[:4]
            mine[4] = max(mine[4], sums[4])
        for decision, counts in other.flips.items():
            self.flips[decision] = self.flips.get(decision, 0) + counts
        return self

    def document(self) -> dict[str, Any]:
        """All of it in plain values, which :meth:`of` takes back bit for bit."""
        sums = [[*key, *map(float, values)] for key, values in self.sums.items()]
        flips = {decision: [int(count) for count in counts] for decision, counts in self.flips.items()}
        return {"frames": self.frames, "left_out": self.left_out, "sums": sums, "flips": flips}

    @classmethod
    def of(cls, document: Mapping[str, Any]) -> StageErrors:
        """The object that ``document`` describes."""
        sums = {(signal, reference): np.array(values) for signal, reference, *values in document["sums"]}
        flips = {decision: np.array(counts) for decision, counts in document["flips"].items()}
        return cls(document["frames"], document["left_out"], sums, flips)

    def errors(self) -> pl.DataFrame:
        """A row for each signal and each of ``REFERENCES``.

        Columns are ``stage``, ``signal``, ``reference``, ``words`` compared, ``exact`` (no word differs), ``sqnr_db``
        (null where exact), and ``max_error_lsb``, ``rms_error_lsb``, ``bias_lsb`` in units of the signal's last bit.
        """
        rows = []
        for (name, reference), (count, signal, square, total, largest) in self.sums.items():
            row = {"stage": str(SIGNALS[name]), "signal": name, "reference": reference, "words": int(count)}
            row |= {"exact": bool(largest == 0), "sqnr_db": 10 * np.log10(signal / square) if square else None}
            row |= {"max_error_lsb": largest, "rms_error_lsb": np.sqrt(square / count), "bias_lsb": total / count}
            rows.append(row)
        return pl.DataFrame(rows)

    def decisions(self) -> pl.DataFrame:
        """A row for each ``decision``: ``frames`` where those before it agree, and ``flips`` of them."""
        rows = [(name, int(frames), int(flips)) for name, (frames, flips) in self.flips.items()]
        return pl.DataFrame(rows, schema=["decision", "frames", "flips"], orient="row")


def stage_errors(design: Design, blocks: Iterable[Ints]) -> StageErrors:
    """Errors of every stage over ``blocks`` of converter codes ``(n, rows, columns)``.

    Raises ``ValueError`` if no frame is swept with every result within its word.
    """
    meter, found = StageMeter(design), StageErrors()
    for block in blocks:
        found += meter(block)
    if found.frames == found.left_out:
        raise ValueError(f"frames: none of {found.frames} is swept with every result within its word")
    return found


class StageMeter:
    """Measures the stages of one design."""

    def __init__(self, design: Design) -> None:
        self._design, self._reference, self._model = design, Reference(design), FixedTfra(design)
        self._float = Tfra.of(design, exact_operators(design))
        one_each = to_quads(design, np.eye(design.sensor.taxels, dtype=np.int64))
        self._carries = butterfly(one_each).any(axis=0)  # on middle lines the odd parities are no words at all

    def __call__(self, block: Ints) -> StageErrors:
        """Errors of converter codes ``(n, rows, columns)``."""
        found = StageErrors()
        for trace in self._model.traces(block):
            keep = trace.frame.regular & ~trace.scaled.saturated
            sums = self._errors(only(trace, keep)) if keep.any() else {}
            found += StageErrors(len(keep), int((~keep).sum()), sums, self._flips(trace))
        return found

    def _errors(self, trace: Trace) -> dict[tuple[str, str], Floats]:
        """Sums of frames that are swept."""
        decided = Decisions.of(self._design, trace)
        found, grid = words(self._design, trace), last_bits(self._design, trace)
        given: Values = {name: value * grid[name] if name in grid else value for name, value in found.items()}
        given["codes"] = trace.codes
        wanted = self._reference.from_codes(trace.codes, decided), self._reference.from_inputs(given, decided)
        sums = {}
        for name, word in found.items():
            for reference, values in zip(REFERENCES, wanted, strict=True):
                exact = values[name] / grid[name] if name in grid else values[name]
                error = np.asarray(word - exact, dtype=np.float64)
                if word.shape[1:] == self._carries.shape:
                    exact, error = exact[:, self._carries], error[:, self._carries]
                squares = (np.square(x, dtype=np.float64).sum() for x in (exact, error))
                sums[name, reference] = np.array([error.size, *squares, error.sum(), np.abs(error).max()])
        return sums

    def _flips(self, trace: Trace) -> dict[str, Ints]:
        """Decisions of any frames, each compared where those before it agree."""
        codes, sensor = trace.codes, self._design.sensor
        shape = len(codes), sensor.rows, sensor.columns
        exact = self._float(codes.reshape(shape) * self._design.adc.lsb)
        frame, found, counts = trace.frame, trace.direction, {}

        def says(flag: Status) -> Bools:
            return np.asarray(exact.status & flag != 0)

        def compare(decision: str, compared: Bools, same: Bools) -> Bools:
            counts[decision] = np.array([compared.sum(), (compared & ~same).sum()])
            return compared & same

        contact, swept = ~says(Status.NO_CONTACT), ~says(Status.NO_CONTACT | Status.COMPRESSION_ONLY)
        alike = compare("contact", np.ones(len(codes), dtype=np.bool_), contact == frame.contact)
        alike = compare("traction", alike & contact, swept == frame.regular) & swept
        alike = compare("no direction", alike, says(Status.NO_DIRECTION) == found.vanishing)
        cos, sin = self._reference.direction(codes, ~alike | found.vanishing).T
        sweep_y = np.abs(sin) > np.abs(cos) * (1 + TIE)
        alike = compare("swept variable", alike, sweep_y == found.sweep_y)
        alike = compare("sign", alike, (np.where(sweep_y, sin, cos) < 0) == found.negative)
        alike = compare("no denominator", alike, says(Status.VANISHING_DENOMINATOR) == trace.affine.vanishing)
        apart = np.abs(exact.sweep_index - trace.chosen.index)
        compare("sweep index, by more than one step", alike, apart <= 1)
        alike = compare("sweep index", alike, apart == 0)
        compare("out of range", alike, says(Status.DEPENDENT_OUT_OF_RANGE) == trace.chosen.out_of_range)
        return counts
