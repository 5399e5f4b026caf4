"""Necessary bits of the converter, by the noise before it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import partial

from tfra.model.choices import Adc, Search
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.study.errors.cascade import Step
from tfra.study.errors.variation import Variation

BITS = tuple(range(8, 17))
"""Bits of the converters that are compared."""

NOISE = (0.0, 0.0005, 0.001, 0.002, 0.005)
"""Deviations of every taxel's noise, as shares of the frame's peak."""


def converters(base: TfraDesign, bits: Sequence[int] = BITS, noise: Sequence[float] = NOISE) -> tuple[Variation, ...]:
    """``base`` after every converter and every noise; facts are ``noise_share_of_peak`` and ``bits``.

    All have the same exact stress, the drawn offsets and the same noise, scaled.  Full scale stays, and so do a
    given contact threshold and the plateau tolerance, as stress; without a threshold, each converter has its default.
    """
    compared = Step.NOISE, Step.CONVERTER, Step.ARITHMETIC
    return tuple(
        Variation.of(
            {"noise_share_of_peak": level, "bits": length},
            partial(behind, base, length),
            compared=compared,
            noise=level,
        )
        for level in noise
        for length in bits
    )


def behind(base: TfraDesign, bits: int) -> TfraDesign:
    """``base`` after a converter of ``bits``; raises ``ValueError`` where an operand is shorter than its codes."""
    more, threshold = bits - base.adc.bits, base.adc.contact_threshold
    if threshold is not None:
        threshold = round(math.ldexp(threshold, more))
    search = Search(base.search.steps, math.ldexp(base.search.tolerance, more))
    return replace(base, adc=Adc(bits, base.adc.full_scale, threshold), search=search)
