"""Unscaled forces: planes are unfolded, rounded and sent taxel by taxel."""

from typing import Any

from amaranth import Array, Cat, Module, Signal, Value, signed
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.arithmetic import quad, round_off
from tfra.hdl.lib.butterfly import Butterfly
from tfra.hdl.lib.pipeline import READ, delayed, occupancy, register, wrapping_counter
from tfra.hdl.lib.ram import Ram
from tfra.hdl.lib.streams import TOKEN, Fifo, Tokens, always_ready_stream
from tfra.hdl.parallel.beats import beat_in_quad, beat_number, beat_valid, select_beat
from tfra.hdl.parallel.payloads import vector_quad
from tfra.hdl.parallel.raster import Raster, read_taxels
from tfra.model.fixed.design import Design
from tfra.model.fixed.widths import force_drop

PLANES = 8
"""Planes of the memory, a power of two."""


class Forces(wiring.Component):
    """Row-major force planes from folded ones; the end of :func:`tfra.model.fixed.tfra.forces.forces`.

    ::

        folded -> Butterfly -> round_shift(., force_drop) -> memory (8 planes x Q quads) -> place -> queue -> taxel

    The four mirror taxels of a quad are at one address, so one pass over the quads reads every taxel: forth and back
    over the quad columns of a row, forth and back over the quad rows of the plane.  The middle line of an odd count is
    read once, from its first place.  The memory holds more than a frame, so that the products of a frame need not wait
    for its words to be sent.  A word is read when the queue has a place for it, so nothing on its path waits.  One
    quad per cycle in, one taxel per cycle out, planes without a gap; no multiplier.
    """

    def __init__(self, design: Design) -> None:
        self._design = design
        super().__init__({
            # 3 Q quads a frame, for which a token was taken: folded f_x, f_y, f_z.
            "folded": In(always_ready_stream(vector_quad(design))),
            # 3 m words a frame: f_x, f_y, f_z, each row-major.
            "taxel": Out(stream.Signature(signed(design.widths.force))),
            "plane_token": Out(stream.Signature(TOKEN)),  # one for three planes of the memory that are free
        })
        self._unfold = Butterfly(design.widths.vector)

    @property
    def latency(self) -> int:
        """Cycles from the transfer of a plane's last quad to that of its first taxel, when the plane before has left.

        The registers of the butterfly, of rounding, of the memory's cells, of its read port, behind that, of the word,
        and the queue; beats of a quad.
        """
        return self._unfold.latency + 2 + self.read_latency + self._design.cycles_per_quad - 1

    @property
    def read_latency(self) -> int:
        """Cycles from the last read of a plane to the transfer of its last taxel, when nothing stalls."""
        return READ + 1 + Fifo.latency

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        words = data.ArrayLayout(self.taxel.payload.shape(), self._design.architecture.vector_words)
        depth = PLANES << beat_number(self._design).width
        m.submodules.unfold = self._unfold
        m.submodules.plane_tokens = plane_tokens = Tokens(PLANES // 3, every=3)
        wiring.connect(m, plane_tokens.o, wiring.flipped(self.plane_token))
        planes = Ram(m, "planes", words, depth)
        entered = Signal()
        left = Signal()
        full = occupancy(m, PLANES, entered, left)
        m.d.comb += [
            self._unfold.i.valid.eq(self.folded.valid),
            self._unfold.i.payload.eq(self.folded.payload),
            self._unfold.o.ready.eq(1),
            entered.eq(self._write(m, planes)),
            left.eq(self._read(m, planes, full[0])),
            plane_tokens.give.eq(register(m, left, "plane_left", control=True)),
        ]
        return m

    def _write(self, m: Module, planes: Ram) -> Value:
        """Round the unfolded quads and store them; high with a plane's last."""
        design, drop, unfolded = self._design, force_drop(self._design), self._unfold.o
        rounded = Signal(quad(design.widths.force), reset_less=True)
        plane = Signal(range(PLANES), name="write_plane")
        ends = Signal()
        enable = Signal(name="write_enable")
        number, last = wrapping_counter(m, enable, design.quads * design.cycles_per_quad, "write_number")
        ends_quad = beat_in_quad(design, number) == design.cycles_per_quad - 1
        m.d.comb += [
            enable.eq(beat_valid(m, register(m, unfolded.valid, "rounded_valid", control=True), ends_quad)),
            ends.eq(enable & last),
        ]
        planes.write(enable, Cat(number, plane), select_beat(design, rounded, number))
        with m.If(unfolded.valid):
            for k in range(4):
                m.d.sync += rounded[k].eq(round_off(unfolded.payload[k], drop))
        m.d.sync += plane.eq(plane + ends)
        return ends

    def _read(self, m: Module, planes: Ram, full: Value) -> Value:
        """Read the taxels of a ``full`` plane; high with the last read."""
        plane = Signal(range(PLANES), name="read_plane")
        ends = Signal()
        read, raster, fifo = read_taxels(m, self._design, full, READ + 1, self.taxel)
        number, word = self._locate(raster)
        m.d.comb += [
            ends.eq(read & raster.last),
            fifo.i.payload.eq(register(m, self._select_word(m, planes.read(Cat(number, plane)), word), "word")),
        ]
        m.d.sync += plane.eq(plane + ends)
        return ends

    def _locate(self, raster: Raster) -> tuple[Value, Value]:
        """Address of the raster's taxel in its plane: the number of a beat, and the word in that beat."""
        mirror = raster.mirror
        word_bits = (self._design.architecture.vector_words - 1).bit_length()
        number = Cat(mirror[word_bits:], raster.quad)[: beat_number(self._design).width]
        return number, mirror[:word_bits]

    def _select_word(self, m: Module, beat: Any, word: Value) -> Value:
        """The word of the beat that was read for it, ``READ`` cycles ago."""
        beat = data.View(beat.shape(), register(m, beat.as_value(), "beat"))
        if not len(word):
            return beat[0]
        return Array(beat[k] for k in range(len(beat)))[delayed(m, word, READ, "word_in_beat")]
