"""A frame on its way to the core: its repairs, then its codes."""

from typing import Any

from amaranth import Module, Mux, Signal
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.front_end.codes import stored_code
from tfra.hdl.lib.arithmetic import counter_shape
from tfra.hdl.lib.pipeline import wrapping_counter
from tfra.hdl.lib.streams import SkidBuffer
from tfra.model.converter import Measured


class OutputReader(wiring.Component):
    """Read the codes of one frame after the other from memory, while a frame is ``waiting``.

    ========  =======================================  ====================================================
    state     what it does                             ends with
    ========  =======================================  ====================================================
    REPAIR    lets the frame be repaired               ``waiting`` and ``repaired``, or ``ahead`` of reading
    READ      reads a code a cycle                     the address of the last code
    SEND      waits for the skid buffer                the transfer of the last code
    ========  =======================================  ====================================================

    A frame that is cut through is read while it comes, as far as its codes are written.
    """

    latency = 4
    """Cycles from the first one in which a frame is ``waiting`` to the transfer of its first code, without repairs."""

    def __init__(self, array: Measured) -> None:
        taxels, code = array.sensor.taxels, stored_code(array.adc.bits)
        self._taxels = taxels
        super().__init__({
            "waiting": In(1),  # a frame is there, whose codes are written before they are read one by one
            "repair": Out(1),  # the frame is being repaired ...
            "repaired": In(1),  # ... until it is
            "cut": In(1),  # the frame that comes is cut through ...
            "written": In(counter_shape(taxels - 1)),  # ... and its next code that is not written, or the first one
            "address": Out(counter_shape(taxels - 1)),  # of a code
            "read": Out(1),
            "stored": In(code),  # the code, a cycle after ``read``
            "silent": In(1),  # no code of the frame reaches the threshold of a contact
            "codes": Out(stream.Signature(code.members["code"])),  # registered
            "done": Out(1),  # the frame's last code is taken
        })

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.skid = skid = SkidBuffer(data.StructLayout({"code": self.codes.payload.shape(), "end": 1}))
        advance = skid.i.ready
        reading = Signal()
        ahead = Signal()
        address, last = wrapping_counter(m, reading & advance, self._taxels, "address")
        fetched = Signal()
        end = Signal()
        word = Signal(self.stored.shape(), reset_less=True)
        with m.If(advance):
            m.d.sync += [
                fetched.eq(reading),
                end.eq(last),
                skid.i.valid.eq(fetched),
                skid.i.payload.end.eq(end),
                word.eq(self.stored),
            ]
        m.d.comb += [
            self.address.eq(address),
            self.read.eq(advance),
            ahead.eq(self.cut & (address != self.written)),
            skid.i.payload.code.eq(Mux(self.silent | word.small, 0, word.code)),
            self.codes.valid.eq(skid.o.valid),
            self.codes.payload.eq(skid.o.payload.code),
            skid.o.ready.eq(self.codes.ready),
            self.done.eq(skid.o.payload.end & self.codes.valid & self.codes.ready),
        ]
        with m.FSM():
            with m.State("REPAIR"):
                m.d.comb += self.repair.eq(self.waiting)
                m.d.comb += reading.eq(ahead)
                with m.If((self.waiting & self.repaired) | (ahead & advance)):
                    m.next = "READ"
            with m.State("READ"):
                m.d.comb += reading.eq(self.waiting | ahead)
                with m.If(reading & last & advance):
                    m.next = "SEND"
            with m.State("SEND"), m.If(self.done):
                m.next = "REPAIR"
        return m
