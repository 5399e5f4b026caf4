"""Neighbours of the words of frames that come row by row, a word a cycle at most."""

from typing import Any

from amaranth import Module, Mux, Signal, Value
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.pipeline import register, wrapping_counter
from tfra.hdl.lib.ram import Ram
from tfra.hdl.lib.streams import always_ready_stream


def raster(m: Module, step: Value, rows: int, columns: int) -> tuple[Signal, Signal, Value]:
    """Row and column of the next word of frames that follow each other, and whether it is the last of its frame."""
    column, row_ends = wrapping_counter(m, step, columns, "column")
    row, last = wrapping_counter(m, step & row_ends, rows, "row")
    return row, column, row_ends & last


class Lines(wiring.Component):
    """In: words of frames.  Out: every word with those above and below it, zero beyond the array.

    Frames follow each other without a pause, and the last row leaves by itself: its columns are read while the first
    row of the next frame comes, whose words need nothing of the memory.  A word is written after the column of the
    frame before has been read, since reading does not wait.

    An array has two rows and two columns or more.
    """

    latency = 2
    """Cycles from a word to the column whose lowest one it is."""

    def __init__(self, shape: Any, rows: int, columns: int) -> None:
        self._shape, self._rows, self._columns = shape, rows, columns
        words = {"above": shape, "centre": shape, "below": shape}
        super().__init__({
            "i": In(always_ready_stream(shape)),
            # ``start``, ``end``: the first, the last of a row
            "o": Out(always_ready_stream(data.StructLayout(words | {"start": 1, "end": 1}))),
        })

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        row, column, last = raster(m, self.i.valid, self._rows, self._columns)
        flush = Signal()
        flush_column, flush_ends = wrapping_counter(m, flush, self._columns, "flush_column")
        with m.If(self.i.valid & last):
            m.d.sync += flush.eq(1)
        with m.Elif(flush_ends):
            m.d.sync += flush.eq(0)
        read = Mux(flush, flush_column, column)
        memory = Ram(m, "memory", data.StructLayout({"newer": self._shape, "older": self._shape}), self._columns)
        stored = memory.read(read)
        word = register(m, self.i.payload, "word")
        update = Signal(data.StructLayout({"newer": self._shape, "older": self._shape}))
        m.d.comb += [
            update.newer.eq(word),
            update.older.eq(stored.newer),
        ]
        memory.write(register(m, self.i.valid, "write", control=True), register(m, column, "target"), update)
        self._send(m, stored, word, flush, row, read)
        return m

    def _send(self, m: Module, stored: Any, word: Value, flush: Value, row: Value, read: Value) -> None:
        """A column leaves for every word but those of the first row, and for the last row at the end."""
        valid = register(m, flush | (self.i.valid & (row != 0)), "valid", control=True)
        first = register(m, ~flush & (row == 1), "first")
        flushed = register(m, flush, "flushed")
        start, end = register(m, read == 0, "start"), register(m, read == self._columns - 1, "end")
        column = Signal(self.o.payload.shape(), reset_less=True)
        m.d.sync += [
            self.o.valid.eq(valid),
            column.above.eq(Mux(first, 0, stored.older)),
            column.centre.eq(stored.newer),
            column.below.eq(Mux(flushed, 0, word)),
            column.start.eq(start),
            column.end.eq(end),
        ]
        m.d.comb += self.o.payload.eq(column)


ACROSS = 1
"""Cycles from a word to the three of a row whose right one it is, or that has none."""


def across(m: Module, valid: Value, start: Value, end: Value, word: Value) -> tuple[Value, Signal, Signal, Value]:
    """For every ``word``, whether it is there, the word on its left, the word, that on its right: zero beyond a row.

    The last of a row leaves a cycle later, when at most the first of the next row comes, for which none leaves.
    """
    left = Signal.like(word, name="left", reset_less=True)
    centre = Signal.like(word, name="centre", reset_less=True)
    ended = register(m, valid & end, "ended", control=True)
    with m.If(valid):
        m.d.sync += left.eq(Mux(start, 0, centre))
        m.d.sync += centre.eq(word)
    return ended | (valid & ~start), left, centre, Mux(ended, 0, word)
