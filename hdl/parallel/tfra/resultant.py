"""Resultant of the unscaled forces (Eq. 12), see :mod:`tfra.model.fixed.tfra.resultant`."""

from typing import Any, NamedTuple

from amaranth import Module, Mux, Signal, Value, signed
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.arithmetic import later, once, round_top
from tfra.hdl.lib.pipeline import ALIGN, align, driver, lookahead
from tfra.hdl.lib.streams import one_at_a_time
from tfra.hdl.parallel import payloads
from tfra.model.fixed.design import Design
from tfra.model.fixed.widths import scalar_fraction


class _Product(NamedTuple):
    """A row of the schedule: ``operand`` times ``factor``, added to a force; the first of a force to ``start``."""

    force: str
    operand: tuple[int, int]
    """p, q of an A_pq."""
    factor: str
    """Of the chosen candidate."""
    start: tuple[int, int]
    """p, q of the A_pq that is added, too."""
    swept: bool
    """All of it is zero when nothing is swept."""


_PRODUCTS = (
    _Product("F_x", (0, 1), "mu_x", (0, 0), True),
    _Product("F_x", (0, 2), "mu_y", (0, 0), True),
    _Product("F_y", (1, 1), "mu_x", (1, 0), True),
    _Product("F_y", (1, 2), "mu_y", (1, 0), True),
    _Product("F_z", (2, 1), "mu_x", (2, 0), False),
    _Product("F_z", (2, 2), "mu_y", (2, 0), False),
)
"""One a cycle: the operand of row n is loaded in cycle ``_LOAD[n]``, its product is added in cycle ``_ADD[n]``."""

# Schedule: the cycles of each step; its registers are loaded at their end.
_LOAD = range(len(_PRODUCTS))  # operand and factor; with a force's second ones the ``start`` of its sum
_MULTIPLY = later(_LOAD, 1)  # operand times factor
_ADD = later(_MULTIPLY, 1)  # the product to its force
_OR, _HALF_ZEROS, _ZEROS = later(range(3), _ADD.stop)  # zeros that all forces have after their signs
_ALIGN = later(range(3), _ZEROS + 1)  # a force a cycle to the barrel: F_x, F_y, F_z
_ROUND = later(_ALIGN, ALIGN)  # rounded, into ``total``
_LAST = _ROUND.stop - 1


