"""The sums of all frames in flight, on their way from the products to ``dependent``."""

from typing import Any

from amaranth import Cat, Const, Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.pipeline import driver, occupancy, register, wrapping_counter
from tfra.hdl.lib.ram import Ram
from tfra.hdl.lib.streams import always_ready_stream
from tfra.hdl.parallel.payloads import vector_quad
from tfra.hdl.parallel.tfra.combine.store import FRAMES
from tfra.model.fixed.design import Design

_ROW_BITS = 2
ROWS = 1 << _ROW_BITS
"""Quads of sums a frame: one with the contact product, the others with the residual's."""


class SumsQueue(wiring.Component):
    """Merges the quads of two products in the order of their frames: one of ``b``, then three of ``n``, repeatedly.

    Frames follow each other in a memory with a row for each quad, which is read from end to end.  No full flag: at most
    ``FRAMES`` frames hold a token, so a row is read before it is written again.

    Resources: one memory of 16 vector quads, which small memories of common devices just hold.
    """

    latency = 4
    """Cycles from the transfer of a quad in, when it is its turn, to its transfer out."""

    interval = 4
    """Least number of cycles between two transfers out."""

    def __init__(self, design: Design) -> None:
        shape = vector_quad(design)
        super().__init__({
            "b": In(always_ready_stream(shape)),  # a quad a frame
            "n": In(always_ready_stream(shape)),  # ``ROWS - 1`` quads a frame, never in the same cycle as one of ``b``
            "o": Out(stream.Signature(shape)),  # ``ROWS`` quads a frame, registered
        })

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        rows = Ram(m, "rows", self.o.payload.shape(), FRAMES * ROWS)
        b_frame, _ = wrapping_counter(m, self.b.valid, FRAMES, "b_frame")
        n_row, n_last = wrapping_counter(m, self.n.valid, ROWS - 1, "n_row")
        n_frame, _ = wrapping_counter(m, self.n.valid & n_last, FRAMES, "n_frame")
        b_address = Cat(Const(0, _ROW_BITS), b_frame)
        n_address = Cat((n_row + 1)[:_ROW_BITS], n_frame)
        arrived = Mux(self.b.valid, self.b.payload.as_value(), self.n.payload.as_value())
        # TIMING: matvec's result router -> memory
        enable = register(m, self.b.valid | self.n.valid, "write_enable", control=True)
        address = register(m, Mux(self.b.valid, b_address, n_address), "write_address")
        rows.write(enable, address, register(m, arrived, "write_data"))
        self._read(m, rows)
        return m

    def _read(self, m: Module, rows: Ram) -> None:
        """Row by row: ``get`` in the cycle of the address, ``got`` in that of the memory's word."""
        get = Signal(name="get")
        got = Signal(name="got")
        row, _ = wrapping_counter(m, get, FRAMES * ROWS, "row")
        is_b = row[:_ROW_BITS] == 0
        b_waiting = occupancy(m, FRAMES, self.b.valid, get & is_b)
        n_waiting = occupancy(m, FRAMES * (ROWS - 1), self.n.valid, get & ~is_b)
        word = rows.read(row)
        out = driver(m, self.o.payload)
        m.d.sync += [
            get.eq(~(get | got | self.o.valid) & Mux(is_b, b_waiting[0], n_waiting[0])),
            got.eq(get),
            self.o.valid.eq(got | (self.o.valid & ~self.o.ready)),
        ]
        with m.If(got):
            m.d.sync += out.eq(word)
