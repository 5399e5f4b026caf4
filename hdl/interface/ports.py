"""Payloads of a core's ports, for every microarchitecture."""

from amaranth import Shape, signed
from amaranth.lib import data

from tfra.model.fixed.design import Design
from tfra.model.skin.records import result_shape
from tfra.model.skin.skin import Skin


def taxel(design: Design) -> Shape:
    """A converter code."""
    return signed(design.widths.stress)


def result(array: Design | Skin) -> data.StructLayout:
    """One word of a result frame, or of a record of a skin; ``last`` marks its end."""
    _, bits = result_shape(array)
    return data.StructLayout({"data": signed(bits), "last": 1})
