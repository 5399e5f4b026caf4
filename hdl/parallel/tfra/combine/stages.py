"""Stages of the pipeline of the vector updates, and the tag that goes with each beat from stage to stage."""

from __future__ import annotations

from enum import IntEnum
from typing import Any

from amaranth import Module, signed
from amaranth.lib import data

from tfra.hdl.lib.pipeline import READ, register
from tfra.hdl.parallel.beats import beat_number
from tfra.hdl.parallel.tfra.combine.store import place
from tfra.model.fixed.design import Design


class Job(IntEnum):
    """The result of a beat in the pipeline."""

    E0 = 0
    E1 = 1
    D = 2
    FORCE = 3


class Stage(IntEnum):
    """Cycles from a beat's entry, by what the registers of the two operands of ``z + s * x`` hold then.

    ::

        s * x:  ENTRY   X_ADDRESS   X_CELL   X_READ   X_CHOSEN   COARSE   ALIGNED   ROUNDED
                OPERAND     PRODUCT   CUT      COARSE_BACK   SHIFTED                 SUM   OUTPUT
        z:      Z_ADDRESS   Z_CELL    Z_READ   Z_CHOSEN      Z                       SUM   OUTPUT

    z is read as late as its product allows, to reach the adder in the same cycle.
    """

    ENTRY = 0
    X_ADDRESS = 1
    X_CELL = 2
    X_READ = X_ADDRESS + READ
    X_CHOSEN = 4
    COARSE = 5
    ALIGNED = 6
    ROUNDED = 7
    OPERAND = 8
    PRODUCT = 9
    CUT = 10
    COARSE_BACK = 11
    SHIFTED = 12
    SUM = 13
    OUTPUT = 14

    Z = SHIFTED
    Z_CHOSEN = Z - 1
    Z_READ = Z_CHOSEN - 1
    Z_CELL = Z_READ - 1
    Z_ADDRESS = Z_READ - READ


def tag_layout(design: Design) -> data.StructLayout:
    """The tag of a beat.

    ``job``: what it becomes; ``place``: that of its frame in the stores; ``number``: its number in the vector;
    ``swap``: the sweep goes along y, so that d2 is d_ind; ``scalar``: the s of ``z + s * x``.
    """
    scalar = signed(design.formats.bits("scalar"))
    return data.StructLayout({"job": Job, "place": place, "number": beat_number(design), "swap": 1, "scalar": scalar})


def staged(m: Module, value: Any, first: Stage, last: Stage, name: str, *, control: bool = False) -> dict[Stage, Any]:
    """``value`` of a beat in stage ``first``, delayed with that beat through every stage up to ``last``."""
    found = {first: value}
    for stage in (Stage(number) for number in range(first + 1, last + 1)):
        value = found[stage] = register(m, value, f"{name}_{stage.name.lower()}", control=control)
    return found
