"""A vector of each frame in flight, read a word at a time, with the headroom of its parities.

Its words are no longer than those of p, by the bounds of :mod:`tfra.model.fixed.learned.bounds`.
"""

from typing import Any

from amaranth import Array, Cat, Module, Mux, Signal, Value
from amaranth.lib import data

from tfra.hdl.lib.arithmetic import counter_shape, magnitude_bits
from tfra.hdl.lib.pipeline import READ, delayed, register, registered_zeros, wrapping_counter
from tfra.hdl.lib.ram import Ram
from tfra.hdl.parallel.learned.plan import FRAMES
from tfra.model.fixed.learned.design import LearnedDesign

MEASURE = 3
"""Cycles from a vector's last quad to its headroom being written: magnitudes, two halves of the zeros."""

WORD = READ + 1
"""Cycles from an address to its word."""


class Vectors:
    """A part of the module ``m``: the vector of each of ``FRAMES`` frames, and the headroom of its parities.

    The stream ``write`` has their quads, frame by frame.  A word is read at the ``place`` of its frame, its ``quad``
    and its ``parity``, its place in the quad.
    """

    def __init__(self, m: Module, design: LearnedDesign, write: Any, name: str, *, headroom: bool) -> None:
        self._write = write
        self.place = Signal(counter_shape(FRAMES - 1))
        self.quad = Signal(counter_shape(design.quads - 1))
        self.parity = Signal(2)
        shape = write.payload.shape()
        words = Ram(m, f"{name}_words", shape, FRAMES << len(self.quad))
        number, last = wrapping_counter(m, write.valid, design.quads, "number")
        ends = write.valid & last
        place, _ = wrapping_counter(m, ends, FRAMES, "write_place")
        words.write(write.valid, Cat(number, place), write.payload)
        stored = data.View(shape, register(m, words.read(Cat(self.quad, self.place)).as_value(), "stored"))
        parity = delayed(m, self.parity, READ, "parity")
        self.word = register(m, Array(stored[k] for k in range(4))[parity], "word")
        """The word, ``WORD`` cycles later."""
        self.complete = delayed(m, ends, MEASURE - 1, "ends", control=True)
        """Pulse: a vector and its headroom may be read two cycles later."""
        self.headroom = self._measure(m, number == 0, ends, place, name) if headroom else None
        """That of the word's parity, beside it."""

    def _measure(self, m: Module, first: Value, ends: Value, place: Value, name: str) -> Value:
        """OR of the magnitudes of each parity while a vector is written; its zeros when it is complete."""
        words = self._write.payload
        shape = data.ArrayLayout(counter_shape(len(words[0]) - 1), 4)
        headrooms = Ram(m, f"{name}_headrooms", shape, FRAMES)
        zeros = []
        for parity, word in enumerate(words):
            mask = Signal(len(word) - 1, name=f"mask{parity}", reset_less=True)
            with m.If(self._write.valid):
                m.d.sync += mask.eq(Mux(first, 0, mask) | magnitude_bits(word))
            zeros.append(register(m, registered_zeros(m, mask), f"zeros{parity}"))
        measured = delayed(m, ends, MEASURE, "measured", control=True)
        headrooms.write(measured, delayed(m, place, MEASURE, "measured_place"), Cat(zeros))
        stored = data.View(shape, register(m, headrooms.read(self.place).as_value(), "stored_headroom"))
        parity = delayed(m, self.parity, READ, "headroom_parity")
        return register(m, Array(stored[k] for k in range(4))[parity], "headroom")
