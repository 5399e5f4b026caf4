"""What the vector updates work on, frame by frame: memories of several frames, and the headroom of their words."""

from __future__ import annotations

from typing import Any

from amaranth import Cat, Module, Mux, Signal, Value
from amaranth.lib import data, memory, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.arithmetic import count, leading_zeros, magnitude_bits
from tfra.hdl.payloads import vector_quad
from tfra.hdl.pipeline import register
from tfra.model.design import Design
from tfra.model.fixed.widths import widths

FRAMES = 4
"""Frames in flight between the contact product and the force product; memories have a place for each."""

place = count(FRAMES - 1)
"""Number of a frame's place."""


def headroom_quad(design: Design) -> data.ArrayLayout:
    """Bits that the four parities of a vector leave free."""
    return data.ArrayLayout(count(widths(design).vector - 1), 4)


class Store(wiring.Component):
    """A memory of vectors: ``FRAMES`` places of ``vectors`` vectors each.

    Arguments:
        vectors: vectors of a place, a power of two.
        headroom: whether the headroom of the vectors is found as they are written, for use as multiplier operands.

    Members:
        write, write_place, write_vector, write_number, words: a quad is written.
        read, read_place, read_vector, read_number: a quad is read; ``quad`` and ``room`` follow ``READ`` of the cycles
            in which ``read`` is high later.

    A quad can be read in the cycle after it was written, so can the headroom with its last quad.
    """

    def __init__(self, design: Design, vectors: int = 1, *, headroom: bool = False) -> None:
        self._design, self._vectors, self._headroom = design, vectors, headroom
        number, vector = count(design.quads - 1), count(vectors - 1)
        super().__init__(
            {
                "write": In(1),
                "write_place": In(place),
                "write_vector": In(vector),
                "write_number": In(number),
                "words": In(vector_quad(design)),
                "read": In(1),
                "read_place": In(place),
                "read_vector": In(vector),
                "read_number": In(number),
                "quad": Out(vector_quad(design)),
                "room": Out(headroom_quad(design)),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        quads = FRAMES * self._vectors << len(self.write_number)
        m.submodules.words = words = memory.Memory(shape=self.words.shape(), depth=quads, init=[])
        write, read = words.write_port(), words.read_port()
        m.d.comb += [
            write.en.eq(self.write),
            write.addr.eq(Cat(self.write_number, self._slot(self.write_vector, self.write_place))),
            write.data.eq(self.words),
            read.en.eq(self.read),
            read.addr.eq(Cat(self.read_number, self._slot(self.read_vector, self.read_place))),
        ]
        with m.If(self.read):
            quad = register(m, read.data.as_value(), "quad")
        m.d.comb += self.quad.eq(quad)
        if self._headroom:
            self._measure(m)
        return m

    def _slot(self, vector: Value, at: Value) -> Value:
        """Where a vector of a place lies; the only one of a place has no number."""
        return Cat(vector, at) if self._vectors > 1 else at

    def _measure(self, m: Module) -> None:
        """OR of magnitudes while a vector is written, zeros behind its last quad."""
        shape, bits = headroom_quad(self._design), widths(self._design).vector - 1
        m.submodules.rooms = rooms = memory.Memory(shape=shape, depth=FRAMES * self._vectors, init=[])
        write = rooms.write_port()
        read = rooms.read_port(transparent_for=[write])  # a vector is used as soon as it is there
        masks = Signal(data.ArrayLayout(bits, 4), reset_less=True)
        with m.If(self.write):
            for k in range(4):
                before = Mux(self.write_number == 0, 0, masks[k])
                m.d.sync += masks[k].eq(before | magnitude_bits(self.words[k]))
        m.d.sync += [
            write.en.eq(self.write & (self.write_number == self._design.quads - 1)),
            write.addr.eq(self._slot(self.write_vector, self.write_place)),
        ]
        m.d.comb += [
            *(write.data[k].eq(leading_zeros(masks[k])) for k in range(4)),
            read.en.eq(self.read),
            read.addr.eq(self._slot(self.read_vector, self.read_place)),
        ]
        with m.If(self.read):
            room = register(m, read.data.as_value(), "room")
        m.d.comb += self.room.eq(room)


class Level(wiring.Component):
    """Frames between two points of the data path, by their place: ``head`` enters next, ``tail`` leaves next.

    Members: ``enter``, ``leave``: pulses; ``some``, ``space``: a frame is between them, another one may enter.
    """

    def __init__(self) -> None:
        pulses = {"enter": In(1), "leave": In(1)}
        super().__init__(pulses | {"head": Out(place), "tail": Out(place), "some": Out(1), "space": Out(1)})

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        level = Signal(range(FRAMES + 1))
        m.d.sync += [
            level.eq(level + self.enter - self.leave),
            self.head.eq(self.head + self.enter),
            self.tail.eq(self.tail + self.leave),
        ]
        m.d.comb += [self.some.eq(level != 0), self.space.eq(level != FRAMES)]
        return m
