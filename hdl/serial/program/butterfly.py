"""Mirror folding of quads, and the movement of pointers through vectors and maps of taxels."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace

from tfra.hdl.serial.isa import R0, R1, R2, R3, R4, R5, Operand, Post, mem
from tfra.hdl.serial.program.routines import Writer

QUAD = R1, R3, R4, R0
"""Registers for the results of :func:`butterfly`: each has been read before it is written."""


def butterfly(w: Writer, sources: Sequence[Operand], targets: Sequence[Operand]) -> None:
    """Four words to their sums and differences; changes R0, R2, R4 and R5.

    Two words are summed and subtracted as they are read, so that the registers suffice.
    """
    a = w.assembler
    for word, total, (first, second) in ((R0, R4, sources[:2]), (R2, R5, sources[2:])):
        a.move(word, first)
        a.add(total, word, replace(second, post=Post.KEEP))
        a.sub(word, word, second)
    _across(w, (R4, R0, R5, R2), targets)


def butterfly_of_difference(w: Writer, sources: Sequence[Operand], distance: int, targets: Sequence[Operand]) -> None:
    """``butterfly`` of four words minus those that lie ``distance`` words after them; changes R0 to R5."""
    a, registers = w.assembler, (R0, R1, R2, R3)
    for register, source in zip(registers, sources, strict=True):
        a.move(register, mem(source.immediate, source.pointer))
        a.sub(register, register, mem(source.immediate + distance, source.pointer, source.post))
    butterfly_of_registers(w, registers, (R4, R5), targets)


def butterfly_of_registers(
    w: Writer, words: Sequence[Operand], free: Sequence[Operand], targets: Sequence[Operand]
) -> None:
    """``butterfly`` of four registers; changes them and the two ``free`` ones."""
    (one, two, three, four), (left, right), a = words, free, w.assembler
    a.add(left, one, two)
    a.sub(one, one, two)
    a.add(right, three, four)
    a.sub(three, three, four)
    _across(w, (left, one, right, three), targets)


def _across(w: Writer, halves: Sequence[Operand], targets: Sequence[Operand]) -> None:
    """Sums and differences of (sum, difference) of the first two words and (sum, difference) of the others."""
    (left_sum, left_difference, right_sum, right_difference), a = halves, w.assembler
    a.add(targets[0], left_sum, right_sum)
    a.add(targets[1], left_difference, right_difference)
    a.sub(targets[2], left_sum, right_sum)
    a.sub(targets[3], left_difference, right_difference)


def quad(vector: int, quads: int, number: int, post: Post = Post.UP) -> list[Operand]:
    """The four parities of the quad at pointer ``number`` of a ``vector`` of ``quads``.

    The pointer moves by ``post`` at the last one.
    """
    return [mem(vector + k * quads, number, post if k == 3 else Post.KEEP) for k in range(4)]


def mirrors() -> list[Operand]:
    """The four mirror taxels at pointers 0 to 3, which move to the next quad of the row."""
    return [mem(0, number, Post.DOWN if number & 1 else Post.UP) for number in range(4)]


@contextmanager
def each_quad(w: Writer, taxels: int) -> Iterator[None]:
    """Run the block for every quad: pointers 0 to 3 at the mirror taxels of a map, pointer 4 at the quad.

    The pointers start at the corners of the row-major map; after a row of quads they move to the next one.
    """
    rows, columns, half = w.design.sensor.rows, w.design.sensor.columns, w.design.quad_columns
    corners = 0, columns - 1, (rows - 1) * columns, rows * columns - 1
    next_row = columns - half, columns + half, -columns - half, half - columns
    w.points(**{f"p{number}": taxels + corner for number, corner in enumerate(corners)}, p4=0)
    with w.assembler.loop(w.design.quad_rows):
        with w.assembler.loop(w.design.quad_columns):
            yield
        for number, by in enumerate(next_row):
            w.assembler.advance(number, by)
