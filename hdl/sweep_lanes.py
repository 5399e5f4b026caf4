"""The sweep's sums: B^z and S - M of P candidates at once."""

from __future__ import annotations

from typing import Any

from amaranth import Module, Mux, Signal, Value, signed, unsigned
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.pipeline import delayed, product_latency, registered_product
from tfra.hdl.sweep_passes import swept_taxel, swept_words
from tfra.model.design import Design
from tfra.model.fixed.sweep import sweep_unit
from tfra.model.fixed.widths import widths


def lane_levels(design: Design) -> int:
    """Additions in a row between x and the last lane, and levels of the comparator tree: ``ceil(log2 P)``."""
    return (design.architecture.sweep_lanes - 1).bit_length()


def lanes_latency(design: Design) -> int:
    """Cycles from the lanes' last taxel to the one before their sums stand."""
    return 1 + max(lane_levels(design), product_latency(design.search.steps))


class Lanes(wiring.Component):
    """``z[c] = sum of max(0, x + c q)``, ``xy[c] = sum of max(0, K b - x - c q)`` minus the measured sum.

        x, q -- level 0: x, x + q -- level 1: + 2 q -- ... -- P values -- max(0, .) -- sums z
        b ---- times K ------------------------------------------------ minus ------ max(0, .) -- sums xy

    Both sums are zero from ``clear`` on.  P - 1 additions make the P candidates, since every level adds ``q << level``
    to all that are there.  ``ended`` is high in the cycle before the sums of a pass stand.

    A sum never leaves its word for candidates up to K; lanes beyond wrap, each for itself.

    Resources: per lane 4 adders of about ``widths.b_xy`` bits.
    """

    def __init__(self, design: Design) -> None:
        self._design, w = design, widths(design)
        lanes = design.architecture.sweep_lanes
        super().__init__(
            {
                "i": In(swept_taxel(design)),
                "clear": In(1),
                "ended": Out(1),
                "z": Out(unsigned(w.b_z)).array(lanes),
                "xy": Out(signed(w.b_xy + 1)).array(lanes),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        w, design = widths(self._design), self._design
        wait, steps = lanes_latency(design), design.search.steps
        depth = wait - 1
        # K b of every word is at hand when the last level of x is.
        b = delayed(m, self.i.words.b, depth - product_latency(steps))
        unit = Signal(signed(w.b_xy + 1))
        m.d.comb += unit.eq(registered_product(m, b, steps) << (sweep_unit(design) // steps).bit_length() - 1)
        valid = delayed(m, self.i.valid, wait, control=True)
        measured = delayed(m, self.i.measured, wait, control=True)
        m.d.comb += self.ended.eq(measured)
        for number, x in enumerate(self._candidates(m, depth - lane_levels(design))):
            self._sums(m, x, unit, valid, measured, number)
        return m

    def _candidates(self, m: Module, wait: int) -> list[Value]:
        words = data.View(swept_words(self._design), delayed(m, self.i.words.as_value(), wait))
        lanes, slope = [words.x], words.q
        for level in range(lane_levels(self._design)):
            values = [*lanes, *(x + (slope << level) for x in lanes)][: self._design.architecture.sweep_lanes]
            lanes = []
            for value in values:
                x = Signal(signed(widths(self._design).candidate), reset_less=True)
                m.d.sync += x.eq(value)
                lanes.append(x)
            slope = delayed(m, slope, 1)
        return lanes

    def _sums(self, m: Module, x: Value, unit: Value, valid: Value, measured: Value, number: int) -> None:
        w = widths(self._design)
        plus, minus = Signal(w.candidate - 1, reset_less=True), Signal(signed(w.b_xy + 1), reset_less=True)
        z, xy = Signal(w.b_z, reset_less=True), Signal(signed(w.b_xy + 1), reset_less=True)
        m.d.sync += [plus.eq(Mux(x < 0, 0, x)), minus.eq(unit - x)]
        with m.If(valid):
            m.d.sync += [z.eq(z + plus), xy.eq(xy + Mux((minus < 0) & ~measured, 0, minus))]
        with m.If(self.clear):
            m.d.sync += [z.eq(0), xy.eq(0)]
        m.d.comb += [self.z[number].eq(z), self.xy[number].eq(xy)]
