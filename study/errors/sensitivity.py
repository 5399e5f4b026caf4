"""Sensitivity to word lengths: uniform designs of every length, and designs with one signal a few bits shorter."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from tfra.families import DEFAULT, Family
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.study.errors.variation import Facts, Variation
from tfra.study.search.costs import coefficient_kbit, dsp
from tfra.study.search.space import Space

UNIFORM = tuple(range(8, 21))
"""Bits of coefficients and operands that are compared."""

SHORTER = (1, 2, 4)
"""Bits by which one signal at a time is shortened."""

FRACTIONS = ("vector_fraction", "force_fraction")
"""Formats that are not word lengths but numbers of bits below one code."""


def uniform(base: TfraDesign, lengths: Sequence[int], family: Family = DEFAULT) -> tuple[Variation, ...]:
    """Designs whose coefficients and operands all have n bits, for each n of ``lengths``.

    Vectors keep the bits below one code that they have in ``base``, and one more for each bit that operands are longer
    than there; the other signals follow as :meth:`tfra.study.search.space.Space.uniform` says.  Facts are ``bits``,
    ``vector_fraction``, ``coefficient_kbit`` and ``dsp`` (of ``family``).
    """
    plain = replace(base, formats=replace(base.formats, signals=()))
    return tuple(_uniform(plain, bits, family) for bits in lengths)


def _uniform(base: TfraDesign, bits: int, family: Family) -> Variation:
    point = Space.uniform(base, bits)
    facts: Facts = {"bits": bits, "vector_fraction": point["vector_fraction"]}
    return _priced(Variation.of(facts, lambda: Space.design(base, point)), family)


def sensitivity(base: TfraDesign, family: Family = DEFAULT, shorter: Sequence[int] = SHORTER) -> tuple[Variation, ...]:
    """``base`` with one signal at a time ``shorter`` by a number of bits: every signal, and vector and force fraction.

    Facts are ``signal``, ``bits`` that it is left, ``shorter``, and the costs as for :func:`uniform`.  Choices that do
    not fit together are listed with the reason.
    """
    signals = (*base.signals, *FRACTIONS)
    return tuple(_priced(_shortened(base, signal, less), family) for signal in signals for less in shorter)


def _shortened(base: TfraDesign, signal: str, shorter: int) -> Variation:
    left = (getattr(base.formats, signal) if signal in FRACTIONS else base.formats.bits(signal)) - shorter
    facts: Facts = {"signal": signal, "bits": left, "shorter": shorter}
    return Variation.of(facts, lambda: Space.design(base, {signal: left}))


def _priced(made: Variation, family: Family) -> Variation:
    design = made.design
    costs: Facts = {
        "coefficient_kbit": None if design is None else coefficient_kbit(design),
        "dsp": None if design is None else dsp(design, family),
    }
    return replace(made, facts={**made.facts, **costs})
