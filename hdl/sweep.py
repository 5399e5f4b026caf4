"""The exact sweep of mu_ind: B^z and B^xy of every candidate, and the choice between them (Eqs. 23-27).

    stress ---------------------------------.
    g ------------- memory --.              |
    normal (e0) -- butterfly(e0 - g) = p ---+-- _Loader: one taxel (p, q, stress) a cycle
    normal (e1) -- butterfly(e1)     = q ---'      |
                                                   v
          .-- x + P q, q, stress <-- memory -- _Passes: x = K (p - [negative] q)   one pass per P candidates
          '----------------------------------------|
                                                   v
                      _Lanes: x + c q for c = 0 ... P - 1, sums of max(0, .)
                                                   |  a row of P pairs (B^z, S - M) per pass
                                                   v
                      _Judge: comparator tree, first over B^z, then over |S - M| = B^xy -- index

No multiplier is used: constant factors are additions of shifted words.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from amaranth import Array, Cat, Module, Mux, Shape, Signal, Value, signed, unsigned
from amaranth.lib import data, stream, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from tfra.hdl import payloads
from tfra.hdl.arithmetic import count
from tfra.hdl.comparator_tree import ComparatorTree
from tfra.model.design import Design
from tfra.model.fixed.butterfly import distinct
from tfra.model.fixed.sweep import sweep_unit, tolerance
from tfra.model.fixed.widths import widths

_PLACES = 4
"""Cycles a quad of q takes: one per word."""
_READ, _FOLDED = 4, 5
"""Cycles from a quad's transfer to the read of its p and stress, and to its words behind the butterfly."""


def signed_digits(factor: int) -> list[tuple[int, int]]:
    """Canonical signed digits ``(place, +-1)`` of a positive ``factor``, from the highest, which is positive."""
    digits, place = [], 0
    while factor:
        if factor & 1:
            digit = 2 - (factor & 3)
            digits.append((place, digit))
            factor -= digit
        factor >>= 1
        place += 1
    return digits[::-1]


def product_latency(factor: int) -> int:
    """Cycles that :func:`registered_product` takes: the levels of its tree of additions."""
    return (len(signed_digits(factor)) - 1).bit_length()


def registered_product(m: Module, value: Value, factor: int) -> Value:
    """``value * factor`` from a tree of shifted copies with a register behind every addition."""
    most = len(value) + factor.bit_length()
    terms: list[tuple[Value, int]] = [(value << place, sign) for place, sign in signed_digits(factor)]
    while len(terms) > 1:
        level = []
        for (a, sign_a), right in zip(terms[::2], [*terms[1::2], None], strict=False):
            total, sign = a, sign_a
            if right is not None:
                b, sign_b = right
                total = a + b if sign_a == sign_b else a - b if sign_a > 0 else b - a
                sign = sign_a if sign_a == sign_b else 1
            word = Signal(Shape(min(len(total), most), True), reset_less=True)
            m.d.sync += word.eq(total)
            level.append((word, sign))
        terms = level
    return terms[0][0]


def delayed(m: Module, value: Value, cycles: int, *, control: bool = False) -> Value:
    """``value`` so many cycles later; ``control`` bits are cleared by a reset."""
    for _ in range(cycles):
        word = Signal(value.shape(), reset_less=not control)
        m.d.sync += word.eq(value)
        value = word
    return value


def lane_levels(design: Design) -> int:
    """Additions in a row between x and the last lane, and levels of the comparator tree: ``ceil(log2 P)``."""
    return (design.architecture.sweep_lanes - 1).bit_length()


def pass_interval(design: Design) -> int:
    """Cycles between two passes: the taxels, the measured sum and one to clear the lanes.

    The smallest arrays wait a little for ``x + P q``, which must be written before it is read again.
    """
    loop = 4 + product_latency(design.architecture.sweep_lanes)
    return max(design.sensor.taxels + 2, loop)


def lanes_latency(design: Design) -> int:
    """Cycles from the lanes' last taxel to the one before their sums stand."""
    return 1 + max(lane_levels(design), product_latency(design.search.steps))


