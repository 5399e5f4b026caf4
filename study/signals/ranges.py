"""Use of the words by signals: observed and proven ranges, rounding and saturation."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

import polars as pl

from tfra.model.arrays import Ints
from tfra.model.fixed.design import Design
from tfra.model.fixed.tfra.pipeline import FixedTfra
from tfra.study.signals.observation import Seen, Word, catalogue, observe


@dataclass
class Range:
    """Observations of one signal: extremes, ``words``, and how many of them were rounded and limited."""

    minimum: int
    maximum: int
    words: int
    rounded: int | None
    saturated: int

    @classmethod
    def of(cls, seen: Seen) -> Range:
        """The range of some words, at least one."""
        values = seen.values
        return cls(int(values.min()), int(values.max()), values.size, seen.rounded, seen.saturated)

    def __or__(self, other: Range) -> Range:
        rounded = None if self.rounded is None or other.rounded is None else self.rounded + other.rounded
        return Range(
            min(self.minimum, other.minimum),
            max(self.maximum, other.maximum),
            self.words + other.words,
            rounded,
            self.saturated + other.saturated,
        )

    @property
    def magnitude(self) -> int:
        """The largest one."""
        return max(-self.minimum, self.maximum)

    def bits(self, signed: bool) -> int:
        """Bits of the shortest word that holds both extremes."""
        if not signed:
            return self.maximum.bit_length()
        return (
            max(value.bit_length() if value >= 0 else (~value).bit_length() for value in (self.minimum, self.maximum))
            + 1
        )


@dataclass
class Ranges:
    """Ranges by signal; parts of a set of frames can be measured separately: ``+=`` adds them up."""

    frames: int = 0
    signals: dict[str, Range] = field(default_factory=dict)

    def __iadd__(self, other: Ranges) -> Ranges:
        self.frames += other.frames
        for signal, seen in other.signals.items():
            self.signals[signal] = self.signals[signal] | seen if signal in self.signals else seen
        return self

    def document(self) -> dict[str, Any]:
        """All of it in plain values, which :meth:`of` takes back."""
        return asdict(self)

    @classmethod
    def of(cls, document: Mapping[str, Any]) -> Ranges:
        """The object that ``document`` describes."""
        return cls(document["frames"], {signal: Range(**seen) for signal, seen in document["signals"].items()})

    def table(self, design: Design) -> pl.DataFrame:
        """A row for each signal of ``design``, in the order of its stages.

        ``stage``, ``signal``; ``word``, the field of ``Widths`` or the format that its length comes from, ``bits``,
        ``signed``; ``bound``, the largest magnitude by proof, or the format's where not ``proven``; ``minimum`` and
        ``maximum`` seen, ``share`` of the bound, ``bits_needed``, ``headroom_bits``; ``words``, ``rounded`` (null
        after a CORDIC) and ``saturated`` of them.
        """
        words = catalogue(design)
        order = sorted(words, key=lambda signal: list(type(words[signal].stage)).index(words[signal].stage))
        return pl.DataFrame([_row(signal, words[signal], self.signals[signal]) for signal in order])


def _row(signal: str, word: Word, seen: Range) -> dict[str, object]:
    needed = seen.bits(word.signed)
    return {
        "stage": str(word.stage),
        "signal": signal,
        "word": word.name,
        "bits": word.bits,
        "signed": word.signed,
        "bound": word.bound,
        "proven": word.proven,
        "minimum": seen.minimum,
        "maximum": seen.maximum,
        "share": seen.magnitude / word.bound,
        "bits_needed": needed,
        "headroom_bits": word.bits - needed,
        "words": seen.words,
        "rounded": seen.rounded,
        "saturated": seen.saturated,
    }


def measure(design: Design, block: Ints) -> Ranges:
    """Ranges over converter codes ``(n, rows, columns)``."""
    found = Ranges()
    for trace in FixedTfra(design).traces(block):
        if len(trace.codes):
            seen = observe(design, trace)
            found += Ranges(len(trace.codes), {signal: Range.of(words) for signal, words in seen.items()})
    return found


def ranges(design: Design, blocks: Iterable[Ints]) -> pl.DataFrame:
    """The table of :class:`Ranges` over ``blocks`` of converter codes; raises ``ValueError`` without any frame."""
    found = Ranges()
    for block in blocks:
        found += measure(design, block)
    if not found.frames:
        raise ValueError("frames: there are none")
    return found.table(design)


def broken(table: pl.DataFrame) -> pl.DataFrame:
    """The rows of :func:`ranges` that exceed a word or a proven bound; there should be none."""
    return table.filter((pl.col("headroom_bits") < 0) | (pl.col("proven") & (pl.col("share") > 1)))
