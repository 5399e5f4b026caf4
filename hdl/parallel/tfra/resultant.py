"""Resultant of the unscaled forces (Eq. 12), see :mod:`tfra.model.fixed.tfra.resultant`."""

from __future__ import annotations

from typing import Any

from amaranth import Module, Mux, Signal, Value, signed
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.arithmetic import round_top
from tfra.hdl.lib.pipeline import ALIGN, ahead, align, driver
from tfra.hdl.lib.streams import one_at_a_time
from tfra.hdl.parallel import payloads
from tfra.model.fixed.design import Design
from tfra.model.fixed.scalars import scalar_fraction

# Cycles of the schedule; registers are loaded at the end of theirs.
_LOAD = range(0, 6)
_ADD = range(_LOAD.start + 2, _LOAD.stop + 2)  # after the multiplier
_ZEROS = _ADD.stop + 2  # after the OR of the sums and the first half of its zeros
_ALIGN = range(_ZEROS + 1, _ZEROS + 4)
_ROUND = range(_ALIGN.start + ALIGN, _ALIGN.stop + ALIGN)
_LAST = _ROUND.stop - 1


class Resultant(wiring.Component):
    """F* = A_p0 + mu_x A_p1 + mu_y A_p2 for p = x, y, z, normalised together; F_x = F_y = 0 when nothing is swept.

    ::

        affine.sums ─▶ select ─▶ x mu_x, x mu_y ─▶ + ─▶ F_x, F_y, F_z ─▶ align ─▶ round ─▶ total

    Members:
        affine, frame: facts of the frame; the calculation waits for them.
        chosen: mu_x and mu_y, taken at once.
        total: the result, one transfer a frame; the next chosen is taken when it has left.

    Resources: one operand x operand multiplier, used six times.
    """

    def __init__(self, design: Design) -> None:
        self.design = design
        super().__init__(
            {
                "affine": In(stream.Signature(payloads.affine(design))),
                "chosen": In(stream.Signature(payloads.chosen(design))),
                "frame": In(stream.Signature(payloads.frame_facts(design))),
                "total": Out(stream.Signature(payloads.total(design))),
            }
        )

    @property
    def latency(self) -> int:
        """Cycles from the transfer of ``chosen``, the facts being there, to that of ``total``."""
        return 1 + _LAST + 1

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        operand = self.design.formats.operand
        factors = [Signal(signed(operand), name=name, reset_less=True) for name in ("factor", "next_factor")]
        cycle = self._control(m, factors)
        exact = self._products(m, factors[0], cycle)
        self._normalise(m, exact, cycle)
        return m

    def _control(self, m: Module, factors: list[Signal]) -> Value:
        """Cycle of the schedule, zero until chosen and facts are there; mu_x and mu_y take turns."""
        facts = (self.affine, self.frame)
        cycle, busy = one_at_a_time(m, self.chosen, facts, self.total, _LAST)
        chosen = self.chosen.payload
        first = ahead(m, cycle, _ALIGN[:1])
        m.d.comb += [fact.ready.eq(first) for fact in facts]
        with m.If(~busy):
            m.d.sync += [factors[0].eq(chosen.mu_x), factors[1].eq(chosen.mu_y)]
        with m.Elif(cycle != 0):
            m.d.sync += [factors[0].eq(factors[1]), factors[1].eq(factors[0])]
        return cycle

    def _products(self, m: Module, factor: Value, cycle: Value) -> list[Signal]:
        """F_z, F_y, F_x: exact, with a scalar's fraction bits."""
        operand, fraction = self.design.formats.operand, scalar_fraction(self.design)
        word, start = (Signal(signed(operand), name=name, reset_less=True) for name in ("word", "start"))
        product = Signal(signed(2 * operand), reset_less=True)
        exact = [Signal(signed(2 * operand + 1), name=f"exact{n}", reset_less=True) for n in range(3)]
        facts, sums = self.frame.payload, self.affine.payload.sums
        with m.Switch(cycle):
            for turn in _LOAD:
                row, second = divmod(turn, 2)
                swept = 1 if row == 2 else facts.contact & facts.traction
                with m.Case(turn):
                    m.d.sync += word.eq(Mux(swept, sums[3 * row + 1 + second], 0))
                    if second:
                        m.d.sync += start.eq(Mux(swept, sums[3 * row], 0))
        m.d.sync += product.eq(word * factor)
        second = cycle[0] ^ (_ADD.start & 1)
        add = ahead(m, cycle, _ADD)
        with m.If(add):
            m.d.sync += exact[0].eq(Mux(second, exact[0], start << fraction) + product)
        with m.If((add & ~second) | ahead(m, cycle, _ALIGN)):
            m.d.sync += [exact[1].eq(exact[0]), exact[2].eq(exact[1])]
        return exact

    def _normalise(self, m: Module, exact: list[Signal], cycle: Value) -> None:
        """The three sums at division length, one each cycle; first comes F_x."""
        width, bits = len(exact[0]), self.design.widths.division
        total = driver(m, self.total.payload)
        words, exponent = total.words, total.exponent
        aligned, zeros = align(m, exact, exact[2], ahead(m, cycle, range(_ZEROS, _ZEROS + 1)))
        with m.If(self.frame.ready):
            # operand - 1 - affine.significant + fraction + bits - 1 - (width - 1 - zeros)
            fixed = self.design.formats.operand - 1 + scalar_fraction(self.design) + bits - width
            m.d.sync += exponent.eq(fixed - self.affine.payload.significant + zeros)
        with m.If(ahead(m, cycle, _ROUND)):
            m.d.sync += [words[0].eq(words[1]), words[1].eq(words[2]), words[2].eq(round_top(aligned, bits))]
