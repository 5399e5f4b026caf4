"""The sums of all frames in flight, on their way from the products to ``dependent``."""

from __future__ import annotations

from typing import Any

from amaranth import Cat, Const, Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from tfra.hdl.combine_store import FRAMES
from tfra.hdl.payloads import vector_quad
from tfra.hdl.pipeline import fill, walk
from tfra.hdl.streams import flow
from tfra.model.design import Design

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

    latency = 2
    """Cycles from the transfer of a quad whose turn it is to that at the other end."""

    def __init__(self, design: Design) -> None:
        shape = vector_quad(design)
        super().__init__(
            {"b": In(flow(shape)), "n": In(flow(shape)), "o": Out(stream.Signature(shape))}
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.rows = rows = Memory(shape=self.o.payload.shape(), depth=FRAMES * ROWS, init=[])
        write, read = rows.write_port(), rows.read_port()
        put_b, put_n, move, get = self.b.valid, self.n.valid, Signal(name="move"), Signal(name="get")
        b_frame, _ = walk(m, put_b, FRAMES, "b_frame")
        n_row, n_last = walk(m, put_n, ROWS - 1, "n_row")
        n_frame, _ = walk(m, put_n & n_last, FRAMES, "n_frame")
        place, _ = walk(m, get, FRAMES * ROWS, "place")
        is_b = place[:_ROW_BITS] == 0
        b, n = fill(m, FRAMES, put_b, get & is_b), fill(m, FRAMES * (ROWS - 1), put_n, get & ~is_b)
        m.d.comb += [
            write.en.eq(put_b | put_n),
            write.addr.eq(Mux(put_b, Cat(Const(0, _ROW_BITS), b_frame), Cat((n_row + 1)[:_ROW_BITS], n_frame))),
            write.data.eq(Mux(put_b, self.b.payload.as_value(), self.n.payload.as_value())),
            move.eq(~self.o.valid | self.o.ready),
            get.eq(move & Mux(is_b, b[0], n[0])),
            read.addr.eq(place),
            read.en.eq(get),
            self.o.payload.eq(read.data),
        ]
        with m.If(move):
            m.d.sync += self.o.valid.eq(get)
        return m
