"""A memory of frames: one is written while another is read."""

from typing import Any

from amaranth import Cat, Module, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.ram import Ram
from tfra.hdl.lib.streams import always_ready_stream
from tfra.hdl.skin.lines import raster
from tfra.hdl.skin.payloads import PAGES, column, place
from tfra.model.skin.skin import Skin


class Pages(wiring.Component):
    """In: words of frames, row by row, and places.  Out: the words at these.

    Frames are stored in one page after the other, the first in page 0.
    """

    def __init__(self, skin: Skin, shape: Any) -> None:
        self._shape, self._rows, self._columns = shape, skin.sensor.rows, skin.sensor.columns
        self._stride = 1 << column(skin).width  # a place is an address without a product
        super().__init__({
            "i": In(always_ready_stream(shape)),
            "page": In(range(PAGES)),
            "place": In(place(skin)),
            "read": In(1, init=1),
            "o": Out(shape),  # the word that was there when ``read`` was last high
        })

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        row, column, last = raster(m, self.i.valid, self._rows, self._columns)
        page = Signal(range(PAGES))
        with m.If(self.i.valid & last):
            m.d.sync += page.eq(~page)
        address = Cat(column, row, page)
        whole = 1 << len(Cat(column, row))  # of the pages before the last one
        memory = Ram(m, "memory", self._shape, (PAGES - 1) * whole + self._rows * self._stride)
        memory.write(self.i.valid, address, self.i.payload)
        m.d.comb += self.o.eq(memory.read(Cat(self.place.column, self.place.row, self.page), self.read))
        return m
