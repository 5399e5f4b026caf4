"""The compression of a frame, smoothed; see :mod:`tfra.model.skin.smoothing`."""

from typing import Any

from amaranth import Module, Mux, Signal, signed
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.pipeline import driver, register
from tfra.hdl.lib.streams import always_ready_stream, broadcast
from tfra.hdl.skin.lines import ACROSS, Lines, across
from tfra.hdl.skin.payloads import height
from tfra.model.skin.skin import Skin


class Smoothing(wiring.Component):
    """In: codes of frames, row by row.  Out: the weighted compression about every taxel, none negative.

    Sums of three along a column, then of three along a row, weighted by 1 2 1::

        codes ─▶ lines ─▶ sum ─▶ across ─▶ sum ─▶ negative, or zero ─▶ heights
    """

    def __init__(self, skin: Skin) -> None:
        self._code = signed(skin.window.widths.stress)
        self._rows, self._columns = skin.sensor.rows, skin.sensor.columns
        super().__init__({
            "i": In(always_ready_stream(self._code)),
            "o": Out(always_ready_stream(height(skin))),
        })

    @property
    def latency(self) -> int:
        """Cycles from the last taxel of a frame to its last height."""
        return self._columns + Lines.latency + ACROSS + 3

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.lines = lines = Lines(self._code, self._rows, self._columns)
        broadcast(m, self.i, lines.i)
        column = lines.o.payload
        down = register(m, column.above + (column.centre << 1) + column.below, "down")
        flags = (register(m, lines.o.valid, "valid", control=True), register(m, column.start), register(m, column.end))
        valid, left, centre, right = across(m, *flags, down)
        total = register(m, left + (centre << 1) + right, "total")
        output = driver(m, self.o.payload)
        negated = Signal(signed(len(total) + 1))
        m.d.comb += negated.eq(-total)
        m.d.sync += [
            output.eq(Mux(total[-1], negated, 0)),
            self.o.valid.eq(register(m, valid, "valid", control=True)),
        ]
        return m
