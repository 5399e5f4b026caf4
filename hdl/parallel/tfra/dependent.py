"""alpha and beta of the dependent friction (Eqs. 12, 17, 18), see :mod:`tfra.model.fixed.tfra.dependent`."""

from __future__ import annotations

from functools import reduce
from operator import or_
from typing import Any

from amaranth import Cat, Module, Mux, Signal, Value, signed
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.arithmetic import add_or_subtract, counter_shape, magnitude_bits, round_top
from tfra.hdl.lib.divider import Divider
from tfra.hdl.lib.pipeline import ALIGN, ahead, align, register
from tfra.hdl.parallel import payloads
from tfra.model.fixed.butterfly import EE, OO, OX, OY
from tfra.model.fixed.design import Design
from tfra.model.fixed.scalars import scalar_fraction
from tfra.model.tfra import COEFFICIENT_LIMIT

_WHOLE = int(COEFFICIENT_LIMIT).bit_length() - 1
"""Bits before the point of alpha and beta; their limit is a power of two, so that a shift compares with it."""
assert 1 << _WHOLE == COEFFICIENT_LIMIT

_ORDER = ((0, 1), (1, 1), (0, 0), (1, 0), (0, 2), (1, 2), (2, 0), (2, 1), (2, 2))
"""p, q of the A_pq in the ring, head first: the operands of ux, u0, uy, then the rest."""

_GATHER = (
    {(0, 0): OX, (1, 0): OY, (2, 0): EE},
    {(0, 0): OX, (1, 0): OY, (0, 1): EE, (0, 2): OO},
    {(1, 1): OO, (1, 2): EE, (2, 1): OX, (2, 2): OY},
    {(2, 0): EE},
)
"""The A_pq that a parity of each quad of sums is (a part of)."""

# Cycles of the schedule; registers are loaded at the end of theirs.
_ZEROS = 3  # after the OR of the words, in two steps, and the first half of its zeros
_BACK = ALIGN + 1  # barrel and rounding
_RING = range(_ZEROS + 1, _ZEROS + 10 + _BACK)  # nine words to the barrel, and until the last one is back
_ADD = range(_RING.start + _BACK + 2, _RING.start + _BACK + 8)  # after the multiplier, and a register before it
_SWAP = _ADD.stop + 1
_ZEROS_U = _ADD.stop + 2  # after the OR of the sums and the first half of its zeros
_ALIGN_U = range(_ZEROS_U + 1, _ZEROS_U + 4)
_ROUND_U = range(_ALIGN_U.start + ALIGN + 1, _ALIGN_U.stop + ALIGN + 1)  # rounded a cycle before
_COMPARE = _ROUND_U.stop
_DIVIDE = _COMPARE + 1


