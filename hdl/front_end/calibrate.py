"""The mean of a taxel's words less its offset, with the gain that it is multiplied by."""

from __future__ import annotations

from typing import Any

from amaranth import Cat, Const, Module, Mux, Signal, signed
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.front_end.codes import product_slot
from tfra.hdl.front_end.history import FAULTS, summed
from tfra.hdl.front_end.ports import TABLES
from tfra.hdl.front_end.tables import Tables
from tfra.hdl.lib.arithmetic import counter_shape, round_half, saturate, shift_right
from tfra.hdl.lib.pipeline import delayed, register
from tfra.model.fixed.front_end import DEVIATION, repair_places


class Calibrate(wiring.Component):
    """Divides sums by the number of frames, subtracts offsets, looks up gains; a taxel a cycle.

    A gain of 0 marks a dead taxel, whose faults are not reported.

    Members:
        i: in, a taxel; ``o``: out, :attr:`latency` cycles later, without ``page``; ``faults``: with it.
        log2_average, log2_tare, invert: settings; ``software``: tables; ``turn``: in, a tare is complete.
        repair, repair_place: out, software writes to the table of repairs.
    """

    latency = 3

    def __init__(self, taxels: int) -> None:
        self._taxels = taxels
        super().__init__(
            {
                "i": In(summed(taxels)),
                "log2_average": In(3),
                "log2_tare": In(3),
                "invert": In(1),
                "software": In(TABLES),
                "turn": In(1),
                "o": Out(product_slot(taxels)),
                "faults": Out(FAULTS),
                "repair": Out(1),
                "repair_place": Out(counter_shape(repair_places(taxels) - 1)),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.tables = tables = Tables(self._taxels)
        wiring.connect(m, wiring.flipped(self.software), tables.software)
        i, o = self.i, self.o
        log2 = Mux(i.part.tares, self.log2_tare, self.log2_average)
        # A mean has 18 bits: two less than a sum of one frame, doubled, with one bit below the point.
        divided = register(m, shift_right(Cat(Const(0, 1), i.sum).as_signed(), log2)[: DEVIATION + 1], "divided")
        mean = register(m, round_half(divided.as_signed())[:DEVIATION].as_signed(), "mean")
        index = delayed(m, i.index, tables.latency, "index")
        valid = delayed(m, i.valid, tables.latency, "valid", control=True)
        tares = delayed(m, i.part.tares & i.part.final, tables.latency, "tares")
        faults = delayed(m, i.faults, tables.latency, "faults")
        gain = Signal(signed(len(tables.gain) + 1))
        m.d.comb += [
            *(tables.taxel.eq(i.valid), tables.index.eq(i.index), tables.turn.eq(self.turn)),
            *(tables.tare.eq(valid & tares), tables.place.eq(index), tables.mean.eq(mean)),
            *(self.repair.eq(tables.repair), self.repair_place.eq(tables.repair_place)),
            gain.eq(Mux(self.invert, -tables.gain, tables.gain)),
            o.valid.eq(register(m, valid, "valid", control=True)),
            o.deviation.eq(register(m, saturate(mean - tables.offset, DEVIATION), "deviation")),
            *(o.gain.eq(register(m, gain, "gain")), o.index.eq(register(m, index, "index"))),
        ]
        alive = valid & tables.gain.any()
        m.d.comb += self.faults.eq(register(m, faults.as_value() & alive.replicate(len(faults.as_value())), "faults"))
        return m
