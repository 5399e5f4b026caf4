"""The mean of a taxel's words less its offset, with the gain that it is multiplied by; the tables of both."""

from typing import Any

from amaranth import Cat, Const, Module, Mux, Signal, Value, signed
from amaranth.lib import data, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from tfra.hdl.bus.map import BITS
from tfra.hdl.front_end.codes import product_slot
from tfra.hdl.front_end.history import FAULTS, summed
from tfra.hdl.front_end.ports import TABLES
from tfra.hdl.lib.arithmetic import counter_shape, round_off, saturate, shift_right
from tfra.hdl.lib.pipeline import READ, delayed, register
from tfra.model.fixed.front_end import DEVIATION, GAIN, UNITY, repair_places

OFFSETS, GAINS, REPAIRS = range(3)
"""Kinds of tables, as in CALIBRATION_PLACE."""

_ENTRY = data.ArrayLayout(DEVIATION, 2)
"""Offset and gain of a taxel: halves of a word of memory, which software writes one by one."""


class Calibrate(wiring.Component):
    """``sum / frames - offset``, and the gain; a taxel a cycle.

    A gain of 0 marks a dead taxel, whose faults are not reported.  There are two pages of offsets and gains: a tare
    writes the page that is not in use, which is used when it is complete.  A reset leaves the page that is in use.
    Software writes while no frame comes.

    =====  =================================  =======================================
    cycle  mean                               tables
    =====  =================================  =======================================
    0      divide the sum                     address
    1      round                              memory
    2      subtract the offset and saturate   offset and gain; ``invert`` its sign
    3      ``o``, ``faults``
    =====  =================================  =======================================
    """

    latency = 3

    def __init__(self, taxels: int) -> None:
        self._taxels = taxels
        super().__init__({
            "i": In(summed(taxels)),
            "log2_average": In(3),  # settings: log2 of the frames of a mean, of a tare
            "log2_tare": In(3),
            "invert": In(1),  # setting: codes have the opposite sign
            "software": In(TABLES),
            "turn": In(1),  # pulse: all offsets of a tare are written
            "o": Out(product_slot(taxels)),  # ``latency`` cycles after ``i``, without ``page``
            "faults": Out(FAULTS),  # of the taxel at ``o``
            "repair": Out(1),  # pulse: software writes to the table of repairs ...
            "repair_place": Out(counter_shape(repair_places(taxels) - 1)),  # ... at this place ...
            "repair_word": In(BITS),  # ... which has this word, two cycles later
        })

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        i, o = self.i, self.o
        log2 = Mux(i.part.tares, self.log2_tare, self.log2_average)
        doubled = Cat(Const(0, 1), i.sum).as_signed()  # the unit of a deviation is half of that of a word
        divided = register(m, shift_right(doubled, log2)[: DEVIATION + 1], "divided")  # a bit below the point
        mean = register(m, round_off(divided.as_signed(), 1)[:DEVIATION].as_signed(), "mean")
        index = delayed(m, i.index, READ, "index")
        valid = delayed(m, i.valid, READ, "valid", control=True)
        tares = delayed(m, i.part.tares & i.part.final, READ, "tares")
        faults = delayed(m, i.faults, READ, "faults").as_value()
        tare = Signal()
        entry = self._tables(m, tare, index, mean)
        unsigned_gain = entry[GAINS][:GAIN]
        gain = Signal(signed(GAIN + 1))
        alive = valid & unsigned_gain.any()
        m.d.comb += [
            tare.eq(valid & tares),
            gain.eq(Mux(self.invert, -unsigned_gain, unsigned_gain)),
            o.valid.eq(register(m, valid, "valid", control=True)),
            o.deviation.eq(register(m, saturate(mean - entry[OFFSETS].as_signed(), DEVIATION), "deviation")),
            o.gain.eq(register(m, gain, "gain")),
            o.index.eq(register(m, index, "index")),
            self.faults.eq(register(m, faults & alive.replicate(len(faults)), "faults")),
        ]
        return m

    def _tables(self, m: Module, tare: Value, place: Value, mean: Value) -> Any:
        """Offset and gain of the taxel that is at ``i``, ``READ`` cycles later.

        Where ``tare``, the offset of the taxel ``place`` becomes ``mean``, and it keeps the gain that is being read.
        """
        depth = 2 << len(place)
        m.submodules.entries = entries = Memory(shape=_ENTRY, depth=depth, init=[[0, UNITY]] * depth)
        read, write = entries.read_port(), entries.write_port(granularity=1)
        page = Signal(reset_less=True)
        software = self.software
        with m.If(self.turn):
            m.d.sync += page.eq(~page)
        writes = [software.data_written & (software.kind == kind) for kind in (OFFSETS, GAINS, REPAIRS)]
        taxel = software.index[: len(place)]
        entry = register(m, read.data, "entry")
        m.d.comb += [
            read.addr.eq(Cat(Mux(self.i.valid, self.i.index, taxel), page)),
            write.en.eq(Mux(tare, 0b11, Cat(writes[OFFSETS], writes[GAINS]))),
            write.addr.eq(Mux(tare, Cat(place, ~page), Cat(taxel, page))),
            write.data[OFFSETS].eq(Mux(tare, mean.as_unsigned(), software.data)),
            write.data[GAINS].eq(Mux(tare, entry[GAINS][:GAIN], software.data[:GAIN])),
            self.repair.eq(writes[REPAIRS]),
            self.repair_place.eq(software.index),
        ]
        with m.Switch(software.kind):
            with m.Case(OFFSETS):
                m.d.comb += software.value.eq(entry[OFFSETS].as_signed())
            with m.Case(GAINS):
                m.d.comb += software.value.eq(entry[GAINS])
            with m.Case(REPAIRS):
                m.d.comb += software.value.eq(self.repair_word)
        return entry
