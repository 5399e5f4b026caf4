"""Unscaled forces: planes are unfolded, rounded and sent taxel by taxel."""

from __future__ import annotations

from typing import Any

from amaranth import Cat, Module, Mux, Signal, Value, signed
from amaranth.lib import data, memory, stream, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.arithmetic import count, quad
from tfra.hdl.butterfly import Butterfly
from tfra.hdl.normaliser import Raster
from tfra.hdl.payloads import vector_quad
from tfra.hdl.pipeline import register
from tfra.hdl.streams import TOKEN, Spare, Tokens
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
        folded: 3 Q quads a frame: folded f_x, f_y, f_z.
        taxel: 3 m words a frame: f_x, f_y, f_z, each row-major.
        room: tokens out, one for each frame that the memory has room for.
    """

    def __init__(self, design: Design) -> None:
        self._design = design
        super().__init__(
            {
                "folded": In(stream.Signature(vector_quad(design))),
                "taxel": Out(stream.Signature(signed(widths(design).force))),
                "room": Out(stream.Signature(TOKEN)),
            }
        )
        self._unfold = Butterfly(widths(design).vector)

    @property
    def latency(self) -> int:
        """Cycles from the transfer of a plane's last quad to that of its first taxel, when the plane before has left.

        The registers of the butterfly, of rounding, of the memory's cells, of its read port, behind that, of the word,
        and a spare one, so that the walk does not look at what the sink decides in the same cycle.
        """
        return self._unfold.latency + 5 + Spare.latency

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
        top = self._design.quads - 1
        words = quad(widths(self._design).force)
        m.submodules.unfold = self._unfold
        m.submodules.frames = self._frames = Tokens(PLANES // 3, every=3)
        wiring.connect(m, self._frames.o, wiring.flipped(self.room))
        m.submodules.plane = plane = memory.Memory(shape=words, depth=PLANES << len(Signal(count(top))), init=[])
        full = Signal(range(PLANES + 1))
        wiring.connect(m, wiring.flipped(self.folded), self._unfold.i)
        entered = self._write(m, plane.write_port(), full)
        left = self._read(m, plane.read_port(), full)
        m.d.sync += full.eq(full + entered - left)
        return m

    def _write(self, m: Module, port: Any, full: Value) -> Value:
        """Round the unfolded quads and store them while a plane of the memory is free; high with a plane's last."""
        drop, top = force_drop(self._design), self._design.quads - 1
        rounded, valid = Signal(port.data.shape(), reset_less=True), Signal()
        number, plane, unfolded = Signal(count(top)), Signal(range(PLANES)), self._unfold.o
        blocked, ends = Signal(), Signal()  # blocked: no plane was free a cycle ago
        m.d.comb += [
            unfolded.ready.eq(~valid | ~blocked),
            port.addr.eq(Cat(number, plane)),
            port.data.eq(rounded),
            port.en.eq(valid & ~blocked),
            ends.eq(port.en & (number == top)),
        ]
        m.d.sync += blocked.eq(Mux(ends, full == PLANES - 1, full == PLANES))
        with m.If(unfolded.ready):
            m.d.sync += valid.eq(unfolded.valid)
            for k in range(4):
                m.d.sync += rounded[k].eq((unfolded.payload[k] + (1 << drop >> 1)) >> drop)
        with m.If(port.en):
            m.d.sync += number.eq(number + 1)
            with m.If(ends):
                m.d.sync += [number.eq(0), plane.eq(plane + 1)]
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
        fetched, held, sent = Signal(), Signal(), Signal()
        send = ~sent | spare.i.ready
        hold = ~held | send
        fetch = ~fetched | hold
        m.d.comb += [
            issue.eq(fetch & (full != 0)),
            ends.eq(issue & raster.last),
            raster.transfer.eq(issue),
            port.en.eq(fetch),
            port.addr.eq(Cat(raster.quad, plane)),
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
            quad = data.View(port.data.shape(), words)
            rows = [Mux(held_place[0], quad[k + 1], quad[k]) for k in (0, 2)]
            word = register(m, Mux(held_place[1], rows[1], rows[0]), "word")
        m.d.comb += [spare.i.payload.eq(word), self._frames.give.eq(ends)]
        m.d.sync += plane.eq(plane + ends)
        return ends
