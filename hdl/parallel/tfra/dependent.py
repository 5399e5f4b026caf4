"""alpha and beta of the dependent friction (Eqs. 12, 17, 18), see :mod:`tfra.model.fixed.tfra.dependent`."""

from functools import reduce
from operator import or_
from typing import Any, NamedTuple

from amaranth import Cat, Module, Mux, Signal, Value, signed
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.arithmetic import add_or_subtract, counter_shape, later, magnitude_bits, once, round_off, round_top
from tfra.hdl.lib.divider import Divider
from tfra.hdl.lib.pipeline import ALIGN, align, lookahead, register
from tfra.hdl.parallel import payloads
from tfra.model.fixed.butterfly import EE, OO, OX, OY
from tfra.model.fixed.design import Design
from tfra.model.fixed.widths import scalar_fraction
from tfra.model.tfra import COEFFICIENT_LIMIT

_WHOLE = int(COEFFICIENT_LIMIT).bit_length() - 1
"""Bits before the point of alpha and beta; their limit is a power of two, so a shift compares with it."""
assert 1 << _WHOLE == COEFFICIENT_LIMIT


class _Product(NamedTuple):
    """A row of the schedule: ``operand`` times ``factor``, added to a sum or subtracted from it."""

    operand: tuple[int, int]
    """p, q of a rounded A_pq."""
    factor: str
    """Of the direction."""
    sign: int
    sweep_y_inverts: bool
    """The sign is the opposite one where the sweep goes along y."""
    total: str
    """Sum to which it is added."""


_PRODUCTS = (
    _Product((0, 1), "sin", +1, False, "u_1"),
    _Product((1, 1), "cos", -1, False, "u_1"),
    _Product((0, 0), "sin", +1, True, "+-u_0"),
    _Product((1, 0), "cos", -1, True, "+-u_0"),
    _Product((0, 2), "sin", -1, False, "-u_2"),
    _Product((1, 2), "cos", +1, False, "-u_2"),
)
"""Rows of the schedule, one a cycle: row n is added in cycle ``_ADD[n]``."""

_ORDER = (*(product.operand for product in _PRODUCTS), (2, 0), (2, 1), (2, 2))
"""p, q of the A_pq in the ring, head first: the operands of the products, then the rest."""

_GATHER = (
    {(0, 0): OX, (1, 0): OY, (2, 0): EE},
    {(0, 0): OX, (1, 0): OY, (0, 1): EE, (0, 2): OO},
    {(1, 1): OO, (1, 2): EE, (2, 1): OX, (2, 2): OY},
    {(2, 0): EE},
)
"""The A_pq that a parity of each quad of sums is (a part of)."""

# Schedule: the cycles of each step; its registers are loaded at their end.  First the nine words A_pq:
_OR_OF_THIRDS, _OR, _HALF_ZEROS, _ZEROS = range(4)  # zeros that all words have after their signs
_TO_TAIL = ALIGN + 1  # cycles of a word from the head of the ring to its tail: aligned and rounded
_RING = later(range(len(_ORDER) + _TO_TAIL), _ZEROS + 1)  # a word a cycle to the barrel, a rounded one a cycle back
_MULTIPLY = later(range(len(_PRODUCTS)), _RING.start + _TO_TAIL + 1)  # operand times factor, a cycle after rounding
_ADD = later(_MULTIPLY, 1)  # the product to its sum, or from it
# Then their three sums:
_OR_U, _HALF_ZEROS_U, _ZEROS_U = later(range(3), _ADD.stop)  # zeros that all sums have after their signs
_SWAP = _HALF_ZEROS_U  # of den and num1: after the OR, which is that of the sums in any order
_ALIGN_U = later(range(3), _ZEROS_U + 1)  # a sum a cycle to the barrel: den, num0, num1
_ROUND_U = later(_ALIGN_U, ALIGN)  # its magnitude
_LIMIT_U = later(_ROUND_U, 1)  # ... limited
_COMPARE = _LIMIT_U.stop  # num0 and num1 with the limit of quotients times den
_DIVIDE = _COMPARE + 1  # both divisions begin


