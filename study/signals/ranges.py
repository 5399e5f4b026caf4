"""Use of the words by signals: observed and proven ranges, rounding and saturation."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

import polars as pl

from tfra.model.arrays import Ints
from tfra.study.signals.instrument import Instrument
from tfra.study.signals.words import Observed, Word


@dataclass
class Range:
    """Observations of one signal: extremes, ``words``, and how many of them were rounded and limited."""

    minimum: int
    maximum: int
    words: int
    rounded: int | None
    saturated: int

    @classmethod
    def of(cls, observed: Observed) -> "Range":
        """The range of some words, at least one."""
        values = observed.values
        return cls(int(values.min()), int(values.max()), values.size, observed.rounded, observed.saturated)

    def __or__(self, other: "Range") -> "Range":
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
        return 1 + max((value if value >= 0 else ~value).bit_length() for value in (self.minimum, self.maximum))


@dataclass
class Ranges:
    """Ranges by signal; parts of a set of frames can be measured separately: ``+=`` adds them up."""

    frames: int = 0
    signals: dict[str, Range] = field(default_factory=dict)

    def __iadd__(self, other: "Ranges") -> "Ranges":
        self.frames += other.frames
        for signal, one in other.signals.items():
            self.signals[signal] = self.signals[signal] | one if signal in self.signals else one
        return self

    def document(self) -> dict[str, Any]:
        """All of it in plain values, which :meth:`of` takes back."""
        return asdict(self)

    @classmethod
    def of(cls, document: Mapping[str, Any]) -> "Ranges":
        """The object that ``document`` describes."""
        return cls(document["frames"], {signal: Range(**values) for signal, values in document["signals"].items()})

    def table(self, watched: Instrument[Any]) -> pl.DataFrame:
        """A row for each signal, in the order of the stages.

        ``stage``, ``signal``; ``word``, the field of ``Widths`` or the format that its length comes from, ``bits``,
        ``signed``; ``bound``, the largest magnitude by proof, or the format's where not ``proven``; ``minimum`` and
        ``maximum`` that were observed, ``share`` of the bound, ``bits_needed``, ``headroom_bits``; ``words``,
        ``rounded`` (null after a CORDIC) and ``saturated`` of them.
        """
        return pl.DataFrame([_row(signal, word, self.signals[signal]) for signal, word in watched.catalogue.items()])


def _row(signal: str, word: Word, measured: Range) -> dict[str, object]:
    needed = measured.bits(word.signed)
    return {
        "stage": str(word.stage),
        "signal": signal,
        "word": word.name,
        "bits": word.bits,
        "signed": word.signed,
        "bound": word.bound,
        "proven": word.proven,
        "minimum": measured.minimum,
        "maximum": measured.maximum,
        "share": measured.magnitude / word.bound,
        "bits_needed": needed,
        "headroom_bits": word.bits - needed,
        "words": measured.words,
        "rounded": measured.rounded,
        "saturated": measured.saturated,
    }


def measure_ranges(watched: Instrument[Any], codes: Ints) -> Ranges:
    """Ranges over converter codes ``(n, rows, columns)``."""
    total = Ranges()
    for trace in watched.traces(codes):
        if frames := len(watched.comparable(trace)):
            signals = {signal: Range.of(observed) for signal, observed in watched.observe(trace).items()}
            total += Ranges(frames, signals)
    return total
