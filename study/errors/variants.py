"""Choices other than word lengths: steps of the sweep, plateau tolerance, rounding of products."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.rounding import Rounding
from tfra.study.errors.cascade import Step
from tfra.study.errors.variation import Facts, Variation

STEPS = (10, 20, 50, 100, 200, 500)
"""K: mu is found in steps of 1/K."""

TOLERANCES = (0.0, 0.01, 0.03, 0.1, 0.3, 1.0, 3.0)
"""In LSB of the converter, summed over the array."""


def variants(
    base: TfraDesign, steps: Sequence[int] = STEPS, tolerances: Sequence[float] = TOLERANCES
) -> tuple[Variation, ...]:
    """``base`` with other steps, with other tolerances, and with every rounding of its products.

    Facts are ``variant``, what is varied, and all three settings: ``steps``, ``plateau_tolerance_lsb``, ``rounding``.
    Steps and tolerance are those of the float steps, too, so that all steps are compared; of rounding, arithmetic.
    """
    return (
        *(_searched(base, "steps", steps=count) for count in steps),
        *(_searched(base, "plateau_tolerance", tolerance=tolerance) for tolerance in tolerances),
        *(_rounded(base, rounding) for rounding in Rounding),
    )


def _searched(base: TfraDesign, variant: str, **changes: Any) -> Variation:
    design = replace(base, search=replace(base.search, **changes))
    return Variation.of(_facts(variant, design), lambda: design, compared=tuple(Step))


def _rounded(base: TfraDesign, rounding: Rounding) -> Variation:
    design = replace(base, formats=replace(base.formats, rounding=rounding))
    return Variation.of(_facts("rounding", design), lambda: design)


def _facts(variant: str, design: TfraDesign) -> Facts:
    search = design.search
    return {
        "variant": variant,
        "steps": search.steps,
        "plateau_tolerance_lsb": search.tolerance,
        "rounding": str(design.formats.rounding),
    }