class Dependent(wiring.Component):
    """mu_dep = alpha + beta mu_ind.

    ::

        sums ─▶ ring of nine words ─▶ align ─▶ round ─┬▶ x sin, x cos ─▶ +- ─▶ den, num0, num1
                     ▲                                │                              │
                     └────────────────────────────────┘       align ◀────────────────┘
                                                                └▶ |round| ─▶ compare ─▶ two dividers

    With a_pq, the rounded A_pq, and u_q = a_0q sin - a_1q cos, alpha = num0 / den and beta = num1 / den of

    ======== ====== ====== ======
             num0   num1   den
    ======== ====== ====== ======
    sweep_y  -u_0   -u_2   u_1
    else     u_0    u_1    -u_2
    ======== ====== ====== ======

    ``_PRODUCTS`` is the schedule of the multiplier, from which the order of the ring, the factors and the signs
    follow.  The sums are den, num0, num1 where the sweep goes along y.  Else the outer two are swapped.

    Resources: one multiplier of sums by the direction, used six times; two :class:`tfra.hdl.lib.divider.Divider`.
    """

    def __init__(self, design: Design) -> None:
        self.design = design
        bits = design.widths.division
        self._dividers = [Divider(bits, bits, scalar_fraction(design), _WHOLE) for _ in range(2)]
        super().__init__({
            # Four quads a frame: sums_b, then three of sums_n.  Those of the next frame are taken when ``affine``
            # has left, since the ring that gathers them holds ``affine.sums``.
            "sums": In(stream.Signature(payloads.vector_quad(design))),
            "direction": In(stream.Signature(payloads.direction(design))),  # fact of the frame, waited for
            "frame": In(stream.Signature(payloads.frame_facts(design))),  # fact of the frame, waited for
            "affine": Out(stream.Signature(payloads.affine(design))),  # the result, one transfer a frame
        })

    @property
    def latency(self) -> int:
        """Cycles from the transfer of the last quad of sums, the facts being there, to that of ``affine``.

        The length of a scalar and 27 in all.
        """
        return 1 + _DIVIDE + self._dividers[0].latency

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        bits = max(self.design.widths.vector, self.design.formats.bits("sums"))
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
        step = Signal(counter_shape(len(_GATHER) - 1))
        full = Signal()
        m.d.comb += self.sums.ready.eq(~full)
        begun: set[tuple[int, int]] = set()
        with m.If(self.sums.valid & ~full):
            m.d.sync += step.eq(step + 1)
            m.d.sync += full.eq(step == len(_GATHER) - 1)
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
            self.direction.ready.eq(lookahead(m, cycle, once(_SWAP))),
            self.frame.ready.eq(lookahead(m, cycle, once(_DIVIDE))),
        ]
        with m.If(cycle == 0):
            m.d.sync += cycle.eq(full & self.direction.valid & self.frame.valid)
        with m.Elif(cycle <= _DIVIDE):
            m.d.sync += cycle.eq(cycle + 1)
        with m.Elif(self.affine.valid & self.affine.ready):
            m.d.sync += cycle.eq(0)
        return cycle

    def _normalise(self, m: Module, ring: list[Signal], cycle: Value) -> Value:
        """The ring's words, rounded, one each cycle; they return to its tail."""
        vector, bits = self.design.widths.vector, self.design.formats.bits("sums")
        exact = [word[:vector].as_signed() for word in ring]
        rounded = Signal(signed(bits), reset_less=True)
        thirds = [register(m, reduce(or_, map(magnitude_bits, exact[k::3])), f"third{k}") for k in range(3)]
        measured = [Cat(word, 0).as_signed() for word in thirds]
        aligned, zeros = align(m, measured, exact[0], lookahead(m, cycle, once(_ZEROS)))
        m.d.sync += rounded.eq(round_top(aligned, bits))
        with m.If(lookahead(m, cycle, _RING)):
            m.d.sync += [word.eq(after) for word, after in zip(ring, [*ring[1:], rounded], strict=True)]
        m.d.comb += self.affine.payload.significant.eq(vector - 1 - zeros)
        return rounded

    def _products(self, m: Module, rounded: Value, cycle: Value) -> list[Signal]:
        """num1, num0, den: exact; each sum enters the first of the registers and moves on for the next one."""
        direction = self.direction.payload
        turn = self.design.formats.bits("direction")
        length = self.design.formats.bits("sums") + turn
        num1, num0, den = exact = [Signal(signed(length), name=n, reset_less=True) for n in ("num1", "num0", "den")]
        factor = Signal(signed(turn), reset_less=True)
        product = Signal(signed(length), reset_less=True)
        second = self._second(cycle)
        subtract = self._subtract(m, cycle)
        word = register(m, rounded, "word")  # TIMING: rounded -> product
        factors = [direction[row.factor] for row in _PRODUCTS[:2]]
        m.d.sync += factor.eq(Mux(second, factors[1], factors[0]))
        m.d.sync += product.eq(word * factor)
        swap = self.direction.ready
        # TIMING: product -> num1: one adder for the sums and for the swap, so that nothing follows it
        base = Mux(swap, den, Mux(second, num1, 0)).as_signed()
        total = add_or_subtract(base, Mux(swap, 0, product).as_signed(), subtract)
        with m.If(lookahead(m, cycle, _ADD)):
            m.d.sync += num1.eq(total)
            with m.If(~second):
                m.d.sync += den.eq(num0)
                m.d.sync += num0.eq(num1)
        with m.If(swap & ~direction.sweep_y):
            m.d.sync += den.eq(num1)
            m.d.sync += num1.eq(total)
        with m.If(lookahead(m, cycle, _ALIGN_U)):
            m.d.sync += den.eq(num0)
            m.d.sync += num0.eq(num1)
        return exact

    @staticmethod
    def _second(cycle: Value) -> Value:
        """High for every second product of the schedule, which has the other factor and completes a sum."""
        for first, second in zip(_PRODUCTS[::2], _PRODUCTS[1::2], strict=True):
            assert first.total == second.total
            assert (first.factor, second.factor) == (_PRODUCTS[0].factor, _PRODUCTS[1].factor)
        return cycle[0] ^ (_ADD.start & 1)

    def _subtract(self, m: Module, cycle: Value) -> Signal:
        """The product that is added now is subtracted."""
        subtract = Signal(reset_less=True)
        with m.Switch(cycle):
            for add, product in zip(_ADD, _PRODUCTS, strict=True):
                inverts = self.direction.payload.sweep_y if product.sweep_y_inverts else 0
                with m.Case(add - 1):
                    m.d.sync += subtract.eq(inverts ^ int(product.sign < 0))
        return subtract

    def _magnitudes(self, m: Module, exact: list[Signal], cycle: Value) -> tuple[list[Signal], list[Signal]]:
        """|num1|, |num0|, |den| with a common factor, and their signs; den comes first and moves on."""
        bits = self.design.widths.division
        names = ("num1", "num0", "den")
        size = [Signal(bits, name=f"{name}_size", reset_less=True) for name in names]
        negative = [Signal(name=f"{name}_negative", reset_less=True) for name in names]
        aligned, _ = align(m, exact, exact[-1], lookahead(m, cycle, once(_ZEROS_U)))
        sign = register(m, aligned[-1], "sign")
        # The magnitude of ``round_top(aligned, bits)`` with a single addition, not yet limited: negative words round
        # half up as their complements do, -((v + 1) >> 1) = (~v + 1) >> 1.
        rounded = register(m, round_off(magnitude_bits(aligned[len(aligned) - bits - 1 :]), 1), "magnitude")
        with m.If(lookahead(m, cycle, _LIMIT_U)):
            limited = Mux(rounded[-1] & ~sign, (1 << (bits - 1)) - 1, rounded)
            m.d.sync += size[0].eq(limited)
            m.d.sync += negative[0].eq(sign)
            m.d.sync += [size[n + 1].eq(size[n]) for n in range(2)]
            m.d.sync += [negative[n + 1].eq(negative[n]) for n in range(2)]
        return size, negative

    def _divide(self, m: Module, size: list[Signal], negative: list[Signal], cycle: Value) -> None:
        """alpha and beta; 0 / 1 where they are not usable."""
        affine, facts = self.affine.payload, self.frame.payload
        num1, num0, den = size
        vanishing = Signal(reset_less=True)
        usable = Signal()
        limit = den << _WHOLE
        with m.If(lookahead(m, cycle, once(_COMPARE))):
            m.d.sync += vanishing.eq((num1 >= limit) | (num0 >= limit))
        m.d.comb += usable.eq(facts.contact & facts.traction & ~vanishing)
        m.d.comb += affine.vanishing.eq(vanishing)
        for name, divider, numerator, sign in (
            ("alpha", self._dividers[1], num0, negative[1]),
            ("beta", self._dividers[0], num1, negative[0]),
        ):
            m.submodules[name] = divider
            m.d.comb += [
                divider.i.payload.numerator.eq(Mux(usable, numerator, 0)),
                divider.i.payload.denominator.eq(den | ~usable),
                divider.i.payload.negative.eq(sign ^ negative[2]),
                divider.i.valid.eq(self.frame.ready),
                divider.o.ready.eq(self.affine.ready),
                affine[name].eq(divider.o.payload),
            ]
        m.d.comb += self.affine.valid.eq(self._dividers[0].o.valid)  # both take the same time
