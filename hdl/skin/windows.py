"""The windows of contacts, read for the core; see :mod:`tfra.model.skin.windows`."""

from typing import Any

from amaranth import Module, Mux, Signal, Value
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.interface import ports
from tfra.hdl.lib.pipeline import register, wrapping_counter
from tfra.hdl.lib.streams import SkidBuffer
from tfra.hdl.skin.payloads import PAGES, contact, ending, place
from tfra.model.skin.skin import Skin


class Windows(wiring.Component):
    """In: contacts, and codes at places.  Out: the codes of their windows, zero beyond the array; a code a cycle.

    ====  =======================================================================
    IDLE  waits for a contact
    READ  reads a code a cycle
    END   waits until it is known whether the contact is the last of its frame
    ====  =======================================================================

    The window of a contact without taxels is zero.
    """

    latency = 4
    """Cycles from a contact to the first code."""

    def __init__(self, skin: Skin) -> None:
        self._shape, self._array = skin.shape, (skin.sensor.rows, skin.sensor.columns)
        self._code = ports.taxel(skin.window)
        super().__init__({
            "contact": In(stream.Signature(contact(skin))),
            "ending": In(stream.Signature(ending(skin))),
            "page": Out(range(PAGES)),
            "place": Out(place(skin)),
            "read": Out(1),
            "code": In(self._code),  # a cycle after ``read``
            "taxel": Out(stream.Signature(self._code)),  # registered
            "done": Out(1),  # pulse: the codes of the frame are not needed any more
        })

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.skid = skid = SkidBuffer(self._code)
        wiring.connect(m, skid.o, wiring.flipped(self.taxel))
        advance = skid.i.ready
        given, reading, load = self.contact.payload, Signal(), Signal()
        page = Signal(range(PAGES))
        row, column, last = self._walk(m, reading & advance, load)
        inside = (given.taxels != 0) & self._inside(row, 0) & self._inside(column, 1)
        with m.If(self.done):
            m.d.sync += page.eq(~page)
        with m.If(advance):
            fetched = register(m, reading, "fetched", control=True)
            m.d.sync += skid.i.valid.eq(fetched)
            word = register(m, Mux(register(m, inside, "inside"), self.code, 0), "word")
        m.d.comb += [
            self.page.eq(page),
            self.place.row.eq(row),
            self.place.column.eq(column),
            self.read.eq(advance),
            skid.i.payload.eq(word),
        ]
        with m.FSM():
            with m.State("IDLE"):
                m.d.comb += load.eq(1)
                with m.If(self.contact.valid):
                    m.next = "READ"
            with m.State("READ"):
                m.d.comb += reading.eq(1)
                with m.If(last & advance):
                    m.next = "END"
            with m.State("END"), m.If(self.ending.valid):
                m.d.comb += [
                    self.contact.ready.eq(1),
                    self.ending.ready.eq(1),
                    self.done.eq(self.ending.payload.last),
                ]
                m.next = "IDLE"
        return m

    def _walk(self, m: Module, step: Value, load: Value) -> tuple[Signal, Signal, Value]:
        """Row and column of the code that is read, and whether it is the window's last."""
        height, width = self._shape
        given = self.contact.payload
        row = Signal(given.top.shape(), reset_less=True)
        column = Signal(given.left.shape(), reset_less=True)
        _, row_ends = wrapping_counter(m, step, width, "across")
        _, last = wrapping_counter(m, step & row_ends, height, "down")
        with m.If(load):
            m.d.sync += row.eq(given.top)
            m.d.sync += column.eq(given.left)
        with m.Elif(step):
            m.d.sync += row.eq(row + row_ends)
            m.d.sync += column.eq(Mux(row_ends, given.left, column + 1))
        return row, column, row_ends & last

    def _inside(self, index: Value, axis: int) -> Value:
        """Whether a row or a column is one of the array."""
        return (index >= 0) & (index < self._array[axis])
