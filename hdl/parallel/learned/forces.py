"""Forces at the taxels: bit-exact hardware of :func:`tfra.model.fixed.learned.share.shared`."""

from typing import Any

from amaranth import Array, Cat, Const, Module, Mux, Value
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.arithmetic import round_off, saturate, shift_right, two_steps
from tfra.hdl.lib.pipeline import READ, delayed, register, wrapping_counter
from tfra.hdl.lib.ram import Ram
from tfra.hdl.lib.streams import Fifo, always_ready_stream
from tfra.hdl.parallel.learned.payloads import force, share, taxel_quad
from tfra.hdl.parallel.learned.plan import FRAMES
from tfra.hdl.parallel.raster import Raster, read_taxels
from tfra.hdl.primitives import Multiplier
from tfra.model.fixed.learned.design import LearnedDesign
from tfra.model.fixed.learned.share import even_word

_FINE = 3
"""Bits of a shift by which its second step moves."""
_WORD = READ + 1
"""Cycles from an address to p of its taxel."""
_PRODUCT = _WORD + Multiplier.latency + 1
"""... to its product with the mantissa, in a register."""
_RESULT = _PRODUCT + 4
"""... to the result word: two steps of the shift, rounding, limit."""


class Forces(wiring.Component):
    """``p * mantissa / 2^shift`` of every taxel: three planes, each row-major.

    ::

        p -> memory -> place -> x mantissa -> >> shift -> round, saturate -> queue -> taxel

    The memory has a place for each frame in flight.  A word is read when the queue has a place for it, so nothing on
    its path waits.  One taxel a cycle.  Resources: a multiplier of p by a mantissa.
    """

    def __init__(self, design: LearnedDesign) -> None:
        self._design = design
        super().__init__({
            "p": In(always_ready_stream(taxel_quad(design))),  # Q quads of mirror taxels a frame
            # Three transfers a frame, after its quads, each taken with the last taxel of its plane.
            "share": In(stream.Signature(share(design))),
            "taxel": Out(stream.Signature(force(design))),  # 3 m words a frame: f_x, f_y, f_z
        })

    @property
    def latency(self) -> int:
        """Cycles from the one in which ``share`` is valid to the transfer of its plane's first word."""
        return _RESULT + Fifo.latency

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        read, raster, fifo = read_taxels(m, self._design, self.share.valid, _RESULT, self.taxel)
        ends = read & raster.last
        _, last_axis = wrapping_counter(m, ends, 3, "axis")
        place, _ = wrapping_counter(m, ends & last_axis, FRAMES, "read_place")
        word, limited = self._scale(m, self._read(m, raster, place))
        m.d.comb += [
            self.share.ready.eq(ends),
            fifo.i.p.last.eq(delayed(m, ends & last_axis, _RESULT, "last")),
            fifo.i.p.word.eq(word),
            fifo.i.p.limited.eq(limited),
        ]
        return m

    def _read(self, m: Module, raster: Raster, place: Value) -> Value:
        """p of the taxel that the raster is at, ``_WORD`` cycles later."""
        design, shape = self._design, self.p.payload.shape()
        quads = Ram(m, "quads", shape, FRAMES << len(raster.quad))
        number, last = wrapping_counter(m, self.p.valid, design.quads, "number")
        write_place, _ = wrapping_counter(m, self.p.valid & last, FRAMES, "write_place")
        quads.write(self.p.valid, Cat(number, write_place), self.p.payload)
        quad = data.View(shape, register(m, quads.read(Cat(raster.quad, place)).as_value(), "quad"))
        word = Array(quad[k] for k in range(4))[delayed(m, raster.mirror, READ, "mirror")]
        even = delayed(m, self.share.p.even, READ, "even")
        return register(m, Mux(even, even_word(design), word), "p")

    def _scale(self, m: Module, p: Value) -> tuple[Value, Value]:
        """The result word of a taxel, and whether it was limited."""
        design, scale = self._design, self.share.p
        m.submodules.multiplier = multiplier = Multiplier(len(p) + 1, len(scale.mantissa), design.target)
        shift = delayed(m, scale.shift, _PRODUCT, "shift")
        coarse, _ = two_steps(shift, _FINE)
        _, fine = two_steps(register(m, shift, "fine"), _FINE)
        product = register(m, multiplier.product, "product")  # TIMING: sum of a wide product's digits -> shift
        moved = register(m, shift_right(product, coarse), "moved")
        shifted = register(m, moved >> fine, "shifted")
        # TIMING: rounding -> limit
        wide = register(m, round_off(shifted, 1), "wide")
        m.d.comb += [
            multiplier.a.eq(Cat(p, Const(0, 1)).as_signed()),
            multiplier.b.eq(delayed(m, scale.mantissa, _WORD, "mantissa")),
        ]
        word = saturate(wide, design.widths.output)
        return register(m, word, "word"), register(m, wide != word, "limited")
