"""Words of signals inside a bit-accurate model: measures of their use, and of the precision of every stage.

A stage's own error is what it adds to its inputs, against the same stage in float64; its whole error is that from the
converter codes on.  Both take over the model's decisions; frames for which float decides differently are counted
separately.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from itertools import product
from operator import add
from typing import Any

import numpy as np
import numpy.typing as npt
import polars as pl

from tfra.model.arrays import Floats, Ints
from tfra.model.fixed.design import Design
from tfra.model.fixed.numbers import bit_length, round_shift, saturate, significant_bits
from tfra.model.fixed.widths import LONGEST

Row = dict[str, Any]
"""Numbers by column."""

Measures = Mapping[str, Mapping[str, Row]]
"""Rows of ``ranges``, of ``lengths``, and of the errors against each of ``REFERENCES``, by signal; rows of ``flips`` by
decision."""

Values = dict[str, npt.NDArray[Any]]
"""Signals between stages in float64, by name; the first axis is the frame."""

REFERENCES = ("codes", "inputs")
"""Float64 from the converter codes on, and float64 in the signal's stage alone."""

_EXTREMES: Mapping[str, Callable[[Any, Any], Any]] = {"minimum": min, "maximum": max, "largest": max}
"""Columns that do not add up."""


@dataclass(frozen=True)
class Word:
    """A signal's word: the field of ``Widths``, or the format, that its length comes from.

    ``bound`` is the largest magnitude by proof; where ``proven`` is false, words are shifted to fill the format, or
    limited to it, and the bound is the format's.
    """

    stage: str
    name: str
    bits: int
    signed: bool
    bound: float
    proven: bool = True

    @classmethod
    def full(cls, stage: str, name: str, bits: int, signed: bool = True) -> "Word":
        """A word that may have all values of its ``bits``."""
        return cls(stage, name, bits, signed, float(2 ** (bits - 1) if signed else 2**bits - 1), proven=False)


@dataclass(frozen=True)
class Observed:
    """Values ``(n, …)`` of a signal; how many of them were ``rounded`` to another value, and how many ``saturated``.

    ``rounded`` is ``None`` after a CORDIC, which rounds in every rotation.
    """

    values: Ints
    rounded: int | None = 0
    saturated: int = 0


def cast(exact: Ints, shift: npt.ArrayLike, bits: int | None = None) -> Observed:
    """``exact / 2^shift`` as words, limited to ``bits`` if given."""
    shift = np.asarray(shift, dtype=np.int64)
    lost = exact & ((np.int64(1) << np.clip(shift, 0, 62)) - 1)
    wide = round_shift(exact, shift)
    values = wide if bits is None else saturate(wide, bits)
    return Observed(values, int(np.count_nonzero(lost)), int(np.count_nonzero(values != wide)))


def filled(exact: Ints, axis: int | tuple[int, ...], bits: int) -> Observed:
    """``exact`` words, those along ``axis`` shifted together to fill ``bits``."""
    significant = significant_bits(exact, axis)
    return cast(exact, np.expand_dims(significant, axis) - (bits - 1), bits)


def total(parts: Iterable[Measures]) -> dict[str, dict[str, Row]]:
    """The measures of all frames from those of ``parts`` of them."""
    measures: dict[str, dict[str, Row]] = {name: {} for name in ("ranges", "lengths", *REFERENCES, "flips")}
    for part in parts:
        for table, rows in part.items():
            own = measures[table]
            own |= {name: _added(own[name], row) if name in own else row for name, row in rows.items()}
    return measures


def _added(one: Row, other: Row) -> Row:
    """Both rows together; null stays null."""
    return {
        column: None if value is None else _EXTREMES.get(column, add)(value, other[column])
        for column, value in one.items()
    }


def range_of(observed: Observed) -> Row:
    """Extremes of some words, at least one, and how many of them were rounded and limited."""
    values = observed.values
    row = {"minimum": int(values.min()), "maximum": int(values.max()), "words": values.size}
    return row | {"rounded": observed.rounded, "saturated": observed.saturated}


def lengths_of(words: Ints) -> Row:
    """How many of ``words`` have so many bits beside the sign, by the number of bits as text."""
    counts = np.bincount(bit_length(words ^ (words >> 63)).ravel(), minlength=LONGEST + 1)
    return {str(bits): int(count) for bits, count in enumerate(counts)}


