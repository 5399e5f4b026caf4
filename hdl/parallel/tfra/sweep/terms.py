"""The sweep's terms: the contribution of a taxel to B^z and to B^xy, as functions of the candidate."""

from typing import Any

from amaranth import Module, Mux, Signal, Value, signed, unsigned
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.pipeline import delayed, driver, product_latency, registered_product
from tfra.hdl.parallel import payloads
from tfra.hdl.parallel.tfra.sweep.loader import TAXEL, WORDS, folded_taxel
from tfra.model.fixed.design import Design
from tfra.model.fixed.tfra.sweep import sweep_unit


def unit_shift(design: Design) -> int:
    """Places between K b and the stress in units of the sums."""
    return (sweep_unit(design) // design.search.steps).bit_length() - 1


def measured_sum(design: Design) -> int:
    """Bits of K times the sum of all positive stress."""
    return design.widths.magnitude + design.search.steps.bit_length()


def term(design: Design) -> data.StructLayout:
    """One taxel: ``x + k q`` counts for B^z, ``y + k r`` for B^xy, where positive; ``r = -q``, ``size = |q|``."""
    w = design.widths
    y = max(w.candidate, w.stress + design.search.steps.bit_length() + unit_shift(design)) + 1
    steps = {"q": signed(w.vector), "r": signed(w.vector), "size": unsigned(w.vector)}
    return data.StructLayout({"x": signed(w.candidate), "y": signed(y), **steps})


def terms_latency(design: Design) -> int:
    """Cycles from taking the last quad of q to the mark after its taxels."""
    return TAXEL + WORDS + 2 + product_latency(design.search.steps)


class Terms(wiring.Component):
    """``x = K (p - [negative] q)``, ``y = K b - x`` in units of the sums, and K times the sum of positive stress.

    Resources: two constant products by K, five adders; no multiplier.
    """

    def __init__(self, design: Design) -> None:
        self._design = design
        super().__init__({
            "i": In(folded_taxel(design)),  # the loader's taxels
            "ends": In(1),  # the loader takes a frame's last quad of e1
            "o": Out(term(design)),  # a term
            "valid": Out(1),  # there is a term in this cycle
            "ended": Out(1),  # pulse, in the cycle after a frame's last taxel
            "measured": Out(unsigned(measured_sum(design))),  # k times the sum of positive stress, from ``ended`` on
            "exponent": Out(payloads.frame_facts(design)["exponent"].shape),  # the frame's, from ``ended`` on
        })

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        w, i, steps = self._design.widths, self.i, self._design.search.steps
        start = Signal(signed(w.vector + 1), reset_less=True)
        m.d.sync += start.eq(i.p - Mux(i.negative, i.q, 0))
        wait = product_latency(steps)
        x = registered_product(m, start, steps)
        b = registered_product(m, delayed(m, i.stress, 1, "stress"), steps)
        q, valid = delayed(m, i.q, 1 + wait, "q"), delayed(m, i.valid, 1 + wait, "taxel_valid", control=True)
        complete = delayed(m, self.ends, terms_latency(self._design) - 1, "complete", control=True)
        o = driver(m, self.o)
        m.d.sync += [
            o.x.eq(x),
            o.y.eq((b << unit_shift(self._design)) - x),
            o.q.eq(q),
            o.r.eq(-q),
            o.size.eq(Mux(q < 0, -q, q)),
            self.valid.eq(valid),
            self.ended.eq(complete),
        ]
        self._measure(m, b, valid, complete)
        return m

    def _measure(self, m: Module, b: Value, valid: Value, complete: Value) -> None:
        """Sum K b where it is positive; the end of a frame hands it over and clears it."""
        total = Signal(measured_sum(self._design), name="stress_sum")
        with m.If(valid & ~b[-1]):
            m.d.sync += total.eq(total + b[:-1])
        exponent = delayed(m, self.i.exponent, 2 + product_latency(self._design.search.steps), "exponent")
        measured, frame_exponent = driver(m, self.measured), driver(m, self.exponent)
        with m.If(complete):
            m.d.sync += total.eq(0)
            m.d.sync += measured.eq(total)
            m.d.sync += frame_exponent.eq(exponent)
