"""Places of taxels, row by row, and reads of taxels at the pace of their sink."""

from typing import Any

from amaranth import Cat, Elaboratable, Module, Mux, Signal, Value
from amaranth.lib import wiring

from tfra.hdl.lib.arithmetic import counter_shape
from tfra.hdl.lib.pipeline import delayed
from tfra.hdl.lib.streams import Fifo, Tokens
from tfra.model.fixed.design import Design


class Raster(Elaboratable):
    """Place of the next taxel of a row-major frame; frames follow each other.  All outputs are registers."""

    def __init__(self, design: Design) -> None:
        self._design, self._stride = design, design.quad_columns
        self._rows, self._columns = design.sensor.rows, design.sensor.columns
        self.transfer = Signal()  # in: step on
        self.row = Signal(counter_shape(self._rows - 1))
        self.column = Signal(counter_shape(self._columns - 1))
        self.row_start = Signal(init=1)  # it is the first of its row
        self.row_end = Signal()  # ... the last
        self.last = Signal()  # it is the last of its frame
        self.quad = Signal(counter_shape(design.quads - 1))  # number of the quad that it is in

    @property
    def mirror(self) -> Value:
        """Place of the taxel in its quad: bit 0 is set in the right half of the array, bit 1 in the lower one."""
        return Cat(self.column >= self._design.quad_columns, self.row >= self._design.quad_rows)

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        # With two columns or more, the taxel before the end of a row is in the same row.
        before_end = self.column == self._columns - 2
        with m.If(self.transfer):
            m.d.sync += [
                self.column.eq(Mux(self.row_end, 0, self.column + 1)),
                self.row_start.eq(self.row_end),
                self.row_end.eq(before_end),
                self.last.eq(before_end & (self.row == self._rows - 1)),
            ]
            with m.If(self.row_end):
                m.d.sync += self.row.eq(Mux(self.last, 0, self.row + 1))
            with m.If(~self.last):  # the last taxel and the first one share their quad
                m.d.sync += self.quad.eq(self.quad + self._step())
        return m

    def _step(self) -> Value:
        """From a taxel's quad to the next one's: to the middle of a row and back, to the middle row and back."""
        across = _towards_middle(self.column, self._columns, 1)
        down = _towards_middle(self.row, self._rows, self._stride)
        return Mux(self.row_end, down, across)


def _towards_middle(position: Value, length: int, stride: int) -> Value:
    """``stride`` before the middle of ``length``, its negative after; zero across the middle of an even length."""
    return Mux(position < (length + 1) // 2 - 1, stride, Mux(position >= length // 2, -stride, 0))


def read_taxels(m: Module, design: Design, available: Value, latency: int, sink: Any) -> tuple[Signal, Raster, Fifo]:
    """Whether a taxel is read in this cycle, the raster at its place, and the FIFO for its word, ``latency`` later.

    One is read while they are ``available`` and the FIFO, which leads to ``sink``, has a place for its word, so nothing
    waits on the way of a word.  Places are as many as the cycles until one is free again without stalls.
    """
    read = Signal()
    m.submodules.raster = raster = Raster(design)
    m.submodules.places = places = Tokens(latency + Fifo.latency + 1)
    m.submodules.fifo = fifo = Fifo(sink.payload.shape(), latency + Fifo.latency + 2)
    wiring.connect(m, fifo.o, wiring.flipped(sink))
    m.d.comb += [
        read.eq(places.o.valid & available),
        places.o.ready.eq(available),
        places.give.eq(sink.valid & sink.ready),
        raster.transfer.eq(read),
        fifo.i.valid.eq(delayed(m, read, latency, "read_valid", control=True)),
    ]
    return read, raster, fifo
