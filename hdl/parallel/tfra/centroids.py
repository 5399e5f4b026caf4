"""Direction of the tangential force from the centroids of compression and traction."""

from dataclasses import dataclass
from functools import reduce
from itertools import pairwise
from operator import or_
from typing import Any

from amaranth import Cat, Elaboratable, Module, Mux, Shape, Signal, Value, signed, unsigned
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.arithmetic import add_carry, add_or_subtract, counter_shape, magnitude_bits, round_top
from tfra.hdl.lib.pipeline import register
from tfra.hdl.parallel.payloads import direction
from tfra.hdl.parallel.raster import Raster
from tfra.model.fixed.design import Design
from tfra.model.fixed.tfra.centroids import pitch_ratio


@dataclass(frozen=True)
class _Sizes:
    """Word lengths of the serial part, in bits.

    A product of ``word`` and ``multiplier`` bits leaves its register to the right, lowest bit first; the remaining sum
    is no longer than the word, so ``product`` always holds both.
    """

    word: int
    multiplier: int
    ratio: int

    @property
    def product(self) -> int:
        """Bits of the register."""
        return self.word + self.multiplier

    @property
    def shifts(self) -> list[int]:
        """Distances of the optional shifts that normalise a product, one after the other."""
        return shift_distances(self.product - 1)