class Dependent(wiring.Component):
    """mu_dep = alpha + beta mu_ind.

    ::

        sums ─▶ ring of nine words ─▶ align ─▶ round ─┬▶ x sin, x cos ─▶ +- ─▶ den, num0, num1
                     ▲                                │                              │
                     └────────────────────────────────┘       align ◀────────────────┘
                                                                └▶ |round| ─▶ compare ─▶ two dividers

    With a_pq, the A_pq at operand length, and u_q = a_0q sin - a_1q cos, alpha = num0 / den and beta = num1 / den of

    ======== ====== ====== ======
             num0   num1   den
    ======== ====== ====== ======
    sweep_y  -u_0   -u_2   u_1
    else     u_0    u_1    -u_2
    ======== ====== ====== ======

    Members:
        sums: four quads a frame: sums_b, then three of sums_n.
        direction, frame: facts of the frame; the calculation waits for them.
        affine: the result, one transfer a frame.  The sums of the next frame are taken when it has left, since the
            ring that gathers them is what holds ``affine.sums``.

    Resources: one operand x operand multiplier, used six times; two :class:`tfra.hdl.lib.divider.Divider`.
    """

    def __init__(self, design: Design) -> None:
        self.design = design
        bits = design.widths.division
        self._dividers = [Divider(bits, bits, scalar_fraction(design), _WHOLE) for _ in range(2)]
        super().__init__(
            {
                "sums": In(stream.Signature(payloads.vector_quad(design))),
                "direction": In(stream.Signature(payloads.direction(design))),
                "frame": In(stream.Signature(payloads.frame_facts(design))),
                "affine": Out(stream.Signature(payloads.affine(design))),
            }
        )

    @property
    def latency(self) -> int:
        """Cycles from the transfer of the last quad of sums, the facts being there, to that of ``affine``.

        ``operand + 27`` in all.
        """
        return 1 + _DIVIDE + self._dividers[0].latency

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        bits = max(self.design.widths.vector, self.design.formats.operand)
        ring = [Signal(signed(bits), name=f"ring_{p}{q}", reset_less=True) for p, q in _ORDER]
        cycle = self._control(m, self._gather(m, ring))
        word = self._normalise(m, ring, cycle)
        exact = self._products(m, word, cycle)
        size, negative = self._magnitudes(m, exact, cycle)
        self._divide(m, size, negative, cycle)
        for place, (p, q) in enumerate(_ORDER):
            m.d.comb += self.affine.payload.sums[3 * p + q].eq(ring[place])
        return m

    def _gather(self, m: Module, ring: list[Signal]) -> Value:
        """A_pq into the ring as their parts arrive; high from the last part until ``affine`` has left."""
        step, full = Signal(counter_shape(len(_GATHER) - 1)), Signal()
        m.d.comb += self.sums.ready.eq(~full)
        begun: set[tuple[int, int]] = set()
        with m.If(self.sums.valid & ~full):
            m.d.sync += [step.eq(step + 1), full.eq(step == len(_GATHER) - 1)]
            with m.Switch(step):
                for number, parts in enumerate(_GATHER):
                    with m.Case(number):
                        for name, parity in parts.items():
                            word, part = ring[_ORDER.index(name)], self.sums.payload[parity]
                            m.d.sync += word.eq(word + part if name in begun else part)
                    begun |= set(parts)
        with m.If(self.affine.valid & self.affine.ready):
            m.d.sync += full.eq(0)
        return full

    def _control(self, m: Module, full: Value) -> Value:
        """Cycle of the schedule: zero until sums and facts are there, the one after the last until affine has left."""
        cycle = Signal(counter_shape(_DIVIDE + 1))
        m.d.comb += [
            self.direction.ready.eq(self._at(m, cycle, _SWAP)),
            self.frame.ready.eq(self._at(m, cycle, _DIVIDE)),
        ]
        with m.If(cycle == 0):
            m.d.sync += cycle.eq(full & self.direction.valid & self.frame.valid)
        with m.Elif(cycle <= _DIVIDE):
            m.d.sync += cycle.eq(cycle + 1)
        with m.Elif(self.affine.valid & self.affine.ready):
            m.d.sync += cycle.eq(0)
        return cycle

    @staticmethod
    def _at(m: Module, cycle: Value, number: int) -> Signal:
        """High in one cycle of the schedule, and a register: it steers many words."""
        return ahead(m, cycle, range(number, number + 1))

    def _normalise(self, m: Module, ring: list[Signal], cycle: Value) -> Value:
        """The ring's words at operand length, one each cycle; they return to its tail."""
        vector, operand = self.design.widths.vector, self.design.formats.operand
        exact = [word[:vector].as_signed() for word in ring]
        rounded = Signal(signed(operand), reset_less=True)
        seen = [register(m, reduce(or_, map(magnitude_bits, exact[k::3])), "seen") for k in range(3)]
        aligned, zeros = align(m, [Cat(word, 0).as_signed() for word in seen], exact[0], self._at(m, cycle, _ZEROS))
        m.d.sync += rounded.eq(round_top(aligned, operand))
        with m.If(ahead(m, cycle, _RING)):
            m.d.sync += [word.eq(after) for word, after in zip(ring, [*ring[1:], rounded], strict=True)]
        m.d.comb += self.affine.payload.significant.eq(vector - 1 - zeros)
        return rounded

    def _products(self, m: Module, word: Value, cycle: Value) -> list[Signal]:
        """den, num0, num1: exact, up to the order of the outer two until they are swapped."""
        operand, direction = self.design.formats.operand, self.direction.payload
        factor = Signal(signed(operand), reset_less=True)
        product = Signal(signed(2 * operand), reset_less=True)
        last, middle, first = exact = [Signal(signed(2 * operand), name=f"u{n}", reset_less=True) for n in range(3)]
        second = cycle[0] ^ (_ADD.start & 1)  # of a pair, which is subtracted where the pair's sign is plus
        subtract = Signal(reset_less=True)
        with m.Switch(cycle):  # a cycle ahead
            for pair, sign in enumerate((0, direction.sweep_y, 1)):
                for turn in range(2):
                    with m.Case(_ADD[2 * pair + turn] - 1):
                        m.d.sync += subtract.eq(sign ^ turn)
        word = register(m, word, "word")  # the multiplier is far from the ring
        m.d.sync += [factor.eq(Mux(second, direction.cos, direction.sin)), product.eq(word * factor)]
        swap = self.direction.ready
        # One adder for the sums and for the swap, so that nothing follows it.
        base = Mux(swap, first, Mux(second, last, 0)).as_signed()
        total = add_or_subtract(base, Mux(swap, 0, product).as_signed(), subtract)
        with m.If(ahead(m, cycle, _ADD)):
            m.d.sync += last.eq(total)
            with m.If(~second):
                m.d.sync += [first.eq(middle), middle.eq(last)]
        with m.If(swap & ~direction.sweep_y):
            m.d.sync += [first.eq(last), last.eq(total)]
        with m.If(ahead(m, cycle, _ALIGN_U)):
            m.d.sync += [first.eq(middle), middle.eq(last)]
        return exact

    def _magnitudes(self, m: Module, exact: list[Signal], cycle: Value) -> tuple[list[Signal], list[Signal]]:
        """|num1|, |num0|, |den| with a common factor, and their signs."""
        bits = self.design.widths.division
        aligned, _ = align(m, exact, exact[-1], self._at(m, cycle, _ZEROS_U))
        size = [Signal(bits, name=f"size{n}", reset_less=True) for n in range(3)]
        negative = [Signal(name=f"negative{n}", reset_less=True) for n in range(3)]
        sign, rounded = register(m, aligned[-1], "sign"), register(m, _round_magnitude(aligned, bits), "rounded")
        with m.If(ahead(m, cycle, _ROUND_U)):
            limited = Mux(rounded[-1] & ~sign, (1 << (bits - 1)) - 1, rounded)
            m.d.sync += [size[0].eq(limited), negative[0].eq(sign)]
            m.d.sync += [size[n + 1].eq(size[n]) for n in range(2)]
            m.d.sync += [negative[n + 1].eq(negative[n]) for n in range(2)]
        return size, negative

    def _divide(self, m: Module, size: list[Signal], negative: list[Signal], cycle: Value) -> None:
        """alpha and beta; 0 / 1 where they are not usable."""
        affine, facts, den = self.affine.payload, self.frame.payload, size[2]
        vanishing, usable = Signal(reset_less=True), Signal()
        limit = den << _WHOLE
        with m.If(self._at(m, cycle, _COMPARE)):
            m.d.sync += vanishing.eq((size[0] >= limit) | (size[1] >= limit))
        m.d.comb += [usable.eq(facts.contact & facts.traction & ~vanishing), affine.vanishing.eq(vanishing)]
        for name, number in (("alpha", 1), ("beta", 0)):
            m.submodules[name] = divider = self._dividers[number]
            m.d.comb += [
                divider.i.payload.numerator.eq(Mux(usable, size[number], 0)),
                divider.i.payload.denominator.eq(den | ~usable),
                divider.i.payload.negative.eq(negative[number] ^ negative[2]),
                divider.i.valid.eq(self.frame.ready),
                divider.o.ready.eq(self.affine.ready),
                affine[name].eq(divider.o.payload),
            ]
        m.d.comb += self.affine.valid.eq(self._dividers[0].o.valid)  # both take the same time


def _round_magnitude(aligned: Value, bits: int) -> Value:
    """Magnitude of ``round_top(aligned, bits)``, unsigned ``bits``, with a single addition; not yet limited.

    Negative words round half up as their complements do: -((v + 1) >> 1) = (~v + 1) >> 1.
    """
    value = aligned[len(aligned) - bits - 1 :]
    return (((value ^ value[-1].replicate(len(value)))[:bits] + 1) >> 1)[:bits]
