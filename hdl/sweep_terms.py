"""The sweep's terms: what a taxel adds to B^z and to B^xy, as functions of the candidate."""

from __future__ import annotations

from typing import Any

from amaranth import C, Cat, Module, Mux, Signal, Value, signed, unsigned
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl import payloads
from tfra.hdl.pipeline import delayed, driver, product_latency, register, registered_product
from tfra.hdl.sweep_loader import TAXEL, at_once, folded_taxel, places
from tfra.model.design import Design
from tfra.model.fixed.sweep import sweep_unit
from tfra.model.fixed.widths import widths


def unit_shift(design: Design) -> int:
    """Places between K b and the stress in units of the sums."""
    return (sweep_unit(design) // design.search.steps).bit_length() - 1


def measured_sum(design: Design) -> int:
    """Bits of K times the sum of all positive stress."""
    return widths(design).magnitude + design.search.steps.bit_length()


def term(design: Design) -> data.StructLayout:
    """One taxel: ``x + k q`` counts for B^z, ``y + k r`` for B^xy, where positive; ``r = -q``, ``size = |q|``."""
    w = widths(design)
    y = max(w.candidate, w.stress + design.search.steps.bit_length() + unit_shift(design)) + 1
    steps = {"q": signed(w.vector), "r": signed(w.vector), "size": unsigned(w.vector)}
    return data.StructLayout({"x": signed(w.candidate), "y": signed(y), **steps})


def terms_latency(design: Design) -> int:
    """Cycles from taking the last quad of q to the mark behind its taxels."""
    return TAXEL + places(design) + 2 + product_latency(design.search.steps)


class Terms(wiring.Component):
    """``x = K (p - [negative] q)``, ``y = K b - x`` in units of the sums, and K times the sum of positive stress.

    Members:
        i: the loader's taxels; ``ends``: it takes a frame's last quad.
        o, valid: their terms, and which of them are there; ``ended``: the cycle behind a frame's last taxel.
        measured, exponent: K times the sum of positive stress and the frame's exponent, two cycles behind ``ended``.

    Resources: for each taxel of a cycle two constant products by K and five adders; no multiplier.
    """

    def __init__(self, design: Design) -> None:
        self._design = design
        ways = at_once(design)
        super().__init__(
            {
                "i": In(folded_taxel(design)).array(ways),
                "ends": In(1),
                "o": Out(term(design)).array(ways),
                "valid": Out(ways),
                "ended": Out(1),
                "measured": Out(unsigned(measured_sum(design))),
                "exponent": Out(payloads.frame_facts(design)["exponent"].shape),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        wait = product_latency(self._design.search.steps)
        valid = delayed(m, Cat(i.valid for i in self.i), 1 + wait, control=True)
        complete = delayed(m, self.ends, terms_latency(self._design) - 1, control=True)
        m.d.sync += [self.valid.eq(valid), self.ended.eq(complete)]
        stress = [self._term(m, i, driver(m, o)) for i, o in zip(self.i, self.o, strict=True)]
        positive = sum((Mux(there & ~b[-1], b[:-1], 0) for b, there in zip(stress, valid, strict=True)), C(0))
        exponent = delayed(m, self.i[0].exponent, 3 + wait)
        self._measure(m, register(m, positive, "positive"), register(m, complete, control=True), exponent)
        return m

    def _term(self, m: Module, i: data.View, o: data.View) -> Value:
        """The term of a taxel, and K b a cycle ahead of it."""
        w, steps = widths(self._design), self._design.search.steps
        start = Signal(signed(w.vector + 1), reset_less=True)
        m.d.sync += start.eq(i.p - Mux(i.negative, i.q, 0))
        x = registered_product(m, start, steps)
        b = registered_product(m, delayed(m, i.stress, 1), steps)
        q = delayed(m, i.q, 1 + product_latency(steps))
        m.d.sync += [
            o.x.eq(x),
            o.y.eq((b << unit_shift(self._design)) - x),
            o.q.eq(q),
            o.r.eq(-q),
            o.size.eq(Mux(q < 0, -q, q)),
        ]
        return b

    def _measure(self, m: Module, positive: Value, complete: Value, exponent: Value) -> None:
        """Sum K b where it is positive; the end of a frame hands it over and clears it."""
        total = Signal(measured_sum(self._design))
        measured, kept = driver(m, self.measured), driver(m, self.exponent)
        m.d.sync += total.eq(total + positive)
        with m.If(complete):
            m.d.sync += [total.eq(0), measured.eq(total), kept.eq(exponent)]
