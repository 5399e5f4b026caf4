"""Unscaled forces: planes are unfolded, rounded and sent taxel by taxel."""

from __future__ import annotations

from typing import Any

from amaranth import Array, Cat, Module, Signal, Value, signed
from amaranth.lib import data, memory, stream, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.arithmetic import quad
from tfra.hdl.butterfly import Butterfly
from tfra.hdl.normaliser import Raster
from tfra.hdl.parts import in_parts, in_quad, part_number, pick_part
from tfra.hdl.payloads import vector_quad
from tfra.hdl.pipeline import fill, register, walk
from tfra.hdl.streams import TOKEN, Spare, Tokens, flow
from tfra.model.design import Design
from tfra.model.fixed.widths import force_drop, widths

PLANES = 8
"""Planes of the memory, a power of two."""


class Forces(wiring.Component):
    """Row-major force planes from folded ones; the end of :func:`tfra.model.fixed.forces.forces`.

    ::

        folded -> Butterfly -> round_shift(., force_drop) -> memory (8 planes x Q quads) -> place -> spare -> taxel

    The four mirror taxels of a quad lie at one address, so a single walk over the quads finds every taxel: forth
    and back over the quad columns of a row, forth and back over the quad rows of the plane.  The middle line of
    an odd count is read once, from its first place.  The memory holds more than a frame, so that the products of a
    frame need not wait for its words to be sent.  One quad per cycle in, one taxel per cycle out; no multiplier.

    Members:
        folded: 3 Q quads a frame, for which a token was taken: folded f_x, f_y, f_z.
        taxel: 3 m words a frame: f_x, f_y, f_z, each row-major.
        room: tokens out, one for each frame that the memory has room for.
    """

    def __init__(self, design: Design) -> None:
        self._design = design
        super().__init__(
            {
                "folded": In(flow(vector_quad(design))),
                "taxel": Out(stream.Signature(signed(widths(design).force))),
                "room": Out(stream.Signature(TOKEN)),
            }
        )
        self._unfold = Butterfly(widths(design).vector)

    @property
    def latency(self) -> int:
        """Cycles from the transfer of a plane's last quad to that of its first taxel, when the plane before has left.

        The registers of the butterfly, of rounding, of the memory's cells, of its read port, behind that, of the word,
        and a spare one, so that the walk does not look at what the sink decides in the same cycle; parts of a quad.
        """
        return self._unfold.latency + 5 + Spare.latency + self._design.parts - 1

    @property
    def read_latency(self) -> int:
        """Cycles from the last read of a plane to the transfer of its last taxel, when nothing stalls."""
        return 3 + Spare.latency

    @property
    def plane_cycles(self) -> int:
        """Cycles in which a plane is sent; planes follow each other without a gap when their quads come in time."""
        return self._design.sensor.taxels

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        words = data.ArrayLayout(self.taxel.payload.shape(), self._design.architecture.vector_words)
        depth = PLANES << part_number(self._design).width
        m.submodules.unfold = self._unfold
        m.submodules.frames = self._frames = Tokens(PLANES // 3, every=3)
        wiring.connect(m, self._frames.o, wiring.flipped(self.room))
        m.submodules.plane = plane = memory.Memory(shape=words, depth=depth, init=[])
        entered, left = Signal(), Signal()
        full = fill(m, PLANES, entered, left)
        m.d.comb += [
            self._unfold.i.valid.eq(self.folded.valid),
            self._unfold.i.payload.eq(self.folded.payload),
            self._unfold.o.ready.eq(1),
            entered.eq(self._write(m, plane.write_port())),
            left.eq(self._read(m, plane.read_port(), full)),
        ]
        return m

    def _write(self, m: Module, port: Any) -> Value:
        """Round the unfolded quads and store them; high with a plane's last."""
        design, drop, unfolded = self._design, force_drop(self._design), self._unfold.o
        rounded = Signal(quad(widths(design).force), reset_less=True)
        plane, ends = Signal(range(PLANES)), Signal()
        number, last = walk(m, port.en, design.quads * design.parts)
        ends_quad = in_quad(design, number) == design.parts - 1
        m.d.comb += [
            port.addr.eq(Cat(number, plane)),
            port.data.eq(pick_part(design, rounded, number)),
            port.en.eq(in_parts(m, register(m, unfolded.valid, control=True), ends_quad)),
            ends.eq(port.en & last),
        ]
        with m.If(unfolded.valid):
            for k in range(4):
                m.d.sync += rounded[k].eq((unfolded.payload[k] + (1 << drop >> 1)) >> drop)
        m.d.sync += plane.eq(plane + ends)
        return ends

    def _read(self, m: Module, port: Any, full: Value) -> Value:
        """Walk over a full plane: address, read port, its register, the word of the place; high with the last read.

        Each stage moves when the next one does or has nothing: what waits leaves no gap for the plane behind it.
        """
        plane, issue, ends = Signal(range(PLANES)), Signal(), Signal()
        m.submodules.raster = raster = Raster(self._design)
        m.submodules.spare = spare = Spare(self.taxel.payload.shape())
        wiring.connect(m, spare.o, wiring.flipped(self.taxel))
        place = Cat(raster.column >= self._design.quad_columns, raster.row >= self._design.quad_rows)
        size = self._design.architecture.vector_words
        inside = (size - 1).bit_length()  # bits of the place that a part has words for; the others are address
        number = Cat(place[inside:], raster.quad)[: part_number(self._design).width]
        fetched, held, sent = Signal(), Signal(), Signal()
        send = ~sent | spare.i.ready
        hold = ~held | send
        fetch = ~fetched | hold
        m.d.comb += [
            issue.eq(fetch & full[0]),
            ends.eq(issue & raster.last),
            raster.transfer.eq(issue),
            port.en.eq(fetch),
            port.addr.eq(Cat(number, plane)),
            spare.i.valid.eq(sent),
        ]
        with m.If(fetch):
            m.d.sync += fetched.eq(issue)
            fetched_place = register(m, place, "fetched_place")
        with m.If(hold):
            m.d.sync += held.eq(fetched)
            held_place, words = register(m, fetched_place, "held_place"), register(m, port.data.as_value(), "words")
        with m.If(send):
            m.d.sync += sent.eq(held)
            part = data.View(port.data.shape(), words)
            word = register(m, Array(part[k] for k in range(size))[held_place[:inside]] if inside else part[0], "word")
        m.d.comb += [spare.i.payload.eq(word), self._frames.give.eq(ends)]
        m.d.sync += plane.eq(plane + ends)
        return ends
