"""Peaks of smoothed frames; see :mod:`tfra.model.skin.peaks`."""

from typing import Any

from amaranth import Cat, Module, Mux, Signal, Value
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.pipeline import driver, register
from tfra.hdl.lib.streams import always_ready_stream, broadcast
from tfra.hdl.skin.lines import ACROSS, Lines, across, raster
from tfra.hdl.skin.payloads import height, peak
from tfra.model.skin.skin import Skin
from tfra.model.skin.smoothing import GAIN


class Peaks(wiring.Component):
    """In: heights of frames, row by row.  Out: the peaks that are not below the floor, and each frame's highest."""

    def __init__(self, skin: Skin) -> None:
        self._height, self._floor = height(skin), skin.adc.threshold * GAIN
        self._rows, self._columns = skin.sensor.rows, skin.sensor.columns
        super().__init__({
            "i": In(always_ready_stream(self._height)),
            "o": Out(always_ready_stream(peak(skin))),  # row by row
            "ends": Out(1),  # pulse: a frame has no further peak ...
            "highest": Out(self._height),  # ... and this is its largest height
        })

    @property
    def latency(self) -> int:
        """Cycles from the last height of a frame to the pulse of its end, which comes with its last peak or later."""
        return self._columns + Lines.latency + ACROSS + 2

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.lines = lines = Lines(self._height, self._rows, self._columns)
        broadcast(m, self.i, lines.i)
        column, bits = lines.o.payload, self._height.width
        words = Cat(column.above, column.centre, column.below)
        valid, *three = across(m, lines.o.valid, column.start, column.end, words)
        left, centre, right = ([word[k * bits : (k + 1) * bits] for k in range(3)] for word in three)
        middle = centre[1]
        earlier = [left[0], centre[0], right[0], left[1]]
        later = [right[1], left[2], centre[2], right[2]]
        exceeds = [middle > word for word in earlier] + [middle >= word for word in later]
        is_peak = register(m, Cat(exceeds, middle.any(), middle >= self._floor), "above").all()
        self._send(m, register(m, valid, "there", control=True), is_peak, register(m, middle, "height"))
        return m

    def _send(self, m: Module, there: Value, is_peak: Value, height: Value) -> None:
        """Number the heights, and keep the largest of a frame."""
        row, column, last = raster(m, there, self._rows, self._columns)
        output, highest = driver(m, self.o.payload), driver(m, self.highest)
        fresh = Signal(init=1)  # the next height is the first of a frame
        m.d.sync += [
            self.o.valid.eq(there & is_peak),
            self.ends.eq(there & last),
            output.height.eq(height),
            output.place.row.eq(row),
            output.place.column.eq(column),
        ]
        with m.If(there):
            m.d.sync += fresh.eq(last)
            m.d.sync += highest.eq(Mux(fresh | (height > highest), height, highest))
