"""Coefficients from a stream, after a reset, into the memories of the lanes."""

from __future__ import annotations

from typing import Any

from amaranth import Module, Signal, signed
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from tfra.codegen.images import depth
from tfra.hdl.arithmetic import count
from tfra.hdl.pipeline import walk
from tfra.model.design import Design


class Loader(wiring.Component):
    """Where each coefficient goes: all of a lane, in the order in which it reads them, lane by lane.

    Members:
        load: stream in, L times ``depth`` coefficients after a reset, and never more.
        loading: high until they are all there; a register.
        write, lane, address, word: registers.
        writing: high until the last of them has been written.
    """

    def __init__(self, design: Design) -> None:
        self._depth, self._lanes = depth(design), design.architecture.mac_lanes
        coefficient = signed(design.formats.coefficient)
        super().__init__(
            {
                "load": In(stream.Signature(coefficient)),
                "loading": Out(1, init=1),
                "writing": Out(1, init=1),
                "write": Out(1),
                "lane": Out(count(self._lanes - 1)),
                "address": Out(count(self._depth - 1)),
                "word": Out(coefficient),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        taken = Signal()
        m.d.comb += [self.load.ready.eq(self.loading), taken.eq(self.load.valid & self.load.ready)]
        address, last = walk(m, taken, self._depth, "address")
        lane, last_lane = walk(m, taken & last, self._lanes, "lane_number")
        m.d.sync += [
            self.writing.eq(self.loading),
            self.write.eq(taken),
            self.lane.eq(lane),
            self.address.eq(address),
            self.word.eq(self.load.payload),
        ]
        with m.If(taken & last):
            m.d.sync += self.loading.eq(~last_lane)
        return m
