"""Contents of the coefficient memories of the matrix-vector unit.

Slot ``s`` of result quad ``i`` stands for the *operand's* parity ``s``, so that a lane never has to choose among
parities: it is coefficient row (i, s ^ flip) of the operator.  Row ``4 i + s`` counts over the operators of a stack;
pass ``t`` of ``L`` lanes computes rows ``t L ... t L + L - 1``, one per lane, and reads for it as many coefficients as
the operand has quads.
"""

from dataclasses import dataclass

import numpy as np

from tfra.hdl.primitives.ecp5 import memories
from tfra.model.arrays import Ints
from tfra.model.fixed.design import Design


def passes(design: Design, stack: str) -> int:
    """Number of passes of one product of ``stack``."""
    return -(-4 * design.stacks[stack].quads // design.architecture.mac_lanes)


def words(design: Design, stack: str) -> int:
    """Coefficients that each lane has for ``stack``: those of all passes of a product."""
    return passes(design, stack) * design.stacks[stack].operand_quads


def longest(design: Design, stack: str) -> int:
    """Bits of the longest coefficients of ``stack``."""
    return max(design.formats.bits(f"coefficient.{op.name}") for op in design.stacks[stack].operators)


def order(design: Design) -> list[str]:
    """Order of the stacks in the memories: longest coefficients first, otherwise as in the design."""
    return sorted(design.stacks, key=lambda name: -longest(design, name))


def bases(design: Design) -> dict[str, int]:
    """Address of every stack's first coefficient; stacks lie one after the other in their :func:`order`."""
    stacks = order(design)
    ends = np.cumsum([0, *(words(design, name) for name in stacks)])
    return {name: int(start) for name, start in zip(stacks, ends, strict=False)}


@dataclass(frozen=True, slots=True)
class Tail:
    """The lowest ``bits`` of a lane's words, stored only below the address ``depth``, because they are zero from there
    on."""

    bits: int
    depth: int


def tail(design: Design) -> Tail:
    """The shortest tail that saves most block memories of 18 kbit; empty if none saves any.

    Block memories are that large in most families, and shallow words of up to 18 bits take half of one in any case.
    """
    tails = []
    for stack in order(design):
        length = longest(design, stack)
        longer = [words(design, name) for name in design.stacks if longest(design, name) > length]
        tails.append(Tail(design.coefficient_word - length, sum(longer)))

    def cost(cut: Tail) -> tuple[int, int]:
        rest = memories(design.coefficient_word - cut.bits, depth(design))
        return rest + memories(cut.bits, cut.depth), cut.bits

    return min(tails, key=cost)


def depth(design: Design) -> int:
    """Words of each lane's memory."""
    return sum(words(design, name) for name in design.stacks)


def lane_images(design: Design) -> Ints:
    """Words ``(L, depth)`` of the lanes' memories in the order in which they are read.

    Rows past the end of a stack are zero.
    """
    return np.concatenate([_stack_image(design, name) for name in order(design)], axis=1)


def low_bits(images: Ints, bits: int) -> Ints:
    """The lowest ``bits`` of all words, as signed words of this length."""
    return ((images + (1 << (bits - 1))) & ((1 << bits) - 1)) - (1 << (bits - 1))


def _stack_image(design: Design, name: str) -> Ints:
    lanes, times, slot = design.architecture.mac_lanes, passes(design, name), np.arange(4)
    quads = design.stacks[name].operand_quads
    rows = np.concatenate([op.rows[:, slot ^ op.flip].reshape(-1, quads) for op in design.stacks[name].operators])
    padded = np.zeros((times * lanes, quads), dtype=np.int64)
    padded[: len(rows)] = rows
    return padded.reshape(times, lanes, quads).swapaxes(0, 1).reshape(lanes, -1)
