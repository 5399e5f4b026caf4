"""Block-floating input of a frame, as quads of mirror taxels."""

from typing import Any

from amaranth import Cat, Module, Mux, Signal, Value, signed
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.arithmetic import add_carry, counter_shape, leading_zeros, magnitude_bits, two_steps
from tfra.hdl.lib.pipeline import register
from tfra.hdl.lib.ram import Ram
from tfra.hdl.lib.streams import SkidBuffer
from tfra.hdl.parallel.payloads import frame_facts, stress_quad
from tfra.hdl.parallel.raster import Raster
from tfra.model.fixed.design import Design

_FINE = 2
"""Bits of the exponent by which the second step of a shift moves."""


class Normaliser(wiring.Component):
    """Shift a frame so that its largest code fills the word, and send it as quads of mirror taxels.

    b = code << exponent, where the exponent counts the leading zeros of the OR of ``code ^ sign``; equal to
    :func:`tfra.model.fixed.normaliser.normaliser`::

        taxel -> register -+-> four banks, one per mirror place, two pages -> register -> shift -> skid -> quads
                           +-> sum of |code|, OR of code ^ sign -> leading zeros -> shift -> frame
                           +-> code ^ sign >= contact threshold, OR of it ------------------> frame

    A frame loads into one page while the one before leaves the other.  Its last taxel waits until the quads and the
    facts of the frame before have all been taken: there is one exponent, and the facts of two frames never meet.

    A taxel a cycle, a quad a cycle, a frame every ``max(m, latency + Q)`` cycles.  Resources: four memories of ``2 Q``
    codes, barrel shifters for four codes and the sum, no multiplier; 10 x 10 taxels of 14 bits take 820 LUT4,
    350 flip-flops and 64 16 x 4 memories of an ECP5.
    """

    def __init__(self, design: Design) -> None:
        self._design = design
        super().__init__({
            "taxel": In(stream.Signature(signed(design.adc.bits))),  # codes of a frame row by row
            # Q quads of the normalised frame in the order of ``to_quads``.
            "quads": Out(stream.Signature(stress_quad(design))),
            "frame": Out(stream.Signature(frame_facts(design))),  # one transfer a frame; does not wait for the quads
        })

    @property
    def latency(self) -> int:
        """Cycles from the transfer of a frame's last taxel to those of its first quad and of its facts."""
        return 5

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.raster = raster = Raster(self._design)
        quads_left = Signal()  # quads of the frame before are left in the unit
        facts_left = Signal()
        waiting = Signal()  # the facts wait to be taken
        end = Signal()
        steps = Signal(4)  # bit k: the last taxel came k + 1 cycles ago
        code = Signal(signed(self._design.adc.bits), reset_less=True)
        counts = register(m, raster.transfer, "counts", control=True)
        first = register(m, raster.row_start & (raster.row == 0), "first")
        facts = _facts(m, self._design, code, counts, first, steps)
        m.d.comb += [
            self.taxel.ready.eq(~(raster.last & (quads_left | facts_left))),
            raster.transfer.eq(self.taxel.valid & self.taxel.ready),
            end.eq(raster.transfer & raster.last),
            self.frame.valid.eq(waiting),
            self.frame.payload.eq(facts),
        ]
        m.d.sync += [
            code.eq(self.taxel.payload),
            steps.eq(Cat(end, steps)),
        ]
        with m.If(waiting & self.frame.ready):
            m.d.sync += waiting.eq(0)
            m.d.sync += facts_left.eq(0)
        with m.If(steps[3]):
            m.d.sync += waiting.eq(1)
        with m.If(self._leave(m, raster, code, steps[0], facts.exponent)):
            m.d.sync += quads_left.eq(0)
        with m.If(end):
            m.d.sync += facts_left.eq(1)
            m.d.sync += quads_left.eq(1)
        return m

    def _leave(self, m: Module, raster: Raster, code: Value, start: Value, exponent: Value) -> Value:
        """Read the quads of a frame and shift them in two steps; true when the last one is taken."""
        quad = stress_quad(self._design)
        m.submodules.skid = skid = SkidBuffer(data.StructLayout({"quad": quad, "end": 1}))  # a register lets all go
        advance = Signal()
        running = Signal()
        final = Signal()
        coarse, fine = two_steps(exponent, _FINE)
        number = Signal(counter_shape(self._design.quads - 1))  # of the quad to be read
        stored = _pages(m, self._design, raster, code, advance, number)
        read = Signal(quad, reset_less=True)
        valid = Signal(2)  # after the memory, and after the register ``read``
        end = Signal(2)
        m.d.comb += [
            advance.eq(skid.i.ready),
            final.eq(number == self._design.quads - 1),
            skid.i.valid.eq(valid[1]),
            *(skid.i.p.quad[place].eq(read[place] << fine) for place in range(4)),
            skid.i.p.end.eq(end[1]),
            self.quads.valid.eq(skid.o.valid),
            self.quads.payload.eq(skid.o.p.quad),
            skid.o.ready.eq(self.quads.ready),
        ]
        with m.If(advance):
            m.d.sync += valid.eq(Cat(running, valid))
            m.d.sync += end.eq(Cat(final, end))
            m.d.sync += [read[place].eq(stored[place] << coarse) for place in range(4)]
        with m.If(advance & running):
            m.d.sync += running.eq(~final)
            m.d.sync += number.eq(Mux(final, 0, number + 1))
        with m.If(start):
            m.d.sync += running.eq(1)
        return self.quads.valid & self.quads.ready & skid.o.p.end


