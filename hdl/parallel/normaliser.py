"""Block-floating input of a frame, as quads of mirror taxels."""

from typing import Any

from amaranth import Cat, Elaboratable, Module, Mux, Signal, Value, signed
from amaranth.lib import data, memory, stream, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.arithmetic import add_carry, counter_shape, leading_zeros, magnitude_bits, two_steps
from tfra.hdl.lib.pipeline import register
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
        m.submodules.facts = facts = _Facts(self._design)
        m.submodules.pages = pages = _Pages(self._design, raster)
        quads_left = Signal()  # quads of the frame before are left in the unit
        facts_left = Signal()
        waiting = Signal()  # the facts wait to be taken
        end = Signal()
        steps = Signal(4)  # bit k: the last taxel came k + 1 cycles ago
        code = Signal(signed(self._design.adc.bits), reset_less=True)
        m.d.comb += [
            self.taxel.ready.eq(~(raster.last & (quads_left | facts_left))),
            raster.transfer.eq(self.taxel.valid & self.taxel.ready),
            end.eq(raster.transfer & raster.last),
            facts.code.eq(code),
            facts.steps.eq(steps),
            pages.code.eq(code),
            self.frame.valid.eq(waiting),
            self.frame.payload.eq(facts.result),
        ]
        m.d.sync += [
            code.eq(self.taxel.payload),
            steps.eq(Cat(end, steps)),
            facts.valid.eq(raster.transfer),
            facts.first.eq(raster.row_start & (raster.row == 0)),
        ]
        with m.If(waiting & self.frame.ready):
            m.d.sync += waiting.eq(0)
            m.d.sync += facts_left.eq(0)
        with m.If(steps[3]):
            m.d.sync += waiting.eq(1)
        with m.If(self._leave(m, pages, steps[0], facts.result.exponent)):
            m.d.sync += quads_left.eq(0)
        with m.If(end):
            m.d.sync += facts_left.eq(1)
            m.d.sync += quads_left.eq(1)
        return m

    def _leave(self, m: Module, pages: "_Pages", start: Value, exponent: Value) -> Value:
        """Read the quads of a frame and shift them in two steps; true when the last one is taken."""
        quad = stress_quad(self._design)
        m.submodules.skid = skid = SkidBuffer(data.StructLayout({"quad": quad, "end": 1}))  # a register lets all go
        advance = Signal()
        running = Signal()
        final = Signal()
        coarse, fine = two_steps(exponent, _FINE)
        read = Signal(quad, reset_less=True)
        valid = Signal(2)  # after the memory, and after the register ``read``
        end = Signal(2)
        m.d.comb += [
            advance.eq(skid.i.ready),
            final.eq(pages.quad == self._design.quads - 1),
            pages.read.eq(advance),
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
            m.d.sync += [read[place].eq(pages.stored[place] << coarse) for place in range(4)]
        with m.If(advance & running):
            m.d.sync += running.eq(~final)
            m.d.sync += pages.quad.eq(Mux(final, 0, pages.quad + 1))
        with m.If(start):
            m.d.sync += running.eq(1)
        return self.quads.valid & self.quads.ready & skid.o.p.end


class _Facts(Elaboratable):
    """Sum of magnitudes and ORs over the codes of a frame, scaled at its end."""

    def __init__(self, design: Design) -> None:
        self._bits, self._magnitude = design.adc.bits, design.widths.magnitude
        self._threshold = design.adc.threshold
        self.code = Signal(signed(self._bits))
        self.valid = Signal()  # the code counts
        self.first = Signal(reset_less=True)  # ... as the first of its frame
        self.steps = Signal(4)  # bit k: the frame's last taxel came k + 1 cycles ago
        # Complete four cycles after the last taxel, its exponent two.
        self.result = Signal(frame_facts(design), reset_less=True)

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        negative, size = self.code[-1], magnitude_bits(self.code)
        # All bits set beside the sign: both ends of the range, and nothing else.
        flags = Cat(size, negative, ~negative & self.code.any(), size.all(), size >= self._threshold)
        frame_flags = Signal(len(flags), reset_less=True)
        compressed, stretched, saturated, reached = frame_flags[len(size) :]
        magnitude = Signal(self._magnitude, reset_less=True)
        whole = Signal(self._magnitude, reset_less=True)
        with m.If(self.valid):
            # |code| = (code ^ sign) + sign, so that the adder's carry input does the negation.
            m.d.sync += [
                frame_flags.eq(Mux(self.first, 0, frame_flags) | flags),
                magnitude.eq(add_carry(Mux(self.first, 0, magnitude), size, negative)),
            ]
        result = self.result
        with m.If(self.steps[1]):
            m.d.sync += [
                result.exponent.eq(leading_zeros(frame_flags[: len(size)])),
                result.contact.eq(compressed & reached if self._threshold else compressed),
                result.traction.eq(stretched),
                result.saturated.eq(saturated),
                whole.eq(magnitude),
            ]
        coarse, fine = two_steps(result.exponent, _FINE)
        moved = register(m, (whole << coarse)[: self._magnitude], "moved")
        with m.If(self.steps[3]):
            m.d.sync += result.magnitude.eq(moved << fine)
        return m


class _Pages(Elaboratable):
    """The folded frame in four banks, one for each place in a quad, and two pages: one loads, the other is read."""

    def __init__(self, design: Design, raster: Raster) -> None:
        self._design, self._raster = design, raster
        self.code = Signal(signed(design.adc.bits))  # the taxel that moved the raster a cycle ago
        self.quad = Signal(counter_shape(design.quads - 1))  # number of the quad to be read
        self.read = Signal()
        self.stored = Signal(stress_quad(design))  # the quad, a cycle after ``read``

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        design, raster = self._design, self._raster
        page = Signal()
        with m.If(raster.transfer & raster.last):
            m.d.sync += page.eq(~page)
        place = Signal(len(raster.quad) + 1, reset_less=True)
        m.d.sync += place.eq(Cat(raster.quad, page))
        # On the middle line of an odd count a taxel is its own mirror image and belongs to both sides.
        rows, columns = design.sensor.rows, design.sensor.columns
        side_y = (raster.row < design.quad_rows, raster.row >= rows // 2)
        side_x = (raster.column < design.quad_columns, raster.column >= columns // 2)
        for number in range(4):
            bank = memory.Memory(shape=self.code.shape(), depth=(1 << len(raster.quad)) + design.quads, init=[])
            m.submodules[f"bank{number}"] = bank
            write = bank.write_port()
            read = bank.read_port()
            enable = Signal(name=f"enable{number}")
            m.d.sync += enable.eq(raster.transfer & side_y[number >> 1] & side_x[number & 1])
            m.d.comb += [
                write.en.eq(enable),
                write.addr.eq(place),
                write.data.eq(self.code),
                read.en.eq(self.read),
                read.addr.eq(Cat(self.quad, ~page)),
                self.stored[number].eq(read.data),
            ]
        return m
