"""Windows that differ in their word lengths, and converters: variations of the design of CONFIG's window."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import product
from typing import Any

import polars as pl

from tfra.model.choices import Adc, Search
from tfra.study.errors.cascade import Step, View
from tfra.study.errors.statistics import ERRORS, INTERVAL
from tfra.study.errors.variation import Facts, Variation
from tfra.study.skins.cascade import SIGNED
from tfra.study.skins.statistics import ALL, KINDS, errors, finding

COLUMNS = ERRORS | {
    "contacts": pl.Int64,
    "left_out": pl.Int64,
    **dict.fromkeys([f"{kind}{end}" for kind in KINDS for end in ("", *INTERVAL)], pl.Float64),
    "reason": pl.String,
}
"""Columns of :func:`rows` behind the facts, with their types."""


def uniform(window: Any, lengths: Sequence[int]) -> tuple[Variation, ...]:
    """Designs whose coefficients and operands all have n bits, for each n of ``lengths``.

    The operand of single values is at least as long as the codes.  Vectors have a bit more below one code for each bit
    that operands are longer than in ``window``.  Facts are ``bits`` and ``coefficient_kbit``.
    """
    return tuple(_uniform(window, bits) for bits in lengths)


def _uniform(window: Any, bits: int) -> Variation:
    formats, codes = window.formats, window.adc.bits
    own = [(name, bits) for name in window.signals if name.startswith("operand.")]
    chosen = replace(
        formats,
        name="custom",
        coefficient=bits,
        operand=max(bits, codes),
        vector_fraction=min(16, formats.vector_fraction + max(0, bits - formats.operand)),
        signals=tuple(own) if bits < codes else (),
    )
    made = Variation.of({}, lambda: replace(window, formats=chosen))
    cost = made.design.coefficient_bits / 1000 if made.design else None
    return replace(made, facts={"bits": bits, "coefficient_kbit": cost})


def converters(window: Any, bits: Sequence[int], noise: Sequence[float]) -> tuple[Variation, ...]:
    """``window`` behind every converter and every noise; facts are ``noise_share_of_peak`` and ``bits``.

    All have the same exact stress, the drawn offsets and the same noise, scaled.  Full scale stays, and so does a given
    contact threshold, as stress; without one, each converter has its default.
    """
    compared = Step.NOISE, Step.CONVERTER, Step.ARITHMETIC
    return tuple(
        _behind(window, b, {"noise_share_of_peak": n, "bits": b}, compared, n) for n, b in product(noise, bits)
    )


def _behind(window: Any, bits: int, facts: Facts, compared: tuple[Step, ...], noise: float) -> Variation:
    more, threshold = bits - window.adc.bits, window.adc.contact_threshold
    if threshold is not None:
        threshold = round(math.ldexp(threshold, more))
    search = Search(window.search.steps, math.ldexp(window.search.tolerance, more))
    adc = Adc(bits, window.adc.full_scale, threshold)
    return Variation.of(facts, lambda: replace(window, adc=adc, search=search), compared=compared, noise=noise)


def rows(variation: Variation, scores: pl.DataFrame | None) -> Iterator[dict[str, Any]]:
    """Rows of a variation's table: its facts, then the columns of :func:`tfra.study.skins.statistics.errors`.

    After them are the ``contacts`` that are there, how many are ``left_out``, since a step misses them, the rates of
    ``KINDS`` at the row's step with their intervals, and the ``reason`` why all of it is null.
    """
    if variation.design is None or scores is None:
        for quantity, step, view in product(SIGNED, variation.compared, View):
            name = {"quantity": quantity, "step": step, "view": view, "reason": variation.reason}
            yield {**variation.facts, **dict.fromkeys(COLUMNS), **name}
        return
    rates: dict[str, dict[str, float]] = {step: {} for step in variation.compared}
    for row in finding(scores, variation.compared, splits=(ALL,)).rows(named=True):
        rates[row["step"]] |= {f"{row['kind']}{end}": row[f"rate{end}"] for end in ("", *INTERVAL)}
    left_out = len(scores) - scores["everywhere"].sum()
    for row in errors(scores, variation.compared).rows(named=True):
        common = {"contacts": len(scores), "left_out": left_out, **rates[row["step"]], "reason": None}
        yield {**variation.facts, **row, **common}
