"""A core that stands for that of the window: few words a window, which depend on every taxel and its place."""

from typing import Any

import numpy as np
from amaranth import Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.interface import ports
from tfra.hdl.lib.arithmetic import counter_shape
from tfra.model.arrays import Ints
from tfra.model.fixed.design import Design

BITS = 16
_FACTOR = 5


class Stub(wiring.Component):
    """In: windows.  Out: the number of the window, then a checksum of its taxels."""

    def __init__(self, design: Design) -> None:
        self._taxels = design.sensor.taxels
        super().__init__({
            "taxel": In(stream.Signature(ports.taxel(design))),
            "result": Out(stream.Signature(ports.result(design))),
        })

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        number, checksum = Signal(BITS), Signal(BITS)
        left = Signal(counter_shape(self._taxels), init=self._taxels)
        second = Signal()
        m.d.comb += [
            self.taxel.ready.eq(left != 0),
            self.result.valid.eq(left == 0),
            self.result.payload.data.eq(Mux(second, checksum, number)),
            self.result.payload.last.eq(second),
        ]
        with m.If(self.taxel.valid & self.taxel.ready):
            m.d.sync += checksum.eq(checksum * _FACTOR + self.taxel.payload)
            m.d.sync += left.eq(left - 1)
        with m.If(self.result.valid & self.result.ready):
            m.d.sync += second.eq(~second)
            with m.If(second):
                m.d.sync += [
                    checksum.eq(0),
                    number.eq(number + 1),
                    left.eq(self._taxels),
                ]
        return m


def stub_words(windows: Ints) -> Ints:
    """The words of a :class:`Stub` for ``windows (k, rows, columns)``."""
    checksum = np.zeros(len(windows), dtype=np.int64)
    for taxel in windows.reshape(len(windows), -1).T:
        checksum = (checksum * _FACTOR + taxel) % (1 << BITS)
    return np.stack([np.arange(len(windows)) % (1 << BITS), checksum], axis=1)
