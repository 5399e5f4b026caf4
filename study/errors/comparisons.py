"""The comparisons of a study: a function each, from the design of CONFIG to its variations.

Choices that do not fit together are listed with the reason.
"""

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from itertools import product

from tfra.families import Family
from tfra.model.choices import Adc, Search
from tfra.model.fixed.design import Design
from tfra.model.rounding import Rounding
from tfra.study.errors.cascade import Step
from tfra.study.errors.variation import Facts, Variation
from tfra.study.search.costs import coefficient_kbit, dsp
from tfra.study.search.space import Space

FRACTIONS = ("vector_fraction", "force_fraction")
"""Formats that are not word lengths but numbers of bits below one code."""


def uniform(base: Design, lengths: Sequence[int], family: Family) -> tuple[Variation, ...]:
    """Designs whose coefficients and operands all have n bits, for each n of ``lengths``.

    Vectors keep the bits below one code that they have in ``base``, and one more for each bit that operands are longer
    than there; the other signals follow as :meth:`tfra.study.search.space.Space.uniform` says.  Facts are ``bits``,
    ``vector_fraction``, ``coefficient_kbit`` and ``dsp`` (of ``family``).
    """
    plain = replace(base, formats=replace(base.formats, signals=()))
    return tuple(_uniform(plain, bits, family) for bits in lengths)


def _uniform(base: Design, bits: int, family: Family) -> Variation:
    point = Space.uniform(base, bits)
    facts: Facts = {"bits": bits, "vector_fraction": point["vector_fraction"]}
    return _priced(Variation.of(facts, lambda: Space.design(base, point)), family)


def sensitivity(base: Design, family: Family, shorter: Sequence[int]) -> tuple[Variation, ...]:
    """``base`` with one signal at a time ``shorter`` by a number of bits: every signal, and vector and force fraction.

    Facts are ``signal``, ``bits`` that it is left, ``shorter``, and the costs as for :func:`uniform`.
    """
    signals = (*base.used_signals, *FRACTIONS)
    return tuple(_priced(_shortened(base, signal, less), family) for signal in signals for less in shorter)


def _shortened(base: Design, signal: str, shorter: int) -> Variation:
    left = (getattr(base.formats, signal) if signal in FRACTIONS else base.formats.bits(signal)) - shorter
    facts: Facts = {"signal": signal, "bits": left, "shorter": shorter}
    return Variation.of(facts, lambda: Space.design(base, {signal: left}))


def _priced(variation: Variation, family: Family) -> Variation:
    design = variation.design
    costs: Facts = {
        "coefficient_kbit": None if design is None else coefficient_kbit(design),
        "dsp": None if design is None else dsp(design, family),
    }
    return replace(variation, facts={**variation.facts, **costs})


def converters(base: Design, bits: Sequence[int], noise: Sequence[float]) -> tuple[Variation, ...]:
    """``base`` after every converter and every noise; facts are ``noise_share_of_peak`` and ``bits``.

    All have the same exact stress, the drawn offsets and the same noise, scaled.  Full scale stays, and so do a
    given contact threshold and the plateau tolerance, as stress; without a threshold, each converter has its default.
    """
    compared = Step.NOISE, Step.CONVERTER, Step.ARITHMETIC
    return tuple(
        Variation.of({"noise_share_of_peak": n, "bits": b}, partial(behind, base, b), compared=compared, noise=n)
        for n, b in product(noise, bits)
    )


def behind(base: Design, bits: int) -> Design:
    """``base`` after a converter of ``bits``; raises ``ValueError`` where an operand is shorter than its codes."""
    more, threshold = bits - base.adc.bits, base.adc.contact_threshold
    if threshold is not None:
        threshold = round(math.ldexp(threshold, more))
    search = Search(base.search.steps, math.ldexp(base.search.tolerance, more))
    return replace(base, adc=Adc(bits, base.adc.full_scale, threshold), search=search)


def variants(base: Design, steps: Sequence[int], tolerances: Sequence[float]) -> tuple[Variation, ...]:
    """``base`` with every rounding of its products; one that sweeps also with other steps and other tolerances.

    Facts are ``variant``, what is varied, and all three settings: ``steps``, ``plateau_tolerance_lsb``, ``rounding``.
    Steps and tolerance are those of the float steps, too, so that all steps are compared; of rounding, arithmetic.
    """
    search, formats = base.search, base.formats
    rounded = (_variant("rounding", replace(base, formats=replace(formats, rounding=each))) for each in Rounding)
    if not base.sweeps:
        return tuple(rounded)
    return (
        *(_variant("steps", replace(base, search=replace(search, steps=count))) for count in steps),
        *(_variant("plateau_tolerance", replace(base, search=replace(search, tolerance=each))) for each in tolerances),
        *rounded,
    )


def _variant(variant: str, design: Design) -> Variation:
    facts: Facts = {
        "variant": variant,
        "steps": design.search.steps,
        "plateau_tolerance_lsb": design.search.tolerance,
        "rounding": str(design.formats.rounding),
    }
    return Variation.of(facts, lambda: design, compared=(Step.ARITHMETIC,) if variant == "rounding" else tuple(Step))
