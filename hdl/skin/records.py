"""Records of contacts: a header before the words of the core; see :mod:`tfra.model.skin.records`."""

from typing import Any

from amaranth import Array, Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.interface import ports
from tfra.hdl.lib.arithmetic import counter_shape
from tfra.hdl.lib.streams import SkidBuffer
from tfra.hdl.skin.payloads import contact, ending
from tfra.model.skin.records import header_bits
from tfra.model.skin.skin import Skin


class Records(wiring.Component):
    """In: contacts, what is known of them later, and the words of their windows.  Out: a record of each.

    A header leaves when all of it is known, whether the core has words or not.
    """

    def __init__(self, skin: Skin) -> None:
        self._bits = header_bits(skin)
        super().__init__({
            "contact": In(stream.Signature(contact(skin))),
            "ending": In(stream.Signature(ending(skin))),
            "words": In(stream.Signature(ports.result(skin.window))),
            "result": Out(stream.Signature(ports.result(skin))),  # registered
        })

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.skid = skid = SkidBuffer(self.result.payload.shape())
        wiring.connect(m, skid.o, wiring.flipped(self.result))
        frame = Signal(self._bits["frame"])
        number = Signal(self._bits["contact"])
        index = Signal(counter_shape(len(self._bits)))  # of a word of the header, or after them
        given, ending, words = self.contact.payload, self.ending.payload, self.words.payload
        facts = {"frame": frame, "contact": number, "last": ending.last, "dropped": ending.dropped}
        header = [facts[name] if name in facts else given[name] for name in self._bits]
        is_header = index != len(self._bits)
        sent = skid.i.valid & skid.i.ready
        ends = sent & skid.i.payload.last
        m.d.comb += [
            skid.i.valid.eq(Mux(is_header, self.contact.valid & self.ending.valid, self.words.valid)),
            skid.i.payload.data.eq(Mux(is_header, Array(header)[index], words.data)),
            skid.i.payload.last.eq(~is_header & words.last),
            self.words.ready.eq(~is_header & skid.i.ready),
            self.contact.ready.eq(ends),
            self.ending.ready.eq(ends),
        ]
        with m.If(ends):
            m.d.sync += [
                index.eq(0),
                number.eq(Mux(ending.last, 0, number + 1)),
                frame.eq(frame + ending.last),
            ]
        with m.Elif(sent & is_header):
            m.d.sync += index.eq(index + 1)
        return m
