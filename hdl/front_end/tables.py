"""Offsets and gains of all taxels, and the way of software to them and to the table of repairs."""

from typing import Any

from amaranth import Cat, Module, Mux, Signal, signed
from amaranth.lib import data, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from tfra.hdl.bus.map import BITS
from tfra.hdl.front_end.ports import TABLES
from tfra.hdl.lib.arithmetic import counter_shape
from tfra.hdl.lib.pipeline import READ, register
from tfra.model.fixed.front_end import DEVIATION, GAIN, UNITY, repair_places

OFFSETS, GAINS, REPAIRS = range(3)
"""Kinds of tables, as in CALIBRATION_PLACE."""

_ENTRY = data.ArrayLayout(DEVIATION, 2)
"""Offset and gain of a taxel: halves of a word of memory, which software writes one by one."""


class Tables(wiring.Component):
    """Two pages of offsets and gains: a tare writes the page that is not in use, which is used when it is complete.

    A reset leaves the page that is in use.  Software writes while no frame comes; its place counts up with each word.
    """

    latency = READ

    def __init__(self, taxels: int) -> None:
        index, repair = counter_shape(taxels - 1), counter_shape(repair_places(taxels) - 1)
        super().__init__(
            {
                "software": In(TABLES),
                "taxel": In(1),  # the entry of taxel ``index`` is wanted ...
                "index": In(index),
                "offset": Out(signed(DEVIATION)),  # ... and comes ``latency`` cycles later
                "gain": Out(GAIN),
                "tare": In(1),  # taxel ``place`` gets the offset ``mean``, and keeps ``gain``, which is being read
                "place": In(index),
                "mean": In(signed(DEVIATION)),
                "turn": In(1),  # pulse: all offsets of a tare are written
                "repair": Out(1),  # software writes ``software.data`` to the table of repairs ...
                "repair_place": Out(repair),  # ... at this place
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        depth = 2 << len(self.index)
        m.submodules.entries = entries = Memory(shape=_ENTRY, depth=depth, init=[[0, UNITY]] * depth)
        read, write = entries.read_port(), entries.write_port(granularity=1)
        page = Signal(reset_less=True)
        place = Signal(max(len(self.index), len(self.repair_place)), reset_less=True)
        software = self.software
        with m.If(self.turn):
            m.d.sync += page.eq(~page)
        with m.If(software.data_written):
            m.d.sync += place.eq(place + 1)
        with m.If(software.place_written):
            m.d.sync += place.eq(software.index)
        writes = [software.data_written & (software.kind == kind) for kind in (OFFSETS, GAINS, REPAIRS)]
        taxel = place[: len(self.index)]
        entry = register(m, read.data, "entry")
        m.d.comb += [
            read.addr.eq(Cat(Mux(self.taxel, self.index, taxel), page)),
            self.offset.eq(entry[OFFSETS].as_signed()),
            self.gain.eq(entry[GAINS]),
            write.en.eq(Mux(self.tare, 0b11, Cat(writes[OFFSETS], writes[GAINS]))),
            write.addr.eq(Mux(self.tare, Cat(self.place, ~page), Cat(taxel, page))),
            write.data[OFFSETS].eq(Mux(self.tare, self.mean.as_unsigned(), software.data)),
            write.data[GAINS].eq(Mux(self.tare, self.gain, software.data[:GAIN])),
            self.repair.eq(writes[REPAIRS]),
            self.repair_place.eq(place),
        ]
        offset = Signal(signed(BITS))
        m.d.comb += offset.eq(read.data[OFFSETS].as_signed())
        with m.Switch(software.kind):
            with m.Case(OFFSETS):
                m.d.comb += software.value.eq(offset)
            with m.Case(GAINS):
                m.d.comb += software.value.eq(read.data[GAINS])
        return m
