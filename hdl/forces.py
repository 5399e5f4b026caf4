"""Unscaled forces: planes are unfolded, rounded and sent taxel by taxel."""

from __future__ import annotations

from typing import Any

from amaranth import Cat, Module, Mux, Signal, signed
from amaranth.lib import memory, stream, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.arithmetic import count, quad
from tfra.hdl.butterfly import Butterfly
from tfra.hdl.payloads import vector_quad
from tfra.hdl.streams import TOKEN, Tokens
from tfra.model.design import Design
from tfra.model.fixed.widths import force_drop, widths

PLANES = 8
"""Planes of the memory, a power of two."""


class Forces(wiring.Component):
    """Row-major force planes from folded ones; the end of :func:`tfra.model.fixed.forces.forces`.

    ::

        folded -> Butterfly -> round_shift(., force_drop) -> plane memory (8 planes x Q quads) -> place -> taxel

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

        The registers of the butterfly, of rounding, of the memory's cells, of its read port, behind that, and of
        the word sent.
        """
        return self._unfold.latency + 5

    @property
    def read_latency(self) -> int:
        """Cycles from the last read of a plane to the transfer of its last taxel, when nothing stalls."""
        return 3

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
        full = Signal(PLANES)
        wiring.connect(m, wiring.flipped(self.folded), self._unfold.i)
        self._write(m, plane.write_port(), full)
        self._read(m, plane.read_port(), full)
        return m

    def _write(self, m: Module, port: Any, full: Signal) -> None:
        """Round the unfolded quads and store them while their plane of the memory is free."""
        drop, top = force_drop(self._design), self._design.quads - 1
        rounded, valid = Signal(port.data.shape(), reset_less=True), Signal()
        number, plane, unfolded = Signal(count(top)), Signal(range(PLANES)), self._unfold.o
        blocked, ends = Signal(), Signal()  # blocked: the plane was full a cycle ago
        m.d.comb += [
            unfolded.ready.eq(~valid | ~blocked),
            port.addr.eq(Cat(number, plane)),
            port.data.eq(rounded),
            port.en.eq(valid & ~blocked),
            ends.eq(port.en & (number == top)),
        ]
        m.d.sync += blocked.eq(full.bit_select((plane + ends)[: len(plane)], 1))
        with m.If(unfolded.ready):
            m.d.sync += valid.eq(unfolded.valid)
            for k in range(4):
                m.d.sync += rounded[k].eq((unfolded.payload[k] + (1 << drop >> 1)) >> drop)
        with m.If(port.en):
            m.d.sync += number.eq(number + 1)
            with m.If(ends):
                m.d.sync += [number.eq(0), plane.eq(plane + 1), full.bit_select(plane, 1).eq(1)]

    def _read(self, m: Module, port: Any, full: Signal) -> None:
        """Walk over a full plane: address, then read port, then its register, then the word of the place."""
        plane, move, issue = Signal(range(PLANES)), Signal(), Signal()
        place, end = self._walk(m, port, plane, issue)
        fetched, held, sent = Signal(), Signal(), Signal()
        fetched_place, held_place = Signal(2, reset_less=True), Signal(2, reset_less=True)
        words = Signal(port.data.shape(), reset_less=True)
        word = Signal(self.taxel.payload.shape(), reset_less=True)
        m.d.comb += [
            move.eq(~sent | self.taxel.ready),
            issue.eq(move & full.bit_select(plane, 1)),
            port.en.eq(move),
            self.taxel.valid.eq(sent),
            self.taxel.payload.eq(word),
        ]
        with m.If(move):
            m.d.sync += [fetched.eq(issue), held.eq(fetched), sent.eq(held)]
            m.d.sync += [fetched_place.eq(place), held_place.eq(fetched_place), words.eq(port.data)]
            rows = [Mux(held_place[0], words[k + 1], words[k]) for k in (0, 2)]
            m.d.sync += word.eq(Mux(held_place[1], rows[1], rows[0]))
        m.d.comb += self._frames.give.eq(issue & end)
        with m.If(issue & end):
            m.d.sync += [plane.eq(plane + 1), full.bit_select(plane, 1).eq(0)]

    def _walk(self, m: Module, port: Any, plane: Signal, step: Signal) -> tuple[Signal, Signal]:
        """Address and mirror place of the next taxel; ``end`` marks the last one, at quad 0 again."""
        design = self._design
        rows, columns, width = design.sensor.rows, design.sensor.columns, design.quad_columns
        row, column = Signal(count(rows - 1)), Signal(count(columns - 1))
        number, place = Signal(count(design.quads - 1)), Signal(2)
        row_end, end = Signal(), Signal()
        m.d.comb += [
            port.addr.eq(Cat(number, plane)),
            row_end.eq(column == columns - 1),
            end.eq(row_end & (row == rows - 1)),
        ]
        turn_x, turn_y = column == width - 1, row == design.quad_rows - 1
        with m.If(step & row_end):
            m.d.sync += [column.eq(0), place[0].eq(0), row.eq(row + 1)]
            _move(m, number, width, place[1], turn_y, rows)
            with m.If(end):
                m.d.sync += [row.eq(0), place[1].eq(0), number.eq(0)]
        with m.Elif(step):
            m.d.sync += column.eq(column + 1)
            _move(m, number, 1, place[0], turn_x, columns)
        return place, end


def _move(m: Module, number: Signal, stride: int, mirrored: Any, turn: Any, length: int) -> None:
    """One step along a line of ``length`` taxels: forth, then back; an even line visits its last quad twice."""
    with m.If(mirrored):
        m.d.sync += number.eq(number - stride)
    with m.Elif(turn):
        m.d.sync += [mirrored.eq(1), number.eq(number - stride * (length % 2))]
    with m.Else():
        m.d.sync += number.eq(number + stride)
