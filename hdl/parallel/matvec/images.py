"""What the coefficient memories of the matrix-vector unit hold.

Slot ``s`` of result quad ``i`` stands for the *operand's* parity ``s``, so that a lane never has to choose among
parities: it is coefficient row (i, s ^ flip) of the operator.  Row ``4 i + s`` counts over the operators of a stack;
pass ``t`` of ``L`` lanes computes rows ``t L ... t L + L - 1``, one per lane, and reads Q coefficients for it.
"""

from __future__ import annotations

import numpy as np

from tfra.model.arrays import Ints
from tfra.model.fixed.design import Design


def passes(design: Design, stack: str) -> int:
    """Times the operand runs past the lanes for one product of ``stack``."""
    return -(-4 * design.stacks[stack].quads // design.architecture.mac_lanes)


def bases(design: Design) -> dict[str, int]:
    """Address of every stack's first coefficient; stacks lie one behind the other in the order of the design."""
    ends = np.cumsum([0, *(passes(design, name) * design.quads for name in design.stacks)])
    return {name: int(start) for name, start in zip(design.stacks, ends, strict=False)}


def depth(design: Design) -> int:
    """Words of each lane's memory."""
    return design.quads * sum(passes(design, name) for name in design.stacks)


def lane_images(design: Design) -> Ints:
    """Words ``(L, depth)`` of the lanes' memories in the order in which they are read.

    Rows past the end of a stack are zero.
    """
    return np.concatenate([_stack_image(design, name) for name in design.stacks], axis=1)


def _stack_image(design: Design, name: str) -> Ints:
    lanes, times, slot = design.architecture.mac_lanes, passes(design, name), np.arange(4)
    rows = np.concatenate(
        [op.rows[:, slot ^ op.flip].reshape(-1, design.quads) for op in design.stacks[name].operators]
    )
    padded = np.zeros((times * lanes, design.quads), dtype=np.int64)
    padded[: len(rows)] = rows
    return padded.reshape(times, lanes, design.quads).swapaxes(0, 1).reshape(lanes, -1)
