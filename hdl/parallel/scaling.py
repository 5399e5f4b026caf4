"""The result stream: forces and resultants scaled to result words, bit-exact to :mod:`tfra.model.fixed.scaling`.

The layout of a frame is that of :mod:`tfra.model.fixed.layout`.
"""

from dataclasses import dataclass
from functools import reduce
from operator import add, or_
from typing import Any

from amaranth import Cat, Module, Mux, Signal, Value, signed, unsigned
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.interface import ports
from tfra.hdl.lib.arithmetic import counter_shape, round_off, shift_right, two_steps
from tfra.hdl.lib.pipeline import delayed, register
from tfra.hdl.lib.streams import SkidBuffer
from tfra.hdl.parallel import payloads
from tfra.model.fixed.cordic import iterations
from tfra.model.fixed.design import Design
from tfra.model.fixed.layout import COUNTER_BITS
from tfra.model.tfra import Status

STAGES = 9
"""Registers between a word's entry and the result: operands, products, sum, product, two shifts, rounding, what lies
beyond the result word, result."""

FINE = 3
"""Bits of a shift that its second step looks at."""

CHUNK = 17
"""Bits of a word for each partial product: unsigned, they fit the signed 18 bits of common multiplier blocks."""

FACTS = ("gain", "total", "chosen", "affine", "direction", "frame", "phi")
"""Streams of one transfer a frame."""


def word_bits(design: Design) -> int:
    """Bits of a word at the entry of the multiplier."""
    header = max(f.bits + (not f.signed) for f in design.layout if f.name not in ("resultant", "forces"))
    return max(design.widths.force, design.widths.division, header)


@dataclass(frozen=True)
class _Entry:
    """A step of a frame: ``word * factor / 2^shift``, only the ``plain`` ones unlimited; or the taxels of a plane."""

    word: Value | int
    factor: Value | int = 1
    shift: Value | int = 0
    plain: bool = True
    taxel: bool = False
    last: bool = False


