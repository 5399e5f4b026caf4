"""Faults of taxels become flags of a frame, and events."""

from __future__ import annotations

from typing import Any

from amaranth import Module, Mux, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.front_end.history import FAULTS
from tfra.hdl.front_end.ports import FAULTY, FLAGS
from tfra.hdl.lib.arithmetic import counter_shape


class Faults(wiring.Component):
    """Collects what is wrong with a frame, and with the frames that it is the mean of.

    Members:
        taxel, index, faults: in.
        end: in, a complete frame has ended, a cycle after its last taxel at the earliest; ``gap``: with a gap before.
        completes: with ``end``, the frame goes to the core; ``tares``: it is one of a tare.
        simulate: in, pulse.
        flags: out, those of the core's frame, while it ``completes``.
        events: out, those of the frame that ends.
        faulty: out, the last faulty taxel of the frame that ends; ``faulty_store``: out, it has one.
    """

    def __init__(self, taxels: int) -> None:
        ends = dict.fromkeys(("end", "gap", "completes", "tares", "simulate"), In(1))
        taxel = {"taxel": In(1), "index": In(counter_shape(taxels - 1)), "faults": In(FAULTS)}
        outputs = {"flags": Out(FLAGS), "events": Out(FAULTS), "faulty": Out(FAULTY), "faulty_store": Out(1)}
        super().__init__({**taxel, **ends, **outputs})

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        seen = Signal(FAULTS, reset_less=True)  # in this frame
        before = Signal(FLAGS)  # in frames of the same mean
        simulated = Signal()
        worst = Signal(FAULTY, reset_less=True)
        with m.If(self.taxel):
            m.d.sync += seen.eq(Mux(self.index == 0, 0, seen.as_value()) | self.faults.as_value())
        with m.If(self.taxel & self.faults.as_value().any()):
            m.d.sync += [worst.index.eq(self.index), *(worst[name].eq(self.faults[name]) for name, _ in FAULTS)]
        m.d.comb += [
            self.flags.saturation.eq(before.saturation | seen.saturated),
            self.flags.out_of_range.eq(before.out_of_range | seen.out_of_range),
            self.flags.stuck.eq(before.stuck | seen.stuck),
            self.flags.sequence_gap.eq(before.sequence_gap | self.gap),
            self.flags.simulated.eq(simulated),
            self.events.eq(Mux(self.end, seen.as_value(), 0)),
            self.faulty.eq(worst),
            self.faulty_store.eq(self.end & seen.as_value().any()),
        ]
        with m.If(self.end):
            m.d.sync += before.eq(Mux(self.completes | self.tares, 0, self.flags.as_value()))
        with m.If(self.end & self.completes):
            m.d.sync += simulated.eq(0)
        with m.If(self.simulate):
            m.d.sync += simulated.eq(1)
        return m