def limit_latency(design: Design) -> int:
    """Cycles from the comparator tree's output to the largest B^z of the plateau; an adder if there is a tolerance."""
    return 2 if tolerance(design).any() else 1


def judge_latency(design: Design) -> int:
    """Cycles from the sums of the last pass to the index: twice through the tree, two turns for every row."""
    return 3 + 2 * lane_levels(design) + limit_latency(design) + 2 * design.sweep_passes


def folded_taxel(design: Design) -> data.StructLayout:
    """One taxel behind the butterfly; ``measured`` marks the slot behind a frame's last one."""
    w = widths(design)
    words = {"p": signed(w.vector), "q": signed(w.vector), "stress": signed(w.stress)}
    return data.StructLayout({**words, "valid": 1, "measured": 1})


def swept_words(design: Design) -> data.StructLayout:
    """What a pass reads and writes of one taxel; ``b`` is its stress, or minus the sum of all positive ones."""
    w = widths(design)
    return data.StructLayout({"x": signed(w.candidate), "q": signed(w.vector), "b": signed(w.magnitude + 1)})


def swept_taxel(design: Design) -> data.StructLayout:
    """One step of the lanes; ``measured`` marks a pass's last, whose ``b`` enters the sums whatever its sign."""
    return data.StructLayout({"words": swept_words(design), "valid": 1, "measured": 1})


