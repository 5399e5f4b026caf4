"""Memories of the vector updates: beats of several frames, and the headroom of their words; tags of the beats."""

from enum import IntEnum
from typing import Any

from amaranth import Cat, Module, Mux, Signal, Value, signed
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.arithmetic import counter_shape, magnitude_bits
from tfra.hdl.lib.pipeline import delayed, register, registered_zeros
from tfra.hdl.lib.ram import Ram
from tfra.hdl.parallel.beats import beat_in_quad, beat_number
from tfra.hdl.parallel.payloads import vector_beat
from tfra.hdl.parallel.scale_add import beat_headroom
from tfra.model.fixed.design import Design

FRAMES = 4
"""Frames in flight between the contact product and the force product; memories have a place for each."""

MEASURE = 4
"""Cycles from the last beat of a vector to its headroom being written: magnitudes, their OR, two halves of the zeros.
It can be read in that cycle."""

place = counter_shape(FRAMES - 1)
"""Number of a frame's place."""


class Job(IntEnum):
    """The result of a beat in the pipeline."""

    E0 = 0
    E1 = 1
    D = 2
    FORCE = 3


def tag_layout(design: Design) -> data.StructLayout:
    """The tag that goes with a beat from stage to stage.

    ``job``: what it becomes; ``place``: that of its frame in the stores; ``number``: its number in the vector;
    ``swap``: the sweep goes along y, so that d2 is d_ind; ``scalar``: the s of ``z + s * x``.
    """
    scalar = signed(design.formats.bits("scalar"))
    return data.StructLayout({"job": Job, "place": place, "number": beat_number(design), "swap": 1, "scalar": scalar})


def store_address(design: Design, vectors: int = 1) -> wiring.Signature:
    """Address of a beat: the place of its frame, its vector of that frame, its number in that vector."""
    return wiring.Signature(
        {"place": Out(place), "vector": Out(counter_shape(vectors - 1)), "number": Out(beat_number(design))}
    )


class Store(wiring.Component):
    """A memory of vectors: ``FRAMES`` places of ``vectors`` vectors each, written and read a beat at a time.

    A beat can be read in the cycle after it was written, the headroom ``MEASURE`` cycles after the vector's last beat.

    Arguments:
        vectors: vectors of a place.
        headroom: whether the headroom of the vectors is determined as they are written, for use as multiplier operands.
    """

    def __init__(self, design: Design, vectors: int = 1, *, headroom: bool = False) -> None:
        self._design, self._vectors, self._headroom = design, vectors, headroom
        super().__init__({
            "write": In(wiring.Signature({  # a beat to be written, while ``valid``
                **store_address(design, vectors).members,
                "valid": Out(1),
                "words": Out(vector_beat(design)),
            })),
            "read": In(store_address(design, vectors)),  # address of the beat that is read, in every cycle
            "beat": Out(vector_beat(design)),  # the beat that was read, ``READ`` cycles later
            # That of the words of ``beat``, beside it; zero where it is not asked for.
            "headroom": Out(beat_headroom(design.widths.vector, design.architecture.vector_words)),
        })

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        depth = FRAMES * self._vectors << len(self.write.number)
        words = Ram(m, "words", self.write.words.shape(), depth)
        words.write(self.write.valid, Cat(self.write.number, self._vector_address(self.write)), self.write.words)
        beat = words.read(Cat(self.read.number, self._vector_address(self.read)))
        m.d.comb += self.beat.eq(register(m, beat.as_value(), "beat"))
        if self._headroom:
            self._store_headroom(m, self._zeros(m, self._masks(m)))
        return m

    def read_at(self, m: Module, tag: Any) -> None:
        """Read the beat that ``tag`` names, of a vector that the caller chooses if there are several."""
        m.d.comb += self.read.place.eq(tag.place)
        m.d.comb += self.read.number.eq(tag.number)

    def _vector_address(self, port: Any) -> Value:
        """Start address of a vector; a single vector of a place has no number."""
        return Cat(port.place, port.vector) if self._vectors > 1 else port.place

    def _masks(self, m: Module) -> Value:
        """OR of the magnitudes of each parity while a vector is written, two cycles after its words.

        Masks rotate with the beats of a quad, so those of the current beat are always at the bottom, and those of the
        beat before at the top.
        """
        size, length = self._design.architecture.vector_words, self._design.widths.vector - 1
        masks = Signal(4 * length, reset_less=True)
        latest = Signal(size * length)
        first_quad = register(m, self.write.number < self._design.cycles_per_quad, "first_quad")
        for k in range(size):
            before = Mux(first_quad, 0, masks.word_select(k, length))
            magnitude = register(m, magnitude_bits(self.write.words[k]), f"magnitude{k}")
            m.d.comb += latest.word_select(k, length).eq(before | magnitude)
        with m.If(register(m, self.write.valid, "written", control=True)):
            m.d.sync += masks.eq(Cat(masks, latest)[len(latest) :])
        return masks

    def _zeros(self, m: Module, masks: Value) -> list[Value]:
        """Leading zeros of the masks of the beat before, two cycles later."""
        size, length = self._design.architecture.vector_words, self._design.widths.vector - 1
        parities = [masks.word_select(4 - size + k, length) for k in range(size)]
        return [register(m, registered_zeros(m, mask), f"headroom{k}") for k, mask in enumerate(parities)]

    def _store_headroom(self, m: Module, zeros: list[Value]) -> None:
        """Memory of the headroom, written with the beats of a vector's last quad."""
        design = self._design
        depth = FRAMES * self._vectors * design.cycles_per_quad
        shape = beat_headroom(design.widths.vector, design.architecture.vector_words)
        headrooms = Ram(m, "headrooms", shape, depth)
        write_address, read_address = (
            Cat(beat_in_quad(design, port.number), self._vector_address(port)) for port in (self.write, self.read)
        )
        ends = self.write.valid & (self.write.number >= (design.quads - 1) * design.cycles_per_quad)
        measured = delayed(m, ends, MEASURE, "ends", control=True)
        headrooms.write(measured, delayed(m, write_address, MEASURE, "write_address"), Cat(zeros))
        headroom = headrooms.read(read_address, transparent=True)  # a vector is used as soon as it is complete
        m.d.comb += self.headroom.eq(register(m, headroom.as_value(), "headroom"))