def errors_of(exact: Floats, error: Floats) -> Row:
    """Sums over words, from their float64 values and their errors, both in LSB."""
    power, square = (float(np.square(values, dtype=np.float64).sum()) for values in (exact, error))
    row = {"words": error.size, "power": power, "square": square}
    return row | {"error": float(error.sum()), "largest": float(np.abs(error).max())}


def range_table(catalogue: Mapping[str, Word], measures: Measures) -> pl.DataFrame:
    """A row for each signal, in the order of the stages.

    ``stage``, ``signal``; ``word``, the field of ``Widths`` or the format that its length comes from, ``bits``,
    ``signed``; ``bound``, the largest magnitude by proof, or the format's where not ``proven``; ``minimum`` and
    ``maximum`` that were observed, ``share`` of the bound, ``bits_needed``, ``headroom_bits``; ``words``,
    ``rounded`` (null after a CORDIC) and ``saturated`` of them.
    """
    rows = []
    for signal, word in catalogue.items():
        row = measures["ranges"][signal]
        low, high = row["minimum"], row["maximum"]
        needed = bits_needed(low, high, word.signed)
        rows.append({
            "stage": str(word.stage),
            "signal": signal,
            "word": word.name,
            "bits": word.bits,
            "signed": word.signed,
            "bound": word.bound,
            "proven": word.proven,
            "minimum": low,
            "maximum": high,
            "share": max(-low, high) / word.bound,
            "bits_needed": needed,
            "headroom_bits": word.bits - needed,
            "words": row["words"],
            "rounded": row["rounded"],
            "saturated": row["saturated"],
        })  # fmt: skip
    return pl.DataFrame(rows)


def length_table(design: Design, measures: Measures) -> pl.DataFrame:
    """A row for each length that words of a ``kind``, ``signal`` or ``coefficient``, of a ``name`` have.

    ``significant_bits`` beside the sign, and the ``share`` of the words that have so many.  Coefficients are those of
    ``design``, as their own words.
    """
    lengths = [("signal", name, row) for name, row in measures["lengths"].items()]
    for stack in design.stacks.values():
        for op in stack.operators:
            zeros = design.coefficient_word - design.formats.bits(f"coefficient.{op.name}")
            lengths.append(("coefficient", op.name, lengths_of(op.rows >> zeros)))
    rows = [
        {"kind": kind, "name": name, "significant_bits": int(bits), "share": count / sum(row.values())}
        for kind, name, row in lengths
        for bits, count in row.items()
        if count
    ]
    return pl.DataFrame(rows, schema={"kind": pl.String, "name": pl.String, "significant_bits": int, "share": float})


def bits_needed(minimum: int, maximum: int, signed: bool) -> int:
    """Bits of the shortest word that holds both extremes."""
    if not signed:
        return maximum.bit_length()
    return 1 + max((value if value >= 0 else ~value).bit_length() for value in (minimum, maximum))


def stage_table(stage_of: Callable[[str], str], measures: Measures) -> pl.DataFrame:
    """A row for each signal and each reference, ``codes`` and ``inputs``; none where no frame can be compared.

    Columns are ``stage``, ``signal``, ``reference``, ``words`` compared, ``exact`` (no word differs), ``sqnr_db``
    (null where exact), and ``max_error_lsb``, ``rms_error_lsb``, ``bias_lsb`` in units of the signal's last bit.
    """
    rows = []
    for signal, reference in product(measures["codes"], REFERENCES):
        count, power, square, error, largest = measures[reference][signal].values()
        rows.append({
            "stage": str(stage_of(signal)),
            "signal": signal,
            "reference": reference,
            "words": count,
            "exact": largest == 0,
            "sqnr_db": 10 * np.log10(power / square) if square else None,
            "max_error_lsb": largest,
            "rms_error_lsb": np.sqrt(square / count),
            "bias_lsb": error / count,
        })  # fmt: skip
    return pl.DataFrame(rows)


def decision_table(measures: Measures) -> pl.DataFrame:
    """A row for each ``decision``: ``frames`` where those before it agree, and ``flips`` of them."""
    return pl.DataFrame([{"decision": decision, **row} for decision, row in measures["flips"].items()])
