"""A vector of each frame in flight, read a word at a time, with the headroom of its parities.

Its words are no longer than those of p, by the bounds of :mod:`tfra.model.fixed.learned.bounds`.
"""

from typing import Any

from amaranth import Array, Cat, Module, Mux, Signal, Value
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.arithmetic import counter_shape, magnitude_bits
from tfra.hdl.lib.pipeline import READ, delayed, register, registered_zeros, wrapping_counter
from tfra.hdl.lib.ram import Ram
from tfra.hdl.lib.streams import always_ready_stream
from tfra.hdl.parallel.learned.payloads import taxel_quad
from tfra.hdl.parallel.learned.plan import FRAMES
from tfra.model.fixed.learned.design import LearnedDesign

MEASURE = 3
"""Cycles from a vector's last quad to its headroom being written: magnitudes, two halves of the zeros."""

WORD = READ + 1
"""Cycles from an address to its word."""


class Vectors(wiring.Component):
    """A vector of each of ``FRAMES`` frames, and the headroom of its parities, read a word at a time."""

    def __init__(self, design: LearnedDesign, *, headroom: bool) -> None:
        self._design, self._headroom = design, headroom
        vector = taxel_quad(design)
        super().__init__({
            "write": In(always_ready_stream(vector)),  # quads of the vectors, frame by frame
            "place": In(counter_shape(FRAMES - 1)),  # frame of the word that is read
            "quad": In(counter_shape(design.quads - 1)),  # its quad
            "parity": In(2),  # its place in the quad
            "word": Out(vector.elem_shape),  # the word, ``WORD`` cycles later
            # Of its parity, beside it; zero where it is not asked for.
            "headroom": Out(counter_shape(design.widths.force - 1)),
            "complete": Out(1),  # pulse: a vector and its headroom may be read two cycles later
        })

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        quads, shape = self._design.quads, self.write.payload.shape()
        words = Ram(m, "words", shape, FRAMES << len(self.quad))
        number, last = wrapping_counter(m, self.write.valid, quads, "number")
        ends = self.write.valid & last
        place, _ = wrapping_counter(m, ends, FRAMES, "write_place")
        words.write(self.write.valid, Cat(number, place), self.write.payload)
        stored = data.View(shape, register(m, words.read(Cat(self.quad, self.place)).as_value(), "stored"))
        m.d.comb += self.complete.eq(delayed(m, ends, MEASURE - 1, "ends", control=True))
        parity = delayed(m, self.parity, READ, "parity")
        m.d.comb += self.word.eq(register(m, Array(stored[k] for k in range(4))[parity], "word"))
        if self._headroom:
            self._measure(m, number == 0, ends, place)
        return m

    def _measure(self, m: Module, first: Value, ends: Value, place: Value) -> None:
        """OR of the magnitudes of each parity while a vector is written; its zeros when it is complete."""
        shape = data.ArrayLayout(self.headroom.shape(), 4)
        headrooms = Ram(m, "headrooms", shape, FRAMES)
        zeros = []
        for parity, word in enumerate(self.write.p):
            mask = Signal(len(word) - 1, name=f"mask{parity}", reset_less=True)
            with m.If(self.write.valid):
                m.d.sync += mask.eq(Mux(first, 0, mask) | magnitude_bits(word))
            zeros.append(register(m, registered_zeros(m, mask), f"zeros{parity}"))
        measured = delayed(m, ends, MEASURE, "measured", control=True)
        headrooms.write(measured, delayed(m, place, MEASURE, "measured_place"), Cat(zeros))
        stored = data.View(shape, register(m, headrooms.read(self.place).as_value(), "stored_headroom"))
        parity = delayed(m, self.parity, READ, "headroom_parity")
        m.d.comb += self.headroom.eq(register(m, Array(stored[k] for k in range(4))[parity], "headroom"))
