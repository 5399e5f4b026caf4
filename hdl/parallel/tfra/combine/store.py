"""What the vector updates work on, frame by frame: memories of several frames, and the headroom of their words."""

from __future__ import annotations

from typing import Any

from amaranth import Cat, Module, Mux, Signal, Value
from amaranth.lib import data, memory, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.arithmetic import counter_shape, magnitude_bits
from tfra.hdl.lib.pipeline import delayed, occupancy, register, wrapping_counter, zeros_later
from tfra.hdl.parallel.beats import beat_in_quad, beat_number
from tfra.hdl.parallel.payloads import vector_beat
from tfra.model.fixed.design import Design

FRAMES = 4
"""Frames in flight between the contact product and the force product; memories have a place for each."""

MEASURE = 4
"""Cycles from the last part of a vector to its headroom being written: magnitudes, their OR, two halves of the zeros.
It can be read in that cycle."""

place = counter_shape(FRAMES - 1)
"""Number of a frame's place."""


def headrooms(design: Design, words: int) -> data.ArrayLayout:
    """Bits that so many parities of a vector leave free."""
    return data.ArrayLayout(counter_shape(design.widths.vector - 1), words)


class Store(wiring.Component):
    """A memory of vectors: ``FRAMES`` places of ``vectors`` vectors each, written and read a part at a time.

    Arguments:
        vectors: vectors of a place.
        headroom: whether the headroom of the vectors is found as they are written, for use as multiplier operands.

    Members:
        write, write_place, write_vector, write_number, words: a part is written.
        read_place, read_vector, read_number: what is read in every cycle; ``part`` and ``room`` follow ``READ`` cycles
            later.

    A part can be read in the cycle after it was written, the headroom two cycles after its last part.
    """

    def __init__(self, design: Design, vectors: int = 1, *, headroom: bool = False) -> None:
        self._design, self._vectors, self._headroom = design, vectors, headroom
        number, vector = beat_number(design), counter_shape(vectors - 1)
        super().__init__(
            {
                "write": In(1),
                "write_place": In(place),
                "write_vector": In(vector),
                "write_number": In(number),
                "words": In(vector_beat(design)),
                "read_place": In(place),
                "read_vector": In(vector),
                "read_number": In(number),
                "part": Out(vector_beat(design)),
                "room": Out(headrooms(design, design.architecture.vector_words)),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        depth = FRAMES * self._vectors << len(self.write_number)
        m.submodules.words = words = memory.Memory(shape=self.words.shape(), depth=depth, init=[])
        write, read = words.write_port(), words.read_port()
        m.d.comb += [
            write.en.eq(self.write),
            write.addr.eq(Cat(self.write_number, self._slot(self.write_vector, self.write_place))),
            write.data.eq(self.words),
            read.addr.eq(Cat(self.read_number, self._slot(self.read_vector, self.read_place))),
        ]
        m.d.comb += self.part.eq(register(m, read.data.as_value(), "part"))
        if self._headroom:
            self._measure(m)
        return m

    def _slot(self, vector: Value, at: Value) -> Value:
        """Where a vector of a place lies; the only one of a place has no number."""
        return Cat(at, vector) if self._vectors > 1 else at

    def _measure(self, m: Module) -> None:
        """OR of magnitudes while a vector is written, zeros behind the parts of its last quad.

        Masks go round with the parts of a quad, so that those of the part at hand are always in the same place.
        """
        design, size, length = self._design, self._design.architecture.vector_words, self._design.widths.vector - 1
        in_place = beat_in_quad(design, self.write_number)
        depth = FRAMES * self._vectors * design.cycles_per_quad
        m.submodules.rooms = rooms = memory.Memory(shape=headrooms(design, size), depth=depth, init=[])
        write = rooms.write_port()
        read = rooms.read_port(transparent_for=[write])  # a vector is used as soon as it is there
        masks = Signal(4 * length, reset_less=True)
        latest = Signal(size * length)
        first = register(m, self.write_number < design.cycles_per_quad)
        for k in range(size):
            before = Mux(first, 0, masks.word_select(k, length))
            m.d.comb += latest.word_select(k, length).eq(before | register(m, magnitude_bits(self.words[k])))
        with m.If(register(m, self.write, control=True)):
            m.d.sync += masks.eq(Cat(masks, latest)[len(latest) :])
        ends = self.write & (self.write_number >= (design.quads - 1) * design.cycles_per_quad)
        m.d.comb += write.en.eq(delayed(m, ends, MEASURE, "ends", control=True))
        m.d.comb += write.addr.eq(delayed(m, Cat(in_place, self._slot(self.write_vector, self.write_place)), MEASURE))
        for k in range(size):
            m.d.comb += write.data[k].eq(register(m, zeros_later(m, masks.word_select(4 - size + k, length))))
        m.d.comb += [
            read.addr.eq(Cat(beat_in_quad(design, self.read_number), self._slot(self.read_vector, self.read_place))),
            self.room.eq(register(m, read.data.as_value(), "room")),
        ]


class Level(wiring.Component):
    """Frames between two points of the data path, by their place: ``tail`` leaves next.

    Members: ``enter``, ``leave``: pulses; ``some``: a frame is between them.
    """

    def __init__(self) -> None:
        super().__init__({"enter": In(1), "leave": In(1), "tail": Out(place), "some": Out(1)})

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        taken = occupancy(m, FRAMES, self.enter, self.leave)
        tail, _ = wrapping_counter(m, self.leave, FRAMES, "left")
        m.d.comb += [self.tail.eq(tail), self.some.eq(taken[0])]
        return m
