"""Codes of two frames, computed by one multiplier: a taxel's word times its gain, or a sum of codes times weights."""

from typing import Any

from amaranth import Cat, Const, Module, Mux, Signal, Value, signed
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.arithmetic import counter_shape, saturate
from tfra.hdl.lib.pipeline import delayed, register
from tfra.hdl.lib.ram import Ram
from tfra.hdl.primitives import Multiplier
from tfra.model.fixed.design import Design
from tfra.model.fixed.front_end import DEVIATION, GAIN, PRODUCT_POINT, WEIGHT, WORD, repair_places
from tfra.model.rounding import Rounding
from tfra.model.skin.skin import Skin, core_of

FETCH = 2
"""Cycles from a code's address to the multiplier."""


def product_slot(taxels: int) -> data.StructLayout:
    """A taxel on its way to the multiplier; ``page`` is where its code goes."""
    return data.StructLayout({
        "valid": 1,
        "deviation": signed(DEVIATION),
        "gain": signed(GAIN + 1),
        "index": counter_shape(taxels - 1),
        "page": 1,
    })


def term_slot(taxels: int) -> data.StructLayout:
    """A term of a repair; an ``end`` has the weight 0, and if it ``writes``, the sum becomes the code of ``target``."""
    return data.StructLayout({
        "valid": 1,
        "end": 1,
        "writes": 1,
        "weight": signed(WEIGHT),
        "target": counter_shape(taxels - 1),
    })


def stored_code(bits: int) -> data.StructLayout:
    """A code; ``small`` if it is in the dead band."""
    return data.StructLayout({"code": signed(bits), "small": 1})


class Codes(wiring.Component):
    """Multiply, round, saturate and store; one product a cycle.

    ::

        deviation, gain ─┐                          ┌─── sum of a repair ◀──┐
                         ├▶ multiplier ─▶ product ─▶ + ─▶ total ─▶ saturate ─▶ code ─▶ memory ─▶ stored
        weight, code ────┘                          └─── half                            │
                  ▲──────────────────────────────────────────────────────────────────────┘

    A term enters in the cycle in which ``address`` is that of its code, and reaches the multiplier :data:`FETCH` cycles
    later.  No taxel may come to it then.

    Resources: a multiplier of 18 x 18 bits, one cell on most devices; two pages of codes.
    """

    latency = Multiplier.latency + 3
    """Cycles from the multiplier's operands to the cycle that writes the code."""

    def __init__(self, array: Design | Skin) -> None:
        self._array = array
        taxels, bits = array.sensor.taxels, array.adc.bits
        self._point = PRODUCT_POINT - bits  # bits of a product below the point of a code
        super().__init__({
            "taxel": In(product_slot(taxels)),
            "term": In(term_slot(taxels)),
            "contact": In(16),  # setting: least size of a code that is a contact
            "dead_band": In(16),  # setting: codes below it are ``small``
            "page": In(1),  # of the frame that is repaired and read
            "address": In(counter_shape(taxels - 1)),  # of a code on that page
            "read": In(1),
            "stored": Out(stored_code(bits)),  # the code at ``address``, a cycle after ``read``
            "spoils": In(1),  # the frame of the taxel whose code is written is dropped
            "reached": Out(2),  # of each page: a code reaches ``contact``
            "written": Out(counter_shape(taxels - 1)),  # codes of the frame that comes that can be read
            "settles": Out(1),  # the code of a repair is written a cycle later
        })

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        memory = Ram(m, "memory", stored_code(self._array.adc.bits), 2 << len(self.address))
        m.d.comb += self.stored.eq(memory.read(Cat(self.address, self.page), self.read))
        product, is_term = self._multiply(m, self.stored.code)
        total = self._accumulate(m, product, is_term)
        code = register(m, saturate(total[self._point :].as_signed(), self._array.adc.bits), "code")
        self._store(m, memory, code)
        return m

    def _multiply(self, m: Module, code: Value) -> tuple[Value, Value]:
        """A taxel's deviation times its gain, or a term's weight times ``code``; whether a term is at the multiplier.

        A code is moved up to a word, so that both products have their point at the same place.
        """
        m.submodules.multiplier = multiplier = Multiplier(DEVIATION, GAIN + 1, core_of(self._array).target)
        word = register(m, code, "source") << (WORD - self._array.adc.bits)
        weight = delayed(m, self.term.weight, FETCH, "weight")
        is_term = delayed(m, self.term.valid, FETCH, "is_term", control=True)
        m.d.comb += [
            multiplier.a.eq(Mux(is_term, weight, self.taxel.deviation)),
            multiplier.b.eq(Mux(is_term, word, self.taxel.gain)),
        ]
        return multiplier.product, is_term

    def _accumulate(self, m: Module, product: Value, is_term: Value) -> Value:
        """The sum of a repair's products, or a taxel's product, and a half, which rounds."""
        half = Const(Rounding.HALF_UP.constant(self._point), self._point)
        product_bits = WEIGHT + WORD
        most_terms = repair_places(self._array.sensor.taxels)
        sum_bits = product_bits + most_terms.bit_length()
        adds = delayed(m, is_term, Multiplier.latency, "adds", control=True)
        ends = delayed(m, self.term.end, FETCH + Multiplier.latency, "ends")
        partial = Signal(signed(sum_bits), reset_less=True)
        total = Signal.like(partial)
        result = Signal.like(partial, reset_less=True)
        m.d.comb += total.eq(product + Mux(adds, partial, half))
        m.d.sync += result.eq(total)
        with m.If(adds):
            m.d.sync += partial.eq(Mux(ends, half, total))
        return result

    def _store(self, m: Module, memory: Ram, code: Value) -> None:
        """Write the code of a taxel, or of the target of a repair, and compare it with both thresholds."""
        index = delayed(m, self.taxel.index, self.latency, "index")
        page = delayed(m, self.taxel.page, self.latency, "page")
        first = register(m, delayed(m, self.taxel.index, self.latency - 1) == 0, "first")
        # the taxel of the last end of a repair; no other end comes before its code is written
        target = Signal.like(self.term.target, reset_less=True)
        with m.If(self.term.valid & self.term.end):
            m.d.sync += target.eq(self.term.target)
        is_taxel = delayed(m, self.taxel.valid, self.latency, "taxel", control=True)
        settles = delayed(m, self.term.valid & self.term.writes, FETCH + self.latency - 1, "end", control=True)
        is_repair = register(m, settles, "end", control=True)
        size = register(m, abs(code)[: len(code)], "size")
        stored = Signal.like(self.stored)
        reaches = size >= self.contact
        m.d.comb += [
            self.settles.eq(settles),
            self.written.eq(index),
            stored.code.eq(register(m, code, "code")),
            stored.small.eq(size < self.dead_band),
        ]
        address = Mux(is_repair, Cat(target, self.page), Cat(index, page))
        memory.write(is_taxel | is_repair, address, stored)
        for number, reached in enumerate(self.reached):
            with m.If(is_taxel & (page == number)):
                m.d.sync += reached.eq((reaches | (reached & ~first)) & ~self.spoils)
            with m.If(is_repair & (self.page == number)):
                m.d.sync += reached.eq(reaches | reached)
