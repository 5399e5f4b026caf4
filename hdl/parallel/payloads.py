"""Payloads of the streams between blocks, all from the design's widths."""

from amaranth import Shape, signed, unsigned
from amaranth.lib import data

from tfra.hdl.lib.arithmetic import counter_shape, quad
from tfra.model.fixed.design import Design


def stress_quad(design: Design) -> data.ArrayLayout:
    """Four mirror taxels of the normalised frame."""
    return quad(design.widths.stress)


def vector_quad(design: Design) -> data.ArrayLayout:
    """Four words on the vector grid."""
    return quad(design.widths.vector)


def vector_beat(design: Design) -> data.ArrayLayout:
    """A beat: the words of a quad that move in one cycle, of ``design.cycles_per_quad``."""
    return data.ArrayLayout(signed(design.widths.vector), design.architecture.vector_words)


def operand(design: Design, *marks: str) -> data.StructLayout:
    """A quad of an operand for the matrix-vector unit, and bits that choose its product."""
    return data.StructLayout({"words": vector_quad(design), **dict.fromkeys(marks, 1)})


def product(design: Design) -> data.StructLayout:
    """A quad of results; the one bit set in ``kind`` has its operator's number in ``coefficients.kinds``."""
    return data.StructLayout({"words": vector_quad(design), "kind": len(design.kinds)})


def frame_facts(design: Design) -> data.StructLayout:
    """The fields of :class:`tfra.model.fixed.normaliser.Normalised` other than the stress."""
    return data.StructLayout({
        "exponent": counter_shape(design.adc.bits - 1),
        "magnitude": unsigned(design.widths.magnitude),
        "contact": 1,
        "traction": 1,
        "saturated": 1,
    })


def direction(design: Design) -> data.StructLayout:
    """:class:`tfra.model.fixed.tfra.centroids.Direction`."""
    word = signed(design.formats.bits("direction"))
    return data.StructLayout({"cos": word, "sin": word, "sweep_y": 1, "negative": 1, "vanishing": 1})


def affine(design: Design) -> data.StructLayout:
    """:class:`tfra.model.fixed.tfra.dependent.Dependent`; ``sums`` holds the nine A_pq row by row."""
    scalar, word = signed(design.formats.bits("scalar")), signed(design.formats.bits("sums"))
    return data.StructLayout({
        "alpha": scalar,
        "beta": scalar,
        "vanishing": 1,
        "sums": data.ArrayLayout(word, 9),
        "significant": counter_shape(design.widths.vector - 1),
    })


def chosen(design: Design) -> data.StructLayout:
    """:class:`tfra.model.fixed.tfra.friction.Friction`."""
    word, index = signed(design.formats.bits("scalar")), sweep_index(design)
    return data.StructLayout({"index": index, "mu_ind": word, "mu_x": word, "mu_y": word, "out_of_range": 1})


def sweep_index(design: Design) -> Shape:
    """A candidate's number, 0 ... K."""
    return counter_shape(design.search.steps)


def total(design: Design) -> data.StructLayout:
    """:class:`tfra.model.fixed.gain.Resultant`."""
    w = design.widths
    return data.StructLayout({"words": data.ArrayLayout(signed(w.division), 3), "exponent": signed(9)})


def gain(design: Design) -> data.StructLayout:
    """:class:`tfra.model.fixed.gain.Gain`."""
    scalar = design.formats.bits("scalar")
    return data.StructLayout({
        "mantissa": unsigned(scalar),
        "force_shift": unsigned(7),
        "resultant_shift": unsigned(7),
        "mu": signed(scalar),
        "overflow": 1,
    })