class _Loader(wiring.Component):
    """Collect a frame's quads and hand out its taxels.

    Dataflow of ``normal``, by cycles behind the transfer: 1 held, 2 (g read and held), 3 minus g, 4 and 5
    butterfly.  Quads of e0 then go to the memory of g, which keeps p from here on.  Quads of e1 stay for four
    cycles, while p, q and stress are picked word by word; words of mirror taxels that are the same one are left
    out (``valid`` is low).  ``measured`` follows the last quad's last word.

    Resources: 12 adders of the vector width, memories of Q vector quads and Q stress quads.
    """

    def __init__(self, design: Design) -> None:
        self._design = design
        vector = payloads.vector_quad(design)
        super().__init__(
            {
                "stress": In(stream.Signature(payloads.stress_quad(design))),
                "g": In(stream.Signature(vector)),
                "normal": In(stream.Signature(vector)),
                "known": In(1),  # direction and exponent are there
                "done": In(1),  # the frame is over
                "idle": Out(1),  # no frame has begun to be swept
                "taxel": Out(folded_taxel(design)),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        step, number, behind = Signal(range(5)), self._number(), self._number()
        in_stress, in_g, in_e0, in_e1 = (step == k for k in range(4))
        pause = Signal(range(_PLACES))
        took_stress, took_g = self.stress.valid & in_stress, self.g.valid & in_g
        flow = (in_e0 & self.known) | (in_e1 & (pause == 0))
        took_e0, took_e1 = self.normal.valid & flow & in_e0, self.normal.valid & flow & in_e1
        m.d.comb += [
            self.stress.ready.eq(in_stress),
            self.g.ready.eq(in_g),
            self.normal.ready.eq(flow),
            self.idle.eq(in_stress),
        ]
        last = number == self._design.quads - 1
        with m.If(took_stress | took_g | took_e0 | took_e1):
            m.d.sync += number.eq(Mux(last, 0, number + 1))
            with m.If(last):
                m.d.sync += step.eq(step + 1)
        with m.If(self.done):
            m.d.sync += step.eq(0)
        # One cycle between e0 and e1, so that even the p of a single quad is written before it is read.
        with m.If(took_e0 | took_e1):
            m.d.sync += pause.eq(Mux(in_e0, 1, _PLACES - 1))
        with m.Elif(pause != 0):
            m.d.sync += pause.eq(pause - 1)
        self._vectors(m, number, behind, took_stress, took_g, took_e0, took_e1, took_e1 & last)
        return m

    def _number(self) -> Signal:
        return Signal(count(self._design.quads - 1))

    def _vectors(
        self,
        m: Module,
        number: Value,
        behind: Signal,
        took_stress: Value,
        took_g: Value,
        took_e0: Value,
        took_e1: Value,
        took_last: Value,
    ) -> None:
        """Memories and butterfly; ``behind`` is the quad that leaves the butterfly next."""
        q = self._design.quads
        m.submodules.base = base = Memory(shape=payloads.vector_quad(self._design), depth=q, init=[])
        m.submodules.stresses = stresses = Memory(shape=payloads.stress_quad(self._design), depth=q, init=[])
        e0, e1 = self._later(m, took_e0), self._later(m, took_e1)
        write, read, write_stress, read_stress = (
            base.write_port(),
            base.read_port(),
            stresses.write_port(),
            stresses.read_port(),
        )
        offset = Signal(payloads.vector_quad(self._design), reset_less=True)
        words = self._butterfly(m, took_e0 | took_e1, offset)
        m.d.sync += offset.eq(Mux(e0[1], read.data.as_value(), 0))
        m.d.comb += [
            write.addr.eq(Mux(took_g, number, behind)),
            write.data.eq(Mux(took_g, self.g.payload.as_value(), Cat(words))),
            write.en.eq(took_g | e0[_FOLDED]),
            read.addr.eq(Mux(took_e0, number, behind)),
            read.en.eq(took_e0 | e1[_READ]),
            write_stress.addr.eq(number),
            write_stress.data.eq(self.stress.payload),
            write_stress.en.eq(took_stress),
            read_stress.addr.eq(behind),
            read_stress.en.eq(e1[_READ]),
        ]
        with m.If(e0[_FOLDED] | e1[_FOLDED]):
            m.d.sync += behind.eq(Mux(behind == q - 1, 0, behind + 1))
        place = Signal(range(_PLACES))
        keep = self._keep(m, behind, e1[_READ])
        m.d.sync += place.eq(Mux(e1[_READ], 0, place + 1))
        m.d.sync += [
            self.taxel.p.eq(self._pick(read.data, place)),
            self.taxel.q.eq(self._pick(words, place)),
            self.taxel.stress.eq(self._pick(read_stress.data, place)),
            self.taxel.valid.eq(e1[_FOLDED : _FOLDED + _PLACES].any() & keep.bit_select(place, 1)),
            self.taxel.measured.eq(delayed(m, took_last, _FOLDED + _PLACES, control=True)),
        ]

    @staticmethod
    def _pick(words: Sequence[Value], place: Value) -> Value:
        """One of four words: a multiplexer, where indexing a view would take a multiplier for the bit's place."""
        return Array(words[k] for k in range(_PLACES))[place]

    @staticmethod
    def _later(m: Module, pulse: Value) -> Value:
        """Bit k: ``pulse`` of k cycles ago."""
        seen = Signal(_FOLDED + _PLACES - 1)
        m.d.sync += seen.eq(Cat(pulse, seen))
        return Cat(pulse, seen)

    def _butterfly(self, m: Module, took: Value, offset: data.View) -> list[Value]:
        """``butterfly(normal - offset)`` modulo the word, which holds p and q by proof."""
        bits = widths(self._design).vector
        held = Signal(payloads.vector_quad(self._design), reset_less=True)
        with m.If(took):
            m.d.sync += held.eq(self.normal.payload)
        same = delayed(m, held.as_value(), 1)
        same = data.View(payloads.vector_quad(self._design), same)

        def register(value: Value) -> Signal:
            word = Signal(signed(bits), reset_less=True)
            m.d.sync += word.eq(value)
            return word

        a, b, c, d = (register(same[k] - offset[k]) for k in range(4))
        plus, minus, plus2, minus2 = register(a + b), register(a - b), register(c + d), register(c - d)
        return [register(v) for v in (plus + plus2, minus + minus2, plus - plus2, minus - minus2)]

    def _keep(self, m: Module, number: Value, look: Value) -> Signal:
        """Which words of a quad are taxels of their own: a bit each, from the static shape of the array."""
        keep = Signal(_PLACES, reset_less=True)
        with m.If(look), m.Switch(number):
            for at, row in enumerate(distinct(self._design)):
                with m.Case(at):
                    m.d.sync += keep.eq(sum(1 << place for place in range(_PLACES) if row[place]))
        return keep


class _Passes(wiring.Component):
    """Let the taxels run past the lanes, once per P candidates, each time with ``x`` of the pass's first one.

    ``x = K (p - [negative] q)`` in the first pass, as the taxels come; ``x + P q`` in the next, from a memory of
    ``m + 1`` entries.  The last entry is the measured sum: with ``x = q = 0`` and ``b`` = minus the sum of positive
    stress it subtracts M from what the lanes sum.

    Candidates up to K fit ``widths.candidate``; x wraps beyond, where nothing looks at it, and the wrap does not
    spread, since additions are modular.

    Resources: a constant product each by K and P, three adders.
    """

    def __init__(self, design: Design) -> None:
        self._design = design
        super().__init__(
            {
                "i": In(folded_taxel(design)),
                "negative": In(1),
                "idle": In(1),
                "o": Out(swept_taxel(design)),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        first = self._first_pass(m)
        if self._design.sweep_passes == 1:
            m.d.sync += self.o.eq(first)
            return m
        m.submodules.memory = memory = Memory(
            shape=swept_words(self._design), depth=self._design.sensor.taxels + 1, init=[]
        )
        self._write(m, memory)
        words, valid, measured = self._read(m, memory, first.measured)
        m.d.sync += [
            self.o.words.eq(Mux(valid, words.as_value(), first.words.as_value())),
            self.o.valid.eq(first.valid | valid),
            self.o.measured.eq(first.measured | measured),
        ]
        return m

    def _first_pass(self, m: Module) -> data.View:
        design, w, i = self._design, widths(self._design), self.i
        positive = Signal(signed(w.magnitude + 1), reset_less=True)
        start = Signal(signed(w.vector + 1), reset_less=True)
        slope = Signal(signed(w.vector), reset_less=True)
        b = Signal(signed(w.magnitude + 1), reset_less=True)
        with m.If(self.idle):
            m.d.sync += positive.eq(0)
        with m.Elif(i.valid & (i.stress > 0)):
            m.d.sync += positive.eq(positive - i.stress)
        m.d.sync += [start.eq(i.p - Mux(self.negative, i.q, 0)), slope.eq(i.q), b.eq(i.stress)]
        with m.If(i.measured):
            m.d.sync += [start.eq(0), slope.eq(0), b.eq(positive)]
        wait, steps = product_latency(design.search.steps), design.search.steps
        first = Signal(swept_taxel(design))
        m.d.comb += [
            first.words.x.eq(registered_product(m, start, steps)),
            first.words.q.eq(delayed(m, slope, wait)),
            first.words.b.eq(delayed(m, b, wait)),
            first.valid.eq(delayed(m, i.valid | i.measured, 1 + wait, control=True)),
            first.measured.eq(delayed(m, i.measured, 1 + wait, control=True)),
        ]
        return first

    def _write(self, m: Module, memory: Memory) -> None:
        """``x + P q`` of every entry, in order, behind the lanes' input."""
        lanes, last = self._design.architecture.sweep_lanes, self._design.sensor.taxels
        wait = product_latency(lanes)
        write, address = memory.write_port(), Signal(count(last))
        now = data.View(swept_words(self._design), delayed(m, self.o.words.as_value(), wait))
        then = Signal(swept_words(self._design), reset_less=True)
        m.d.sync += [
            then.x.eq(now.x + registered_product(m, self.o.words.q, lanes)),
            then.q.eq(now.q),
            then.b.eq(now.b),
        ]
        valid = delayed(m, self.o.valid, 1 + wait, control=True)
        m.d.comb += [write.addr.eq(address), write.data.eq(then), write.en.eq(valid)]
        with m.If(valid):
            m.d.sync += address.eq(Mux(address == last, 0, address + 1))

    def _read(self, m: Module, memory: Memory, begin: Value) -> tuple[data.View, Value, Value]:
        """All entries once per further pass; the words, and the marks that go with them."""
        last, interval = self._design.sensor.taxels, pass_interval(self._design)
        read, active = memory.read_port(), Signal()
        slot, left = Signal(range(interval)), Signal(count(self._design.sweep_passes - 1))
        with m.If(active):
            m.d.sync += slot.eq(slot + 1)
            with m.If(slot == interval - 1):
                m.d.sync += [slot.eq(0), left.eq(left - 1), active.eq(left != 1)]
        with m.If(delayed(m, begin, interval - (last + 2), control=True)):
            m.d.sync += [active.eq(1), slot.eq(0), left.eq(self._design.sweep_passes - 1)]
        valid, measured = active & (slot <= last), active & (slot == last)
        m.d.comb += [read.addr.eq(slot), read.en.eq(valid)]
        return read.data, delayed(m, valid, 1, control=True), delayed(m, measured, 1, control=True)


class _Lanes(wiring.Component):
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


class _Judge(wiring.Component):
    """Choose: smallest B^xy of those within the tolerance of the smallest B^z, the first of equals.

    B^z of a row enters the tree as the pass ends; ``lowest`` is the minimum over the rows.  When it stands, every
    row enters twice: ``v = xy`` where it is not negative, then ``-v - 1`` where it is, so that one adder behind
    the tree instead of one per lane makes |v|.  Last, (|v|, number) is compared with the best so far.

    Resources: a comparator per lane, a :class:`ComparatorTree` of P keys, a memory of the rows if there are several.
    """

    def __init__(self, design: Design) -> None:
        self._design, w = design, widths(design)
        lanes = design.architecture.sweep_lanes
        super().__init__(
            {
                "z": In(unsigned(w.b_z)).array(lanes),
                "xy": In(signed(w.b_xy + 1)).array(lanes),
                "ended": In(1),  # the cycle before a row stands
                "stands": Out(1),  # the cycle in which z and xy are a row
                "idle": In(1),
                "exponent": In(count(design.adc.bits - 1)),
                "found": Out(1),  # a pulse, one cycle before index stands
                "index": Out(payloads.sweep_index(design)),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        passes, lanes, bits = self._design.sweep_passes, len(self.z), widths(self._design).b_xy + 1
        m.submodules.tree = tree = ComparatorTree(lanes, bits)
        row, final = Signal(count(passes - 1)), Signal()
        m.d.sync += self.stands.eq(self.ended)
        m.d.comb += final.eq(row == passes - 1)
        with m.If(self.stands):
            m.d.sync += row.eq(row + 1)
        with m.If(self.idle):
            m.d.sync += row.eq(0)
        # The first keys reach the limit's comparators in the cycle in which it stands, two behind their turn.
        begin = delayed(m, self.ended & final, tree.latency + limit_latency(self._design) - 1, control=True)
        turn, turning, last_turn = self._turns(m, begin)
        rows = self._rows(m, row, turn)
        limit = self._limit(m, tree)
        self._keys(m, tree, rows, limit, final, delayed(m, turn, 2))
        valid = delayed(m, turning, 3 + tree.latency, control=True)
        self._best(m, tree, valid)
        m.d.comb += self.found.eq(delayed(m, last_turn, 4 + tree.latency, control=True))
        return m

    def _turns(self, m: Module, begin: Value) -> tuple[Signal, Signal, Value]:
        """Count every row twice."""
        last = 2 * self._design.sweep_passes - 1
        turn, turning, ends = Signal(count(last)), Signal(), Signal()
        m.d.comb += ends.eq(turning & (turn == last))
        with m.If(turning):
            m.d.sync += turn.eq(turn + 1)
        with m.If(ends):
            m.d.sync += turning.eq(0)
        with m.If(begin):
            m.d.sync += [turn.eq(0), turning.eq(1)]
        return turn, turning, ends

    def _rows(self, m: Module, row: Value, turn: Value) -> list[tuple[Value, Value]]:
        """B^z and xy of every lane, two cycles behind ``turn``; a single row stays in the lanes."""
        pairs = list(zip(self.z, self.xy, strict=True))
        if self._design.sweep_passes == 1:
            return pairs
        return [self._row(m, Cat(*pair), row, turn) for pair in pairs]

    def _row(self, m: Module, pair: Value, row: Value, turn: Value) -> tuple[Value, Value]:
        """One lane's pairs; a memory of its own, since some tools choke on a word of thousands of bits."""
        rows = Memory(shape=unsigned(len(pair)), depth=self._design.sweep_passes, init=[])
        m.submodules += rows
        write, read = rows.write_port(), rows.read_port()
        m.d.comb += [
            write.addr.eq(row),
            write.en.eq(self.stands),
            write.data.eq(pair),
            read.addr.eq(turn >> 1),
            read.en.eq(1),
        ]
        held, bits = delayed(m, read.data, 1), widths(self._design).b_z
        return held[:bits], held[bits:].as_signed()

    def _limit(self, m: Module, tree: ComparatorTree) -> Value:
        """The largest B^z of the plateau: minimum over the rows plus tolerance."""
        bits = widths(self._design).b_z
        lowest, least = Signal(bits, reset_less=True), tree.least[:bits]
        fresh = delayed(m, self.stands, 1 + tree.latency, control=True)
        with m.If(fresh & (least < lowest)):
            m.d.sync += lowest.eq(least)
        with m.If(self.idle):
            m.d.sync += lowest.eq((1 << bits) - 1)
        if not tolerance(self._design).any():
            return lowest
        slack, limit = Signal(bits, reset_less=True), Signal(bits + 1, reset_less=True)
        with m.Switch(self.exponent):
            for exponent, value in enumerate(tolerance(self._design)):
                with m.Case(exponent):
                    m.d.sync += slack.eq(int(value))
        m.d.sync += limit.eq(lowest + slack)
        return limit

    def _keys(
        self,
        m: Module,
        tree: ComparatorTree,
        rows: list[tuple[Value, Value]],
        limit: Value,
        final: Value,
        turn: Value,
    ) -> None:
        """Tree's input: B^z of the row that stands, else xy (or its complement) of a row from the memory.

        Lanes of the last row beyond candidate K get a one on top, as do those that this turn is not for.
        """
        passes, bits, lanes = self._design.sweep_passes, widths(self._design).b_xy, len(rows)
        mirrored, in_last = turn[0], (turn >> 1) == passes - 1
        for lane, (z, xy) in enumerate(rows):
            beyond = (passes - 1) * lanes + lane >= self._design.candidates
            key = Signal(bits + 1, reset_less=True)
            distance = (xy ^ mirrored.replicate(bits + 1))[: bits + 1]
            out = (z > limit) | distance[bits] | (in_last & beyond)
            m.d.sync += key.eq(Cat(distance[:bits], out))
            with m.If(self.stands):
                m.d.sync += key.eq(self.z[lane] | ((final & beyond) << bits))
            m.d.comb += tree.keys[lane].eq(key)

    def _best(self, m: Module, tree: ComparatorTree, valid: Value) -> None:
        """Smallest (|v|, number) of all turns; the numbers of a row begin at ``base``."""
        lanes, bits = self._design.architecture.sweep_lanes, widths(self._design).b_xy
        number = count(self._design.sweep_passes * lanes - 1).width
        base, mirrored = Signal(number), Signal()
        layout = data.StructLayout({"number": number, "distance": bits, "out": 1})
        entry, best = Signal(layout, reset_less=True), Signal(layout, reset_less=True)
        m.d.sync += [
            entry.number.eq(base + tree.place),
            entry.distance.eq(tree.least[:bits] + mirrored),
            entry.out.eq(tree.least[bits]),
        ]
        with m.If(valid):
            m.d.sync += [mirrored.eq(~mirrored), base.eq(Mux(mirrored, base + lanes, base))]
        entered = delayed(m, valid, 1, control=True)
        with m.If(entered & (entry.as_value() < best.as_value())):
            m.d.sync += best.eq(entry)
        with m.If(self.idle):
            m.d.sync += [base.eq(0), mirrored.eq(0), best.as_value().eq((1 << layout.size) - 1)]
        m.d.comb += self.index.eq(best.number)


class Sweep(wiring.Component):
    """``index`` of the candidate with the smallest B^xy on the plateau of B^z; equal to the model's ``sweep``.

    Takes one frame at a time: stress, g and normal in this order, then nothing until the index is taken.  Stress, g
    and e0 pass at a quad a cycle; quads of e1 at one in ``quad_interval`` cycles, the first of them two cycles
    behind e0 at the earliest, since the first pass runs while they come.  Quads of e0 wait until direction and
    frame are valid; both are taken when the index is found.

    Resources: no multiplier; per lane five adders or comparators, about 300 4-input tables at 46 bits; memories of
    Q vector quads, Q stress quads and, with several passes, m + 1 taxels and the sums of all candidates.

    Members:
        stress: Q taxel-domain quads of the normalised frame.
        g: Q parity-domain quads of C33 n.
        normal: 2 Q parity-domain quads of C33 A3-dagger e, those of e0, then those of e1.
        direction: ``negative`` is looked at.
        frame: ``exponent`` is looked at.
        index: the winner, one transfer a frame.
    """

    def __init__(self, design: Design) -> None:
        self._design = design
        vector = payloads.vector_quad(design)
        super().__init__(
            {
                "stress": In(stream.Signature(payloads.stress_quad(design))),
                "g": In(stream.Signature(vector)),
                "normal": In(stream.Signature(vector)),
                "direction": In(stream.Signature(payloads.direction(design))),
                "frame": In(stream.Signature(payloads.frame_facts(design))),
                "index": Out(stream.Signature(payloads.sweep_index(design))),
            }
        )

    @property
    def quad_interval(self) -> int:
        """Cycles between two quads of e1 at the shortest."""
        return _PLACES

    @property
    def latency(self) -> int:
        """Cycles from the transfer of the frame's last normal quad (the 2Q-th) to the transfer of the index.

        With D = ceil(log2 P), k levels of the product by K (:func:`product_latency`), R passes and s = 1 if there
        is a tolerance, else 0: ``18 + k + max(D, k) + (R - 1) * pass_interval + 2 D + s + 2 R``.
        """
        to_taxel = _FOLDED + _PLACES + 1  # measured sum behind the last word
        to_lanes = 2 + product_latency(self._design.search.steps)
        again = (self._design.sweep_passes - 1) * pass_interval(self._design)
        return to_taxel + to_lanes + lanes_latency(self._design) + 1 + again + judge_latency(self._design)

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.loader = loader = _Loader(self._design)
        m.submodules.passes = passes = _Passes(self._design)
        m.submodules.lanes = lanes = _Lanes(self._design)
        m.submodules.judge = judge = _Judge(self._design)
        for name in ("stress", "g", "normal"):
            wiring.connect(m, wiring.flipped(getattr(self, name)), getattr(loader, name))
        m.d.comb += [
            loader.known.eq(self.direction.valid & self.frame.valid),
            loader.done.eq(self.index.valid & self.index.ready),
            passes.i.eq(loader.taxel),
            passes.negative.eq(self.direction.payload.negative),
            passes.idle.eq(loader.idle),
            lanes.i.eq(passes.o),
            # A single row stays in the lanes until it is judged.
            lanes.clear.eq(loader.idle | (judge.stands if self._design.sweep_passes > 1 else 0)),
            judge.ended.eq(lanes.ended),
            judge.idle.eq(loader.idle),
            judge.exponent.eq(self.frame.payload.exponent),
            self.direction.ready.eq(judge.found),
            self.frame.ready.eq(judge.found),
            self.index.payload.eq(judge.index),
        ]
        for lane in range(self._design.architecture.sweep_lanes):
            m.d.comb += [judge.z[lane].eq(lanes.z[lane]), judge.xy[lane].eq(lanes.xy[lane])]
        with m.If(judge.found):
            m.d.sync += self.index.valid.eq(1)
        with m.Elif(self.index.ready):
            m.d.sync += self.index.valid.eq(0)
        return m