class Scaling(wiring.Component):
    """Send header, forces and status of every frame (Eq. 31).

    ::

        step --> word ---\\                                          plain? ---\\
        gain --> factor --> partial products -> sum -> >> shift -> round -> saturate -> result
                                                                           overflow? --> status

    Every word takes the same path: header and status have factor one, fields that a frame does not have get factor
    zero, and the status, which is last, collects the overflows before it.  The mantissa enters the multiplier as a
    signed word, to keep to its width; the weight of its top bit follows with the second sum.

    A frame starts when all its facts are valid; forces follow as they arrive, one word per cycle without gaps; the
    facts are taken a cycle after the entry of the status.  Resources: one multiplier of a word by a scalar.
    """

    def __init__(self, design: Design) -> None:
        self._design = design
        super().__init__({
            # Unscaled forces plane by plane, 3 m a frame; the others are facts of the frame.
            "taxel": In(stream.Signature(signed(design.widths.force))),
            "gain": In(stream.Signature(payloads.gain(design))),
            "total": In(stream.Signature(payloads.total(design))),
            "chosen": In(stream.Signature(payloads.chosen(design))),
            "affine": In(stream.Signature(payloads.affine(design))),
            "direction": In(stream.Signature(payloads.direction(design))),
            "frame": In(stream.Signature(payloads.frame_facts(design))),
            "phi": In(stream.Signature(unsigned(iterations(design)))),
            "result": Out(stream.Signature(ports.result(design))),  # ``last`` with the status
        })

    @property
    def latency(self) -> int:
        """Cycles from the one in which ``gain`` is valid, the other facts before it, to the transfer of the first word.

        Between two frames whose facts are all valid, two cycles stay empty.
        """
        return STAGES + SkidBuffer.latency

    @property
    def force_latency(self) -> int:
        """Cycles from the transfer of a taxel to that of its word; from a frame's last one to its status one more."""
        return self.latency

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        advance = Signal()
        valid = Signal(STAGES)
        into = Signal(self._operands(), reset_less=True)
        result = Signal(ports.result(self._design), reset_less=True)
        m.submodules.skid = skid = SkidBuffer(ports.result(self._design))  # so that a register lets all advance
        go = self._enter(m, advance, into)
        m.d.comb += [
            skid.i.valid.eq(valid[-1]),
            skid.i.payload.eq(result),
            advance.eq(skid.i.ready),
        ]
        wiring.connect(m, skid.o, wiring.flipped(self.result))
        with m.If(advance):
            m.d.sync += valid.eq(Cat(go, valid))
            self._finish(m, result, *self._multiply(m, into), valid[-2])
        return m

    def _operands(self) -> data.StructLayout:
        """One word at the entry of the multiplier."""
        facts = payloads.gain(self._design).members
        return data.StructLayout({
            "word": signed(word_bits(self._design)),
            "factor": facts["mantissa"],
            "shift": facts["force_shift"],
            "plain": 1,
            "last": 1,
        })

    def _entries(self, m: Module, counter: Value) -> list[_Entry]:
        """The steps of a frame in the order of :func:`tfra.model.fixed.layout.make_layout`.

        Facts are valid long before their words; values derived from them are in registers by then.
        """
        gain, chosen, contact = self.gain.p, self.chosen.p, self.frame.p.contact
        regular = contact & self.frame.p.traction
        tangential, normal = (register(m, Mux(flag, gain.mantissa, 0)) for flag in (regular, contact))
        status = register(m, self._status(), "status")
        factors = (tangential, tangential, normal)
        fields = {
            "frame": [_Entry(counter)],
            "exponent": [_Entry(self.frame.p.exponent)],
            "sweep_index": [_Entry(chosen.index)],
            "phi": [_Entry(self.phi.p, regular)],
            "mu": [_Entry(gain.mu)],
            "mu_x": [_Entry(chosen.mu_x)],
            "mu_y": [_Entry(chosen.mu_y)],
            "resultant": [
                _Entry(self.total.p.words[axis], factor, gain.resultant_shift, plain=False)
                for axis, factor in enumerate(factors)
            ],
            "forces": [_Entry(0, factor, gain.force_shift, plain=False, taxel=True) for factor in factors],
            "status": [_Entry(status, last=True)],
        }
        return [entry for field in self._design.layout for entry in fields[field.name]]

    def _status(self) -> Value:
        """Status of a frame, except the bits that depend on its words."""
        frame = self.frame.p
        regular = frame.contact & frame.traction
        flags = {
            Status.NO_CONTACT: ~frame.contact,
            Status.COMPRESSION_ONLY: frame.contact & ~frame.traction,
            Status.NO_DIRECTION: regular & self.direction.p.vanishing,
            Status.VANISHING_DENOMINATOR: regular & self.affine.p.vanishing,
            Status.DEPENDENT_OUT_OF_RANGE: regular & self.chosen.p.out_of_range,
            Status.INPUT_SATURATED: frame.saturated,
            Status.OUTPUT_SATURATED: frame.contact & self.gain.p.overflow,
        }
        return Cat(flags[Status(1 << place)] for place in range(len(flags)))

    def _enter(self, m: Module, advance: Value, into: data.View) -> Value:
        """Load the next word with its factor and shift; true when there is one.

        =========== ========= ========== =========== ===============================================================
        entry       ``first`` ``taxels`` ``closing`` enters
        =========== ========= ========== =========== ===============================================================
        counter     1         0          0           when all facts of its frame are valid
        header      0         0          0           in every cycle
        plane       0         1          0           as taxels come; ``move`` to the next entry with the last of them
        status      0         0          1           in every cycle; the facts are taken a cycle later
        =========== ========= ========== =========== ===============================================================

        The facts of an entry are stable, so they are selected while the one before enters, which takes no time later.
        """
        counter = Signal(COUNTER_BITS)
        entries = self._entries(m, counter)
        step = Signal(len(entries), init=1)  # one-hot, since it selects many signals
        taxels = Signal()
        closing = Signal()
        selected = Signal(into.shape(), init={"factor": 1, "plain": 1})  # the first entry, of frame 0
        first = Signal(init=1)
        go = Signal()
        move = Signal()
        facts_valid = self._take_facts(m, advance & closing)
        m.d.comb += [
            go.eq(Mux(taxels, self.taxel.valid, ~first | facts_valid)),
            self.taxel.ready.eq(advance & taxels),
            move.eq(advance & go & (~taxels | self._last_taxel(m))),
        ]
        with m.If(advance):
            m.d.sync += into.eq(selected)
            m.d.sync += into.word.eq(Mux(taxels, self.taxel.p, selected.word))
        with m.If(move):
            following = list(zip(step, [*entries[1:], entries[0]], strict=True))
            m.d.sync += step.eq(step.rotate_left(1))
            m.d.sync += first.eq(closing)
            m.d.sync += taxels.eq(_chosen(following, "taxel"))
            m.d.sync += closing.eq(_chosen(following, "last"))
            m.d.sync += [getattr(selected, name).eq(_chosen(following, name)) for name in into.shape().members]
        with m.If(move & first):
            m.d.sync += counter.eq(counter + 1)
        return go

    def _take_facts(self, m: Module, status_enters: Value) -> Value:
        """Accept the facts a cycle after the status; whether those of the next frame are valid, which they then stay.

        The gain comes last.  The others are checked through a register, a cycle late, since the path to their queues is
        long; it is low for the next frame while those of this one are accepted.
        """
        facts = [getattr(self, name) for name in FACTS]
        taken = register(m, status_enters, "taken", control=True)
        known = Cat(fact.valid for fact in facts[1:]).all() & ~status_enters & ~taken
        m.d.comb += (fact.ready.eq(taken) for fact in facts)
        return register(m, known, "known", control=True) & self.gain.valid

    def _last_taxel(self, m: Module) -> Value:
        """Whether the next taxel is a plane's last one."""
        number = Signal(counter_shape(self._design.sensor.taxels - 1))
        last = Signal()
        with m.If(self.taxel.valid & self.taxel.ready):
            m.d.sync += number.eq(Mux(last, 0, number + 1))
            m.d.sync += last.eq(number == self._design.sensor.taxels - 2)
        return last

    def _multiply(self, m: Module, into: data.View) -> tuple[Value, Value, Value]:
        """``word * factor / 2^shift`` rounded half up, with the word's flags beside it."""
        word, bits = into.word, len(into.factor)
        partials = [register(m, part * into.factor.as_signed(), "partial") for part in _chunks(word)]
        # An unsigned factor is its signed word plus 2^bits where its top bit is set.
        top = register(m, Mux(into.factor[-1], word, 0).as_signed(), "top")
        width = len(word) + bits
        placed = (partial << (CHUNK * number) for number, partial in enumerate(partials))
        total = register(m, reduce(add, placed)[:width].as_signed(), "sum")
        product = register(m, (total + (register(m, top, "top") << bits))[:width].as_signed(), "product")
        reach = width.bit_length()  # a longer shift leaves the sign alone
        limited = Mux(into.shift[reach:].any(), (1 << reach) - 1, into.shift[:reach])
        shift = delayed(m, register(m, limited, "shift"), 2, "shift")
        coarse, fine = two_steps(shift, FINE)
        moved = register(m, shift_right(product, coarse), "moved")
        shifted = register(m, moved >> register(m, fine, "fine"), "shifted")
        rounded = register(m, round_off(shifted, 1), "rounded")
        flags = delayed(m, Cat(into.plain, into.last), 6, "flags")
        return rounded, flags[0], flags[1]

    def _finish(self, m: Module, result: data.View, rounded: Value, plain: Value, last: Value, valid: Value) -> None:
        """Limit the word, and set the status bit if it was limited."""
        output, place = self._design.widths.output, Status.OUTPUT_SATURATED.bit_length() - 1
        limited = Signal()
        above = rounded[output - 1 :]
        beyond = register(m, ~plain & above.any() & ~above.all(), "beyond")
        rounded = register(m, rounded, "rounded")
        last = register(m, last, "ends")
        top = Cat((~rounded[-1]).replicate(output - 1), rounded[-1]).as_signed()
        m.d.sync += result.data.eq(Mux(beyond, top, rounded))
        m.d.sync += result.last.eq(last)
        with m.If(last):
            m.d.sync += result.data[place].eq(rounded[place] | limited)
        with m.If(valid):
            m.d.sync += limited.eq(~last & (limited | beyond))


def _chosen(following: list[tuple[Value, _Entry]], name: str) -> Value:
    """``name`` of the entry whose bit is set: OR of all entries, each zero unless its bit is set."""
    return reduce(or_, (Mux(bit, getattr(entry, name), 0) for bit, entry in following))


def _chunks(word: Value) -> list[Value]:
    """``word`` in pieces of ``CHUNK`` bits, the lower ones unsigned; the last one has the sign and up to a bit more."""
    if len(word) <= CHUNK + 1:
        return [word]
    return [word[:CHUNK], *_chunks(word[CHUNK:].as_signed())]
