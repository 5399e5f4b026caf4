"""Payloads of a core's ports, for every microarchitecture."""

from amaranth import Shape, signed
from amaranth.lib import data

from tfra.model.fixed.design import Design


def taxel(design: Design) -> Shape:
    """A converter code."""
    return signed(design.widths.stress)


def result(design: Design) -> data.StructLayout:
    """One word of a result frame; ``last`` marks its end."""
    return data.StructLayout({"data": signed(design.word_bits), "last": 1})