def _facts(m: Module, design: Design, code: Value, valid: Value, first: Value, steps: Value) -> data.View:
    """Sum of magnitudes and ORs over the codes of a frame, scaled at its end.

    ``code`` counts when ``valid``, as the ``first`` of its frame; bit k of ``steps``: the last taxel came k + 1 cycles
    ago.  Facts are complete four cycles after it, their exponent two.
    """
    longest = design.widths.magnitude
    negative, size = code[-1], magnitude_bits(code)
    # All bits set beside the sign: both ends of the range, and nothing else.
    flags = Cat(size, negative, ~negative & code.any(), size.all(), size >= design.adc.threshold)
    frame_flags = Signal(len(flags), reset_less=True)
    compressed, stretched, saturated, reached = frame_flags[len(size) :]
    magnitude = Signal(longest, reset_less=True)
    whole = Signal(longest, reset_less=True)
    with m.If(valid):
        # |code| = (code ^ sign) + sign, so that the adder's carry input does the negation.
        m.d.sync += [
            frame_flags.eq(Mux(first, 0, frame_flags) | flags),
            magnitude.eq(add_carry(Mux(first, 0, magnitude), size, negative)),
        ]
    facts = Signal(frame_facts(design), reset_less=True)
    with m.If(steps[1]):
        m.d.sync += [
            facts.exponent.eq(leading_zeros(frame_flags[: len(size)])),
            facts.contact.eq(compressed & reached if design.adc.threshold else compressed),
            facts.traction.eq(stretched),
            facts.saturated.eq(saturated),
            whole.eq(magnitude),
        ]
    coarse, fine = two_steps(facts.exponent, _FINE)
    moved = register(m, (whole << coarse)[:longest], "moved")
    with m.If(steps[3]):
        m.d.sync += facts.magnitude.eq(moved << fine)
    return facts


def _pages(m: Module, design: Design, raster: Raster, code: Value, read: Value, quad: Value) -> list[Value]:
    """The folded frame in four banks, one for each place in a quad, and two pages: one loads, the other is read.

    ``code``: the taxel that moved the raster a cycle ago.  Returns the words of ``quad``, a cycle after ``read``.
    """
    page = Signal()
    with m.If(raster.transfer & raster.last):
        m.d.sync += page.eq(~page)
    place = register(m, Cat(raster.quad, page), "place")
    # On the middle line of an odd count a taxel is its own mirror image and belongs to both sides.
    rows, columns = design.sensor.rows, design.sensor.columns
    side_y = (raster.row < design.quad_rows, raster.row >= rows // 2)
    side_x = (raster.column < design.quad_columns, raster.column >= columns // 2)
    words = []
    for number in range(4):
        bank = Ram(m, f"bank{number}", code.shape(), (1 << len(raster.quad)) + design.quads)
        enable = raster.transfer & side_y[number >> 1] & side_x[number & 1]
        bank.write(register(m, enable, f"enable{number}", control=True), place, code)
        words.append(bank.read(Cat(quad, ~page), read))
    return words
