"""Loads coefficients from a stream into the memories of the lanes after a reset."""

from typing import Any

from amaranth import Module, Signal, signed
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.arithmetic import counter_shape
from tfra.hdl.lib.pipeline import wrapping_counter
from tfra.hdl.parallel.matvec.images import depth
from tfra.model.fixed.design import Design


class Loader(wiring.Component):
    """Writes coefficients lane by lane, each lane's in the order in which it reads them."""

    def __init__(self, design: Design) -> None:
        self._design, self._depth = design, depth(design)
        coefficient = signed(design.coefficient_word)
        super().__init__({
            "load": In(stream.Signature(coefficient)),  # l times ``depth`` coefficients after a reset, and never more
            "loading": Out(1, init=1),  # high until all have arrived; a register
            "writing": Out(1, init=1),  # high until the last of them has been written; a register
            # A bit for each lane, high when a coefficient is to be written; a register.
            "write": Out(design.architecture.mac_lanes),
            "address": Out(counter_shape(self._depth - 1)),  # its address; a register
            "data": Out(coefficient),  # the coefficient; a register
        })

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        taken = Signal()
        m.d.comb += self.load.ready.eq(self.loading)
        m.d.comb += taken.eq(self.load.valid & self.load.ready)
        address, last = wrapping_counter(m, taken, self._depth, "address")
        lane = Signal(len(self.write), init=1)  # one bit, of the lane whose turn it is
        m.d.sync += [
            self.writing.eq(self.loading),
            self.write.eq(lane & taken.replicate(len(lane))),
            self.address.eq(address),
            self.data.eq(self.load.payload),
        ]
        with m.If(taken & last):
            m.d.sync += lane.eq(lane << 1)
            m.d.sync += self.loading.eq(~lane[-1])
        return m
