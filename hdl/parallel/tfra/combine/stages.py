"""The tag that goes with each beat of the vector updates from stage to stage."""

from enum import IntEnum

from amaranth import signed
from amaranth.lib import data

from tfra.hdl.parallel.beats import beat_number
from tfra.hdl.parallel.tfra.combine.store import place
from tfra.model.fixed.design import Design


class Job(IntEnum):
    """The result of a beat in the pipeline."""

    E0 = 0
    E1 = 1
    D = 2
    FORCE = 3


def tag_layout(design: Design) -> data.StructLayout:
    """The tag of a beat.

    ``job``: what it becomes; ``place``: that of its frame in the stores; ``number``: its number in the vector;
    ``swap``: the sweep goes along y, so that d2 is d_ind; ``scalar``: the s of ``z + s * x``.
    """
    scalar = signed(design.formats.bits("scalar"))
    return data.StructLayout({"job": Job, "place": place, "number": beat_number(design), "swap": 1, "scalar": scalar})
