"""How much memory a core's coefficients take, and which form of the operators takes less (docs/studies/memory.md)."""

from __future__ import annotations

from dataclasses import replace
from typing import get_args

from tfra.hdl.parallel.matvec.images import depth
from tfra.model.design import Design, Form

BLOCK = 1024
"""Words of a block memory: 18 kbit as DP16KD of ECP5 or half a RAMB36E1 of 7-series has, 18 bits wide."""


def blocks(design: Design) -> int:
    """Block memories of all lanes; a lane's are its own."""
    return design.architecture.mac_lanes * -(-depth(design) // BLOCK)


def economical(design: Design) -> Design:
    """``design`` with the form that fills fewer block memories; ``pinv``, which is faster, if both fill as many.

    A design with sparse operators is returned as it is: it can only store A-dagger.
    """
    if design.sparse:
        return design
    return min((replace(design, operators=form) for form in get_args(Form)), key=blocks)
