"""The mean of a taxel's words less its offset, with the gain that it is multiplied by."""

from typing import Any

from amaranth import Cat, Const, Module, Mux, Signal, signed
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.front_end.codes import product_slot
from tfra.hdl.front_end.history import FAULTS, summed
from tfra.hdl.front_end.ports import TABLES
from tfra.hdl.front_end.tables import Tables
from tfra.hdl.lib.arithmetic import counter_shape, round_off, saturate, shift_right
from tfra.hdl.lib.pipeline import delayed, register
from tfra.model.fixed.front_end import DEVIATION, repair_places


class Calibrate(wiring.Component):
    """``sum / frames - offset``, and the gain; a taxel a cycle.

    A gain of 0 marks a dead taxel, whose faults are not reported.

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
        super().__init__(
            {
                "i": In(summed(taxels)),
                "log2_average": In(3),  # settings: log2 of the frames of a mean, of a tare
                "log2_tare": In(3),
                "invert": In(1),  # setting: codes have the opposite sign
                "software": In(TABLES),
                "turn": In(1),  # pulse: all offsets of a tare are written
                "o": Out(product_slot(taxels)),  # ``latency`` cycles after ``i``, without ``page``
                "faults": Out(FAULTS),  # of the taxel at ``o``
                "repair": Out(1),  # pulse: software writes to the table of repairs ...
                "repair_place": Out(counter_shape(repair_places(taxels) - 1)),  # ... at this place
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.tables = tables = Tables(self._taxels)
        wiring.connect(m, wiring.flipped(self.software), tables.software)
        i, o = self.i, self.o
        log2 = Mux(i.part.tares, self.log2_tare, self.log2_average)
        doubled = Cat(Const(0, 1), i.sum).as_signed()  # the unit of a deviation is half of that of a word
        divided = register(m, shift_right(doubled, log2)[: DEVIATION + 1], "divided")  # a bit below the point
        mean = register(m, round_off(divided.as_signed(), 1)[:DEVIATION].as_signed(), "mean")
        index = delayed(m, i.index, tables.latency, "index")
        valid = delayed(m, i.valid, tables.latency, "valid", control=True)
        tares = delayed(m, i.part.tares & i.part.final, tables.latency, "tares")
        faults = delayed(m, i.faults, tables.latency, "faults").as_value()
        alive = valid & tables.gain.any()
        gain = Signal(signed(len(tables.gain) + 1))
        m.d.comb += [
            tables.taxel.eq(i.valid),
            tables.index.eq(i.index),
            tables.turn.eq(self.turn),
            tables.tare.eq(valid & tares),
            tables.place.eq(index),
            tables.mean.eq(mean),
            self.repair.eq(tables.repair),
            self.repair_place.eq(tables.repair_place),
            gain.eq(Mux(self.invert, -tables.gain, tables.gain)),
            o.valid.eq(register(m, valid, "valid", control=True)),
            o.deviation.eq(register(m, saturate(mean - tables.offset, DEVIATION), "deviation")),
            o.gain.eq(register(m, gain, "gain")),
            o.index.eq(register(m, index, "index")),
            self.faults.eq(register(m, faults & alive.replicate(len(faults)), "faults")),
        ]
        return m
