"""Payloads of the streams around a core."""

from amaranth.lib import data

from tfra.hdl.bus.map import BITS
from tfra.hdl.front_end.ports import NUMBER
from tfra.model.fixed.front_end import WORD

OUTPUT_BEAT = data.StructLayout({"data": BITS, "user": 1, "last": 1})
"""A beat of an output frame; ``user`` in its last one: a reset cut the frame."""

RESULT_BEAT = data.StructLayout({"data": BITS, "last": 1, "started": BITS})
"""A beat of an output frame, and the time of the first taxel of its input frame."""


def input_beat(taxels: int) -> data.StructLayout:
    """``taxels`` of an input frame, the first one lowest; ``last`` ends the frame, ``user`` is then its number."""
    return data.StructLayout({"words": data.ArrayLayout(WORD, taxels), "user": NUMBER, "last": 1})