def shift_distances(most: int) -> list[int]:
    """Distances that add up to any shift of at most ``most`` places, each used where it is not too far; all are needed.

    Powers of four, each but the largest three times: three distances take half the multiplexers of the six powers of
    two.
    """
    distance: int = 4 ** ((most.bit_length() - 1) // 2)
    distances = [distance] * (most // distance)
    while distance := distance // 4:
        distances += [distance] * 3
    return distances


def _sizes(design: Design) -> _Sizes:
    w, ratio = design.widths, max(pitch_ratio(design)).bit_length()
    return _Sizes(max(w.moment + 1, w.division), max(w.magnitude, ratio), ratio)


class Centroids(wiring.Component):
    """cos and sin of the direction from the centroid of traction to that of compression, times a common factor.

    Eqs. 11, 19-22 with u = columns - j, v = rows - i; equal to :func:`tfra.model.fixed.tfra.centroids.centroids`::

        taxel -> sums of a row -> sum S and moment U of the frame -> moment V     for compression and for traction
        (U_t S_c - U_c S_t, V_t S_c - V_c S_t) -> normalise -> times the pitches -> normalise -> direction

    Prefix sums weigh the taxels, so the moments take no multiplier: U adds the running sum of the row at every
    taxel, V the running sum of the frame at every end of a row.  The second line is serial: x and y each have one
    adder that multiplies a bit of S (or of the pitch ratio) a cycle, and one register that normalises in steps of
    ..., 16, 4, 1 places.  It works on copies while the next frame accumulates; that frame's last taxel waits until the
    direction has been taken.

    A taxel a cycle, a frame every ``max(m, latency + 1)`` cycles.  Resources: about 20 registers of a
    moment's length, no multiplier; 10 x 10 taxels of 14 bits take 810 LUT4 and 560 flip-flops of an ECP5.
    """

    def __init__(self, design: Design) -> None:
        self._design = design
        super().__init__({
            "taxel": In(stream.Signature(signed(design.adc.bits))),  # codes of a frame row by row
            "direction": Out(stream.Signature(direction(design))),  # one transfer a frame
        })

    @property
    def latency(self) -> int:
        """Cycles from the transfer of a frame's last taxel to the transfer of its direction."""
        sizes = _sizes(self._design)
        sums, products = 4, (self._design.widths.magnitude + 1) + (sizes.ratio + 1)
        normalisations, rounding, decision = 2 * 2 * len(sizes.shifts), 1, 4
        return sums + products + normalisations + rounding + decision

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.raster = raster = Raster(self._design)
        m.submodules.solver = solver = _Solver(self._design)
        m.d.comb += [
            self.taxel.ready.eq(~(raster.last & solver.busy)),
            raster.transfer.eq(self.taxel.valid & self.taxel.ready),
            self.direction.valid.eq(solver.valid),
            self.direction.payload.eq(solver.result),
            solver.taken.eq(self.direction.ready),
        ]
        flags = self._flags(m, raster)
        code = Signal(signed(self._design.adc.bits), reset_less=True)
        m.d.sync += code.eq(self.taxel.payload)
        negative, seen = code[-1], magnitude_bits(code)
        for name, chosen, carry in (("compression", negative, negative), ("traction", ~negative, 0)):
            # |code| = (code ^ sign) + sign, so that the adder's carry input does the negation.
            zone = _zone(m, self._design, flags, Mux(chosen, seen, 0), carry, name)
            m.d.comb += getattr(solver, name).eq(zone)
        m.d.comb += [
            solver.claim.eq(register(m, raster.transfer & raster.last, "claim", control=True)),
            solver.load_u.eq(flags[_STAGES.index("v")].last),  # after the stage of s and u
            solver.load_v.eq(flags[_STAGES.index("whole")].last),
        ]
        return m

    def _flags(self, m: Module, raster: Raster) -> list[data.View]:
        """Where the taxel in each stage of the sums is; a stage is empty when nothing is set."""
        flags = [Signal(_FLAGS, name=f"at_{stage}") for stage in _STAGES]
        first = flags[0]
        m.d.sync += [
            first.taxel.eq(raster.transfer),
            first.row_end.eq(raster.transfer & raster.row_end),
            first.last.eq(raster.transfer & raster.last),
            first.row_start.eq(raster.row_start),
            first.first_row.eq(raster.row == 0),
            *(after.eq(before) for before, after in pairwise(flags)),
        ]
        return flags


_STAGES = ("row", "sum", "v", "whole")
"""Where a taxel is: in the sum of its row, in S and U, in V, in all of them."""

_FLAGS = data.StructLayout({"taxel": 1, "row_end": 1, "last": 1, "row_start": 1, "first_row": 1})


def _sums(design: Design) -> data.StructLayout:
    """Sum of a zone's magnitudes, and its moments about the column after the last and the row after the last."""
    w = design.widths
    moment = unsigned(w.moment)
    return data.StructLayout({"s": unsigned(w.magnitude), "u": moment, "v": moment})


def _zone(m: Module, design: Design, flags: list[data.View], bits: Value, carry: Value | int, name: str) -> data.View:
    """Sum and moments of compression or traction of the frame until now; the taxel is ``bits + carry``.

    A stage each: ``row``; ``s`` and ``u`` in stage ``sum``; ``v``.
    """
    at_row, at_sum, at_v, _ = flags
    sums = Signal(_sums(design), name=f"{name}_sums", reset_less=True)
    longest = design.sensor.columns << (design.adc.bits - 1)
    row = Signal(longest.bit_length(), name=f"{name}_row", reset_less=True)
    with m.If(at_row.taxel):
        m.d.sync += row.eq(add_carry(Mux(at_row.row_start, 0, row), bits, carry))
    with m.If(at_sum.taxel):
        m.d.sync += sums.u.eq(Mux(at_sum.row_start & at_sum.first_row, 0, sums.u) + row)
    with m.If(at_sum.row_end):
        m.d.sync += sums.s.eq(Mux(at_sum.first_row, 0, sums.s) + row)
    with m.If(at_v.row_end):
        m.d.sync += sums.v.eq(Mux(at_v.first_row, 0, sums.v) + sums.s)
    return sums


class _Solver(Elaboratable):
    """The serial part, from copies of the sums to the direction.

    Every state but those that wait takes a fixed number of cycles:

    ========== ===================================================================================
    state      what happens
    ========== ===================================================================================
    idle       until the frame's last taxel comes
    load       the sums are copied when they are complete
    multiply   a bit of the factors a cycle, the lowest first
    look       can both values move by the distance of this step?
    move       they do, or not; look again until all steps have been taken
    pitch      the normalised values are rounded and become the words that the pitches multiply
    compare    after the second product: |y| with |x|, words rounded
    test       sign of the difference; a cycle later ``decide`` writes the rest of ``result``
    ========== ===================================================================================

    A product is ``plus * factor0 - minus * factor1`` at first; then ``plus`` times the axis' own factor, its pitch.
    It enters ``value`` from above and so ends up times a power of two, which normalisation does not mind.
    """

    def __init__(self, design: Design) -> None:
        self._design, self._sizes = design, _sizes(design)
        self.compression = Signal(_sums(design))  # sums of all compressed taxels
        self.traction = Signal(_sums(design))  # ... of all stretched ones
        self.claim = Signal()  # pulse, with the frame's last taxel
        self.load_u = Signal()  # pulse: s and u are complete
        self.load_v = Signal()  # pulse, a cycle later: v is complete, too
        self.taken = Signal()  # ``result`` is taken, if it is valid
        self.busy = Signal()  # from ``claim`` until ``result`` has been taken
        self.valid = Signal()  # ``result`` stands
        self.result = Signal(direction(design), reset_less=True)

        sizes = self._sizes
        self._plus = _pair("plus", signed(sizes.word))
        self._minus = _pair("minus", unsigned(design.widths.moment))
        self._factor = _pair("factor", unsigned(sizes.multiplier))
        self._term = _pair("term", signed(sizes.word))
        self._value = _pair("value", signed(sizes.product))
        self._distances = sorted(set(sizes.shifts))
        self._by_pitch = Signal()  # the second product, and what follows
        self._left = Signal(counter_shape(sizes.multiplier))  # remaining bits of the factors
        self._step = Signal(len(sizes.shifts))  # of a normalisation, one bit set
        self._adding = Signal()  # TIMING: state -> term, value, factor
        self._shift = Signal(len(self._distances))  # TIMING: step -> value: the distance that is moved by, one bit set

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        pitch = Signal()
        decide = Signal()
        difference = Signal(signed(len(self._top(0)) + 1), reset_less=True)
        positive = register(m, ~difference[-1] & difference.any(), "positive")
        m.d.sync += self._shift.eq(0)
        m.d.sync += pitch.eq(0)
        m.d.sync += decide.eq(0)
        with m.FSM():
            with m.State("idle"), m.If(self.claim):
                m.d.sync += self.busy.eq(1)
                m.next = "load"
            with m.State("load"), m.If(self.load_v):
                m.d.sync += self._adding.eq(1)
                m.next = "multiply"
            with m.State("multiply"):
                m.d.sync += self._left.eq(self._left - 1)
                m.d.sync += self._step.eq(1)
                with m.If(self._left == 0):
                    m.d.sync += self._adding.eq(0)
                    m.next = "look"
            with m.State("look"):
                m.d.sync += self._shift.eq(self._look())
                m.next = "move"
            with m.State("move"):
                m.d.sync += self._step.eq(self._step << 1)
                with m.If(~self._step[-1]):
                    m.next = "look"
                with m.Elif(self._by_pitch):
                    m.next = "compare"
                with m.Else():
                    m.d.sync += pitch.eq(1)
                    m.next = "pitch"
            with m.State("pitch"):
                m.d.sync += self._by_pitch.eq(1)
                m.d.sync += self._adding.eq(1)
                m.next = "multiply"
            with m.State("compare"):
                m.d.sync += self._compare(difference)
                m.next = "test"
            with m.State("test"):
                m.d.sync += self._by_pitch.eq(0)
                m.d.sync += decide.eq(1)
                m.next = "idle"
        with m.If(decide):
            self._decide(m, difference, positive)
        with m.If(self.valid & self.taken):
            m.d.sync += self.busy.eq(0)
            m.d.sync += self.valid.eq(0)
        self._load(m, pitch)
        self._work(m, self.load_v | pitch)
        return m

    def _load(self, m: Module, pitch: Value) -> None:
        """Copy the sums while they are whole, since those of the next frame follow at once; later their pitches."""
        (minus_x, minus_y), (plus_x, plus_y) = self._minus, self._plus
        with m.If(self.load_u):
            m.d.sync += plus_x.eq(self.traction.u)
            m.d.sync += minus_x.eq(self.compression.u)
            m.d.sync += self._factor[0].eq(self.compression.s)
            m.d.sync += self._factor[1].eq(self.traction.s)
        with m.If(self.load_v):
            m.d.sync += plus_y.eq(self.traction.v)
            m.d.sync += minus_y.eq(self.compression.v)
            m.d.sync += self._left.eq(self._design.widths.magnitude)
        with m.If(pitch):
            for axis, factor in enumerate(pitch_ratio(self._design)):
                rounded = round_top(self._value[axis], self._design.widths.division)
                m.d.sync += self._plus[axis].eq(rounded)
                m.d.sync += self._factor[axis].eq(factor)
            m.d.sync += self._left.eq(self._sizes.ratio)

    def _work(self, m: Module, clear: Value) -> None:
        """Terms and values: zero before a product, then a bit of the factors a cycle, then steps of normalisation.

        The operations are decoded into separate registers, because the fan-out of the state is too high here.
        """
        low = self._sizes.multiplier
        bit0, bit1 = (factor[0] for factor in self._factor)
        plus_on, minus_on = (bit0, Mux(self._by_pitch, bit1, bit0)), bit1 & ~self._by_pitch
        for axis, (term, value) in enumerate(zip(self._term, self._value, strict=True)):
            with m.If(clear):  # the first cycle of a multiplication adds the term that is not yet there
                m.d.sync += term.eq(0)
                m.d.sync += value.eq(0)
            with m.Elif(self._adding):
                m.d.sync += [
                    term.eq(Mux(plus_on[axis], self._plus[axis], 0) - Mux(minus_on, self._minus[axis], 0)),
                    value.eq(Cat(value[1:low], value[low:].as_signed() + term)),
                ]
            with m.Elif(self._shift.any()):
                m.d.sync += value.eq(self._shifted(value))
        with m.If(self._adding):
            m.d.sync += [factor.eq(factor >> 1) for factor in self._factor]

    def _look(self) -> Value:
        """The distance of the present step if neither value overflows: all bits that it drops equal the sign."""
        enabled = []
        for distance in self._distances:
            flat = ~Cat(magnitude_bits(value[-1 - distance :]) for value in self._value).any()
            steps = [step for step, at in zip(self._step, self._sizes.shifts, strict=True) if at == distance]
            enabled.append(flat & Cat(steps).any())
        return Cat(enabled)

    def _shifted(self, value: Value) -> Value:
        """``value`` shifted by the one enabled distance."""
        moved = zip(self._shift, self._distances, strict=True)
        return reduce(or_, ((value << places)[: len(value)] & on.replicate(len(value)) for on, places in moved))

    def _top(self, axis: int) -> Value:
        """All bits of a normalised length that can differ from zero."""
        bits = self._design.widths.division + self._sizes.ratio
        return self._value[axis][-bits:].as_signed()

    def _compare(self, difference: Signal) -> list[Any]:
        """``|y| - |x|`` with the sign of y, and the rounded words."""
        x, y = self._top(0), self._top(1)
        cos, sin = (round_top(value, self._design.formats.bits("direction")) for value in self._value)
        return [
            difference.eq(add_or_subtract(y, x, x[-1] == y[-1])),
            self.result.vanishing.eq(~(x | y).any()),
            self.result.cos.eq(cos),
            self.result.sin.eq(sin),
        ]

    def _decide(self, m: Module, difference: Signal, positive: Value) -> None:
        """The longer of |x| and |y|, which is swept along, and its sign; cos = 1 where both vanish."""
        x_negative, y_negative = (value[-1] for value in self._value)
        sweep_y = Signal()
        m.d.comb += sweep_y.eq(Mux(y_negative, difference[-1], positive))
        m.d.sync += [
            self.result.sweep_y.eq(sweep_y),
            self.result.negative.eq(Mux(sweep_y, y_negative, x_negative)),
            self.valid.eq(1),
        ]
        with m.If(self.result.vanishing):
            m.d.sync += self.result.cos.eq((1 << (self._design.formats.bits("direction") - 1)) - 1)


def _pair(name: str, shape: Shape) -> tuple[Signal, Signal]:
    """A register for x and one for y."""
    return Signal(shape, name=f"{name}_x", reset_less=True), Signal(shape, name=f"{name}_y", reset_less=True)
