"""Where a contact is, and where its window; see :mod:`tfra.model.skin.windows`."""

from typing import Any

from amaranth import Module, Mux, Signal, Value
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.divider import Divider
from tfra.hdl.lib.pipeline import driver, register
from tfra.hdl.skin.payloads import column, contact, region, row
from tfra.model.skin.finding import MARK_SHIFT, Mark
from tfra.model.skin.skin import Skin
from tfra.model.skin.windows import PLACE_FRACTION

_MARK = 3
"""Cycles from the second quotient to the next region: the corner, the marks, and the contact."""
_HALF = 1 << (PLACE_FRACTION - 1)


class Places(wiring.Component):
    """In: regions.  Out: their centroids, the corners of the windows about them, and their marks.

    One quotient after the other, the row's first.  Those of a region without taxels are zero.
    """

    def __init__(self, skin: Skin) -> None:
        given = region(skin).members
        totals = [given[name].members["total"].width for name in ("rows", "columns")]
        whole = max(row(skin).width, column(skin).width)
        self._divider = Divider(max(totals), given["taxels"].width, PLACE_FRACTION, whole=whole)
        self._axes = list(zip(skin.shape, (skin.sensor.rows, skin.sensor.columns), strict=True))
        super().__init__({
            "region": In(stream.Signature(region(skin))),
            "contact": Out(stream.Signature(contact(skin))),
        })

    @property
    def interval(self) -> int:
        """Cycles from one contact to the next."""
        cycles: int = 2 * self._divider.interval + _MARK
        return cycles

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        given = self.region.payload
        totals = given.rows.total, given.columns.total
        m.submodules.divider = divider = self._divider
        contact = driver(m, self.contact.payload)
        quotient = Mux(given.taxels == 0, 0, divider.o.payload)
        sent = Signal()  # the operands of a quotient
        is_column = Signal()
        m.d.comb += [
            divider.i.payload.numerator.eq(Mux(is_column, totals[1], totals[0])),
            divider.i.payload.denominator.eq(given.taxels),
            divider.o.ready.eq(1),
        ]
        with m.FSM():
            with m.State("DIVIDE"):
                m.d.comb += divider.i.valid.eq(self.region.valid & ~sent)
                with m.If(self.region.valid & divider.i.ready):
                    m.d.sync += sent.eq(1)
                with m.If(divider.o.valid):
                    m.d.sync += sent.eq(0)
                    m.d.sync += is_column.eq(~is_column)
                    with m.If(is_column):
                        m.d.sync += contact.column.eq(quotient)
                        m.next = "MARK"
                    with m.Else():
                        m.d.sync += contact.row.eq(quotient)
            with m.State("MARK"):
                m.next = "TAKE"
            with m.State("TAKE"):
                m.d.comb += self.region.ready.eq(1)
                m.next = "SEND"
            with m.State("SEND"):
                m.d.comb += self.contact.valid.eq(1)
                with m.If(self.contact.ready):
                    m.next = "DIVIDE"
        self._mark(m, given, contact)
        return m

    def _mark(self, m: Module, given: Any, contact: Any) -> None:
        """The corner follows the place, and the marks the corner, a cycle later each; they are sent when they are."""
        corners, edges, larges = [], [], []
        places, spans = (contact.row, contact.column), (given.rows, given.columns)
        for place, span, (size, whole) in zip(places, spans, self._axes, strict=True):
            corner = register(m, (place + _HALF * (2 - size)) >> PLACE_FRACTION, "corner")
            edges.append((corner < 0) | (corner + size > whole))
            larges.append((span.first < corner) | (span.last >= corner + size))
            corners.append(corner)
        there = given.taxels != 0
        marks: dict[Mark, Value] = {
            Mark.EDGE: edges[0] | edges[1],
            Mark.LARGE: larges[0] | larges[1],
            Mark.TOUCHING: given.touching,
        }
        with m.If(self.region.ready):
            m.d.sync += contact.taxels.eq(given.taxels)
            m.d.sync += contact.top.eq(corners[0])
            m.d.sync += contact.left.eq(corners[1])
            for mark, given_mark in marks.items():
                m.d.sync += contact.marks[(mark >> MARK_SHIFT).bit_length() - 1].eq(there & given_mark)
