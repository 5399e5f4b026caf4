"""Parts of vectors: the ``vector_words`` words of a quad that are handled in a cycle."""

from __future__ import annotations

from typing import Any

from amaranth import Cat, Module, Shape, Signal, Value

from tfra.hdl.lib.arithmetic import counter_shape, nth_part
from tfra.model.fixed.design import Design


def part_number(design: Design) -> Shape:
    """Number of a part of a vector: of the quad, above that of the part in its quad."""
    return counter_shape(design.quads * design.cycles_per_quad - 1)


def pick_part(design: Design, words: Any, number: Value) -> Value:
    """The words of a quad, or of anything with four parities, that part ``number`` of a vector is about."""
    return nth_part(Cat(words[k] for k in range(4)), in_quad(design, number), design.cycles_per_quad)


def in_quad(design: Design, number: Value) -> Value:
    """Which part of its quad part ``number`` of a vector is."""
    return number[: (design.cycles_per_quad - 1).bit_length()]


def in_parts(m: Module, valid: Value, ends: Value) -> Value:
    """High while a quad of a flow is handled: from ``valid`` to the part that ``ends`` it."""
    step, pending = Signal(), Signal()
    m.d.comb += step.eq(valid | pending)
    m.d.sync += pending.eq(step & ~ends)
    return step
