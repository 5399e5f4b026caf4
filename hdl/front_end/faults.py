"""Faults of taxels become flags of a frame, and events."""

from typing import Any

from amaranth import Module, Mux, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.front_end.history import FAULTS
from tfra.hdl.front_end.ports import FAULTY, FLAGS
from tfra.hdl.lib.arithmetic import counter_shape


class Faults(wiring.Component):
    """Collect what is wrong with a frame, and with the frames that it is the mean of."""

    def __init__(self, taxels: int) -> None:
        super().__init__({
            "taxel": In(1),  # a taxel is at ``index`` and ``faults``
            "index": In(counter_shape(taxels - 1)),
            "faults": In(FAULTS),
            "end": In(1),  # a complete frame has ended, a cycle after its last taxel at the earliest ...
            "gap": In(1),  # ... with a gap before it,
            "completes": In(1),  # it goes to the core,
            "tares": In(1),  # it is one of a tare
            "simulate": In(1),  # pulse
            "flags": Out(FLAGS),  # of the core's frame, while it ``completes``
            "events": Out(FAULTS),  # of the frame that ends
            "faulty": Out(FAULTY),  # the last faulty taxel of the frame that ends ...
            "faulty_store": Out(1),  # ... if it has one
        })

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        faults = self.faults.as_value()
        frame_faults = Signal(FAULTS, reset_less=True)
        earlier = Signal(FLAGS)  # of the frames before in the same mean
        simulated = Signal()
        worst = Signal(FAULTY, reset_less=True)
        with m.If(self.taxel):
            m.d.sync += frame_faults.eq(Mux(self.index == 0, 0, frame_faults.as_value()) | faults)
        with m.If(self.taxel & faults.any()):
            m.d.sync += [worst.index.eq(self.index), *(worst[name].eq(self.faults[name]) for name, _ in FAULTS)]
        m.d.comb += [
            self.flags.saturation.eq(earlier.saturation | frame_faults.saturated),
            self.flags.out_of_range.eq(earlier.out_of_range | frame_faults.out_of_range),
            self.flags.stuck.eq(earlier.stuck | frame_faults.stuck),
            self.flags.sequence_gap.eq(earlier.sequence_gap | self.gap),
            self.flags.simulated.eq(simulated),
            self.events.eq(Mux(self.end, frame_faults.as_value(), 0)),
            self.faulty.eq(worst),
            self.faulty_store.eq(self.end & frame_faults.as_value().any()),
        ]
        with m.If(self.end):
            m.d.sync += earlier.eq(Mux(self.completes | self.tares, 0, self.flags.as_value()))
        with m.If(self.end & self.completes):
            m.d.sync += simulated.eq(0)
        with m.If(self.simulate):
            m.d.sync += simulated.eq(1)
        return m
