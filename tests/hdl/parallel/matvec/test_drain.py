"""A word's way through the drain gives the model's words in every rounding."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from amaranth import Module, signed
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from tests.model.cases import make_design
from tfra.hdl.parallel.matvec.drain import FINE, on_grid
from tfra.model.cover.scenes import SENSORS
from tfra.model.fixed.numbers import round_shift
from tfra.model.rounding import Rounding
from tfra.sim.harness import play

DESIGN = make_design(SENSORS["10×10, 4×2 mm, h 3 mm"])
WIDTHS = DESIGN.widths
LATENCY = 3
LONGEST = 35
"""Shift of a sum that leaves its sign alone."""


class Word(wiring.Component):
    """``result`` is ``sum``, ``alignment`` places to the left of the grid, shifted to the right by ``shift``."""

    def __init__(self, rounding: Rounding) -> None:
        super().__init__(
            {
                "sum": In(signed(WIDTHS.accumulator)),
                "shift": In(6),
                "result": Out(signed(WIDTHS.vector)),
            }
        )
        self._design = replace(DESIGN, formats=replace(DESIGN.formats, rounding=rounding))

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.d.comb += self.result.eq(on_grid(m, self._design, 0, self.sum, self.shift))
        return m


def results(rounding, sums, shifts):
    """Words of the gateware, ``shifts`` as the model counts them: to the left below zero."""
    cycles = [{"sum": s, "shift": shift + WIDTHS.alignment} for s, shift in zip(sums, shifts, strict=True)]
    seen = play(Word(rounding), [*cycles, *[{}] * LATENCY], ["result"])
    return [record["result"] for record in seen[LATENCY:]]


@pytest.mark.parametrize("rounding", Rounding)
def test_halves_at_both_steps_of_the_shift(rounding):
    """Halves; a bit beside a half; no shift; to the left."""
    sums = [k << (far - 1) for far in (1, FINE, 20, 34) for k in range(-4, 5)]
    shifts = [far for far in (1, FINE, 20, 34) for _ in range(-4, 5)]
    sums += [(1 << 19) + 1, -(1 << 19) + 1, (1 << 19) + (1 << 18), -(3 << 19) - 1, -3, 0, 7, -3, 0, 7]
    shifts += [20] * 4 + [0] * 3 + [-1] * 3
    assert WIDTHS.alignment == 1
    assert results(rounding, sums, shifts) == round_shift(sums, shifts, rounding).tolist()


@pytest.mark.parametrize("rounding", Rounding)
def test_words_are_the_models(rounding):
    """Any sums and shifts whose results are words: all bits, few, and ties."""
    rng, count = np.random.default_rng(1), 600
    shifts = rng.integers(-WIDTHS.alignment, LONGEST + 1, count)
    bits = np.minimum(WIDTHS.accumulator - 1, WIDTHS.vector - 2 + shifts)
    sums = rng.integers(-(1 << 62), 1 << 62, count) >> (62 - rng.integers(0, bits + 1))
    ties = (shifts > 0) & (shifts < bits) & (rng.random(count) < 0.3)
    place = np.where(ties, shifts, 1)
    sums = np.where(ties, (sums >> place << place) + (1 << (place - 1)), sums)
    assert results(rounding, sums.tolist(), shifts.tolist()) == round_shift(sums, shifts, rounding).tolist()
