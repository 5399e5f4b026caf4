"""Beats: the ``vector_words`` words of a quad that move in one cycle.

A quad is ``design.cycles_per_quad`` beats, a vector is Q quads.  Streams carry whole quads: a transfer is the cycle
of a quad's first beat, and the payload stands until the cycle of its last one.
"""

from typing import Any

from amaranth import Cat, Module, Shape, Signal, Value

from tfra.hdl.lib.arithmetic import counter_shape, nth_slice
from tfra.hdl.lib.pipeline import wrapping_counter
from tfra.model.fixed.design import Design


def beat_number(design: Design) -> Shape:
    """Number of a beat in its vector: the number of the quad, above that of the beat in its quad."""
    return counter_shape(design.quads * design.cycles_per_quad - 1)


def beat_in_quad(design: Design, number: Value) -> Value:
    """Number in its quad of beat ``number`` of a vector."""
    return number[: (design.cycles_per_quad - 1).bit_length()]


def select_beat(design: Design, quad: Any, number: Value) -> Value:
    """Words of beat ``number`` of a vector, from its ``quad`` or another value with a member for each parity."""
    return nth_slice(Cat(quad[k] for k in range(4)), beat_in_quad(design, number), design.cycles_per_quad)


def beat_valid(m: Module, quad_valid: Value, ends_quad: Value) -> Value:
    """High in the cycles of a quad's beats: from its transfer ``quad_valid`` to the beat that ``ends_quad``."""
    valid = Signal(name="beat_valid")
    pending = Signal(name="beats_pending")
    m.d.comb += valid.eq(quad_valid | pending)
    m.d.sync += pending.eq(valid & ~ends_quad)
    return valid


def vector_beats(m: Module, design: Design, quad_valid: Value) -> tuple[Value, Value, Value]:
    """Beats of vectors whose quads arrive with ``quad_valid``: beat valid, its number, end of its vector."""
    valid = Signal(name="valid")
    number, last = wrapping_counter(m, valid, design.quads * design.cycles_per_quad, "beat")
    m.d.comb += valid.eq(beat_valid(m, quad_valid, beat_in_quad(design, number) == design.cycles_per_quad - 1))
    return valid, number, valid & last
