"""The sums of all frames in flight, on their way from the products to ``dependent``."""

from __future__ import annotations

from typing import Any

from amaranth import Cat, Const, Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.pipeline import driver, occupancy, register, wrapping_counter
from tfra.hdl.lib.streams import always_ready_stream
from tfra.hdl.parallel.payloads import vector_quad
from tfra.hdl.parallel.tfra.combine.store import FRAMES
from tfra.model.fixed.design import Design

_ROW_BITS = 2
ROWS = 1 << _ROW_BITS
"""Quads of sums a frame: one with the contact product, the others with the residual's."""


class SumsQueue(wiring.Component):
    """Quads of two products, in the order of their frames: one of ``b``, then three of ``n``, over and over.

    Frames follow each other in a memory with a row for each quad, which is read from end to end: a row is free again
    when it has been read: it has been by the time that its frame's token is taken again.

    Members:
        b, n: streams in, which never wait; at most one of them is valid in a cycle, since results of products come one
            at a time.
        o: stream out, registered.

    Resources: one memory of 16 vector quads, which small memories of common devices just hold.
    """

    latency = 4
    """Cycles from the transfer of a quad whose turn it is to that at the other end, with registers before the memory
    and behind: the way is long and nobody waits for a sum."""

    interval = 4
    """Cycles between two transfers at the other end at the shortest."""

    def __init__(self, design: Design) -> None:
        shape = vector_quad(design)
        arriving = In(always_ready_stream(shape))
        super().__init__({"b": arriving, "n": arriving, "o": Out(stream.Signature(shape))})

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.rows = rows = Memory(shape=self.o.payload.shape(), depth=FRAMES * ROWS, init=[])
        write, read = rows.write_port(), rows.read_port()
        put_b, put_n, get, got = self.b.valid, self.n.valid, Signal(name="get"), Signal(name="got")
        b_frame, _ = wrapping_counter(m, put_b, FRAMES, "b_frame")
        n_row, n_last = wrapping_counter(m, put_n, ROWS - 1, "n_row")
        n_frame, _ = wrapping_counter(m, put_n & n_last, FRAMES, "n_frame")
        place, _ = wrapping_counter(m, get, FRAMES * ROWS, "place")
        is_b = place[:_ROW_BITS] == 0
        b, n = occupancy(m, FRAMES, put_b, get & is_b), occupancy(m, FRAMES * (ROWS - 1), put_n, get & ~is_b)
        at = Mux(put_b, Cat(Const(0, _ROW_BITS), b_frame), Cat((n_row + 1)[:_ROW_BITS], n_frame))
        out = driver(m, self.o.payload)
        m.d.comb += [
            write.en.eq(register(m, put_b | put_n, control=True)),
            write.addr.eq(register(m, at)),
            write.data.eq(register(m, Mux(put_b, self.b.payload.as_value(), self.n.payload.as_value()))),
            read.addr.eq(place),
            read.en.eq(1),
        ]
        m.d.sync += [
            get.eq(~(get | got | self.o.valid) & Mux(is_b, b[0], n[0])),
            got.eq(get),
            self.o.valid.eq(got | (self.o.valid & ~self.o.ready)),
        ]
        with m.If(got):
            m.d.sync += out.eq(read.data)
        return m
