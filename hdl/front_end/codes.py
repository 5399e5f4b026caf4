"""Codes of two frames, made by one multiplier: a taxel's word times its gain, or a sum of codes times weights."""

from __future__ import annotations

from typing import Any

from amaranth import Cat, Const, Module, Mux, Signal, Value, signed
from amaranth.lib import data, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.arithmetic import counter_shape, saturate
from tfra.hdl.lib.pipeline import delayed, register
from tfra.hdl.primitives.multiplier import Multiplier
from tfra.model.fixed.design import Design
from tfra.model.fixed.front_end import DEVIATION, GAIN, PRODUCT_POINT, WEIGHT, WORD, repair_places

FETCH = 2
"""Cycles from a code's address to the multiplier."""


def product_slot(taxels: int) -> data.StructLayout:
    """A taxel on its way to the multiplier; ``page`` is where its code goes."""
    return data.StructLayout(
        {
            "valid": 1,
            "deviation": signed(DEVIATION),
            "gain": signed(GAIN + 1),
            "index": counter_shape(taxels - 1),
            "page": 1,
        }
    )


def term_slot(taxels: int) -> data.StructLayout:
    """A term of a repair; an ``end`` has the weight 0, and if it ``writes``, the sum becomes the code of ``target``."""
    members = {"valid": 1, "end": 1, "writes": 1, "weight": signed(WEIGHT), "target": counter_shape(taxels - 1)}
    return data.StructLayout(members)


def stored_code(bits: int) -> data.StructLayout:
    """A code; ``small`` if it is in the dead band."""
    return data.StructLayout({"code": signed(bits), "small": 1})


class Codes(wiring.Component):
    """Multiplies, rounds, saturates and stores; one product a cycle.

    A term enters in the cycle in which ``address`` is that of its code, and reaches the multiplier :data:`FETCH` cycles
    later.  No taxel may come to it then.  Multiplier: 18 x 18 bits, one cell on most devices; memory: two pages of
    codes.

    Members:
        taxel: in; ``term``: in.
        contact, dead_band: settings.
        page: in, of the frame that is repaired and read; ``address``, ``read``: in, ``stored``: a cycle later.
        reached: of each page, a code reaches ``contact``.
    """

    latency = Multiplier.latency + 2
    """Cycles from the multiplier's operands to the cycle that writes the code."""

    def __init__(self, design: Design) -> None:
        self._design = design
        taxels, bits = design.sensor.taxels, design.adc.bits
        super().__init__(
            {
                "taxel": In(product_slot(taxels)),
                "term": In(term_slot(taxels)),
                "contact": In(16),
                "dead_band": In(16),
                "page": In(1),
                "address": In(counter_shape(taxels - 1)),
                "read": In(1),
                "stored": Out(stored_code(bits)),
                "reached": Out(2),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.places = codes = Memory(
            shape=stored_code(self._design.adc.bits), depth=2 << len(self.address), init=[]
        )
        read, write = codes.read_port(), codes.write_port()
        code = register(m, self._code(m, read.data.code), "code")
        size = Signal(len(code))
        taxel, end = Signal(), Signal()  # the code is that of a taxel, of a repair
        index = delayed(m, self.taxel.index, self.latency, "index")
        first = register(m, delayed(m, self.taxel.index, self.latency - 1) == 0, "first")
        page = delayed(m, self.taxel.page, self.latency, "page")
        m.d.comb += [
            *(read.addr.eq(Cat(self.address, self.page)), read.en.eq(self.read), self.stored.eq(read.data)),
            taxel.eq(delayed(m, self.taxel.valid, self.latency, "taxel", control=True)),
            end.eq(delayed(m, self.term.valid & self.term.writes, FETCH + self.latency, "end", control=True)),
            size.eq(abs(code)),
            *(write.en.eq(taxel | end), write.data.code.eq(code), write.data.small.eq(size < self.dead_band)),
            write.addr.eq(Mux(end, Cat(self._target(m), self.page), Cat(index, page))),
        ]
        reaches = size >= self.contact
        for number, reached in enumerate(self.reached):
            mine = taxel & (page == number)
            with m.If(mine):
                m.d.sync += reached.eq(reaches | (reached & ~first))
            with m.If(end & (self.page == number)):
                m.d.sync += reached.eq(reaches | reached)
        return m

    def _target(self, m: Module) -> Value:
        """Of the last end of a repair; no other one comes before its code is written."""
        target = Signal.like(self.term.target, reset_less=True)
        with m.If(self.term.valid & self.term.end):
            m.d.sync += target.eq(self.term.target)
        return target

    def _code(self, m: Module, source: Value) -> Value:
        """The sum of a repair's products, or a taxel's product, rounded and saturated.

        A code is moved up, so that both have their point at the same place; rounding is a half in the sum.
        """
        bits, taxels = self._design.adc.bits, self._design.sensor.taxels
        point = PRODUCT_POINT - bits
        half = Const(1 << (point - 1), point)
        # A code has two bits less than a factor; the sums of all terms, and a half.
        longest = DEVIATION + GAIN + 1 - (GAIN + 1 - WORD) + repair_places(taxels).bit_length()
        m.submodules.multiplier = multiplier = Multiplier(DEVIATION, GAIN + 1, self._design.target)
        repairs = delayed(m, self.term.valid, FETCH, "repairs", control=True)
        weight = delayed(m, self.term.weight, FETCH, "weight")
        source = register(m, source, "source") << (WORD - bits)
        m.d.comb += [
            multiplier.a.eq(Mux(repairs, weight, self.taxel.deviation)),
            multiplier.b.eq(Mux(repairs, source, self.taxel.gain)),
        ]
        adds = delayed(m, repairs, Multiplier.latency, "adds", control=True)
        ends = delayed(m, self.term.end, FETCH + Multiplier.latency, "ends")
        before = Signal(signed(longest), reset_less=True)
        total = Signal.like(before, reset_less=True)
        sums = Signal.like(before)
        m.d.comb += sums.eq(multiplier.product + Mux(adds, before, half))
        m.d.sync += total.eq(sums)
        with m.If(adds):
            m.d.sync += before.eq(Mux(ends, half, sums))
        return saturate(total[point:].as_signed(), bits)
