"""Which word length matters: uniform designs of every length, and one signal alone a few bits shorter."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from tfra.model.fixed.tfra.design import TfraDesign
from tfra.study.errors.variation import Facts, Variation
from tfra.study.search.costs import coefficient_kbit, dsp
from tfra.study.search.space import Space
from tfra.synth.targets import ECP5, Family

SHORTER = (1, 2, 4)
"""Bits by which each signal is shortened alone."""

FRACTIONS = ("vector_fraction", "force_fraction")
"""Formats that are no word but bits below one code."""


def uniform(base: TfraDesign, lengths: Sequence[int], family: Family = ECP5) -> tuple[Variation, ...]:
    """Designs whose coefficients and operands all have n bits, for each n of ``lengths``.

    Vectors keep as many bits less below one code as operands are shorter than those of ``base``, within their limits;
    no signal has a length of its own.  Facts are ``bits``, ``vector_fraction``, ``coefficient_kbit`` and ``dsp`` (of
    ``family``).
    """
    plain = replace(base, formats=replace(base.formats, signals=()))
    return tuple(_uniform(plain, bits, family) for bits in lengths)


def _uniform(base: TfraDesign, bits: int, family: Family) -> Variation:
    fraction = min(16, max(0, base.formats.vector_fraction + bits - base.formats.operand))
    point = {"coefficient": bits, "operand": bits, "vector_fraction": fraction}
    made = Variation.of({"bits": bits, "vector_fraction": fraction}, lambda: Space.design(base, point))
    return _priced(made, family)


def sensitivity(base: TfraDesign, family: Family = ECP5) -> tuple[Variation, ...]:
    """``base`` with one signal alone shorter by each of ``SHORTER``: every signal, and vector and force fraction.

    Facts are ``signal``, ``bits`` that it is left, ``shorter``, and the costs as for :func:`uniform`.  What does not
    fit together is there with its reason.
    """
    return tuple(_priced(_shortened(base, *each), family) for each in _each_alone(base))


def _each_alone(base: TfraDesign) -> Iterator[tuple[str, int, int]]:
    for signal in (*base.signals, *FRACTIONS):
        bits = getattr(base.formats, signal) if signal in FRACTIONS else base.formats.bits(signal)
        yield from ((signal, bits, shorter) for shorter in SHORTER)


def _shortened(base: TfraDesign, signal: str, bits: int, shorter: int) -> Variation:
    left = bits - shorter
    facts: Facts = {"signal": signal, "bits": left, "shorter": shorter}
    return Variation.of(facts, lambda: Space.design(base, {signal: left}))


def _priced(made: Variation, family: Family) -> Variation:
    design = made.design
    costs: Facts = {
        "coefficient_kbit": None if design is None else coefficient_kbit(design),
        "dsp": None if design is None else dsp(design, family),
    }
    return replace(made, facts={**made.facts, **costs})