class Resultant(wiring.Component):
    """F* = A_p0 + mu_x A_p1 + mu_y A_p2 for p = x, y, z, normalised together; F_x = F_y = 0 when nothing is swept.

    ::

        affine.sums ─▶ select ─▶ x mu_x, x mu_y ─▶ + ─▶ F_x, F_y, F_z ─▶ align ─▶ round ─▶ total

    ``_PRODUCTS`` is the schedule of the multiplier, from which operands and factors are chosen.

    Resources: one multiplier of sums by a scalar, used six times.
    """

    def __init__(self, design: Design) -> None:
        self.design = design
        super().__init__({
            "affine": In(stream.Signature(payloads.affine(design))),  # fact of the frame, waited for
            # ``mu_x`` and ``mu_y``; the next one is taken when ``total`` has left.
            "chosen": In(stream.Signature(payloads.chosen(design))),
            "frame": In(stream.Signature(payloads.frame_facts(design))),  # fact of the frame, waited for
            "total": Out(stream.Signature(payloads.total(design))),  # the result, one transfer a frame
        })

    @property
    def latency(self) -> int:
        """Cycles from the transfer of ``chosen``, the facts being there, to that of ``total``."""
        return 1 + _LAST + 1

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        cycle, factor = self._control(m)
        forces = self._products(m, factor, cycle)
        self._normalise(m, forces, cycle)
        return m

    def _control(self, m: Module) -> tuple[Value, Signal]:
        """Cycle of the schedule, zero until chosen and facts are there; the factor, which alternates."""
        facts, bits = (self.affine, self.frame), self.design.formats.bits("scalar")
        cycle, busy = one_at_a_time(m, self.chosen, facts, self.total, _LAST)
        taken = lookahead(m, cycle, once(_ALIGN.start))
        m.d.comb += [fact.ready.eq(taken) for fact in facts]
        factor = Signal(signed(bits), reset_less=True)
        next_factor = Signal(signed(bits), reset_less=True)
        first, second = (self.chosen.payload[product.factor] for product in _PRODUCTS[:2])
        with m.If(~busy):
            m.d.sync += factor.eq(first)
            m.d.sync += next_factor.eq(second)
        with m.Elif(cycle != 0):
            m.d.sync += factor.eq(next_factor)
            m.d.sync += next_factor.eq(factor)
        return cycle, factor

    def _products(self, m: Module, factor: Value, cycle: Value) -> list[Signal]:
        """F_z, F_y, F_x: exact, with a scalar's fraction bits; each enters the first register and moves on."""
        formats, fraction = self.design.formats, scalar_fraction(self.design)
        length = formats.bits("sums") + formats.bits("scalar")
        word, start = self._operands(m, cycle)
        product = Signal(signed(length), reset_less=True)
        f_z, f_y, f_x = forces = [Signal(signed(length + 1), name=n, reset_less=True) for n in ("f_z", "f_y", "f_x")]
        m.d.sync += product.eq(word * factor)
        second = cycle[0] ^ (_ADD.start & 1)
        add = lookahead(m, cycle, _ADD)
        with m.If(add):
            m.d.sync += f_z.eq(Mux(second, f_z, start << fraction) + product)
        with m.If((add & ~second) | lookahead(m, cycle, _ALIGN)):
            m.d.sync += f_y.eq(f_z)
            m.d.sync += f_x.eq(f_y)
        return forces

    def _operands(self, m: Module, cycle: Value) -> tuple[Signal, Signal]:
        """Operand of a product, and what its force's sum starts with."""
        bits = self.design.formats.bits("sums")
        word = Signal(signed(bits), reset_less=True)
        start = Signal(signed(bits), reset_less=True)
        with m.Switch(cycle):
            for number, (load, product) in enumerate(zip(_LOAD, _PRODUCTS, strict=True)):
                pair = _PRODUCTS[number - number % 2]
                assert (product.force, product.factor) == (pair.force, _PRODUCTS[number % 2].factor)
                facts = self.frame.payload
                counts = facts.contact & facts.traction if product.swept else 1
                with m.Case(load):
                    m.d.sync += word.eq(Mux(counts, self._sum(product.operand), 0))
                    if number % 2:
                        m.d.sync += start.eq(Mux(counts, self._sum(product.start), 0))
        return word, start

    def _sum(self, indices: tuple[int, int]) -> Value:
        """A_pq of the frame."""
        p, q = indices
        word: Value = self.affine.payload.sums[3 * p + q]
        return word

    def _normalise(self, m: Module, forces: list[Signal], cycle: Value) -> None:
        """The three forces at division length, one each cycle; first comes F_x."""
        width, bits = len(forces[0]), self.design.widths.division
        total = driver(m, self.total.payload)
        words, exponent = total.words, total.exponent
        aligned, zeros = align(m, forces, forces[-1], lookahead(m, cycle, once(_ZEROS)))
        with m.If(self.frame.ready):
            # sums - 1 - affine.significant + fraction + bits - 1 - (width - 1 - zeros)
            fixed = self.design.formats.bits("sums") - 1 + scalar_fraction(self.design) + bits - width
            m.d.sync += exponent.eq(fixed - self.affine.payload.significant + zeros)
        with m.If(lookahead(m, cycle, _ROUND)):
            m.d.sync += words[0].eq(words[1])
            m.d.sync += words[1].eq(words[2])
            m.d.sync += words[2].eq(round_top(aligned, bits))
