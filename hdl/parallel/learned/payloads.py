"""Payloads of the learned estimator's streams."""

from amaranth import signed, unsigned
from amaranth.lib import data

from tfra.hdl.lib.arithmetic import counter_shape, quad
from tfra.hdl.parallel import payloads
from tfra.model.fixed.cordic import iterations
from tfra.model.fixed.learned.bounds import total_bits
from tfra.model.fixed.learned.design import LearnedDesign


def judged(design: LearnedDesign) -> data.StructLayout:
    """:class:`tfra.model.fixed.learned.resultant.Judged`."""
    word = signed(design.widths.output)
    return data.StructLayout({"words": data.ArrayLayout(word, 3), "uncertainty": word, "limited": 1, "implausible": 1})


def angle(design: LearnedDesign) -> data.StructLayout:
    """:class:`tfra.model.fixed.learned.friction.Angle` without the modulus."""
    return data.StructLayout({"phi": unsigned(iterations(design)), "still": 1})


def friction(design: LearnedDesign) -> data.StructLayout:
    """:class:`tfra.model.fixed.learned.friction.Friction`."""
    word = signed(design.formats.bits("scalar"))
    return data.StructLayout({"mu": word, "mu_x": word, "mu_y": word, "overflow": 1})


def header(design: LearnedDesign) -> data.StructLayout:
    """What is known of a frame before its forces at the taxels."""
    return data.StructLayout({"judged": judged(design), "angle": angle(design), "friction": friction(design)})


def contact(design: LearnedDesign) -> data.StructLayout:
    """What the forces at the taxels need: the resultant, and the friction in the field."""
    word = signed(design.formats.bits("scalar"))
    return data.StructLayout({"total": payloads.total(design), "mu_x": word, "mu_y": word})


def taxel_quad(design: LearnedDesign) -> data.ArrayLayout:
    """p of four mirror taxels."""
    return quad(design.widths.force)


def most_shift(design: LearnedDesign) -> int:
    """Most right shifts of a product of p and a mantissa."""
    fmt, longest = design.formats, total_bits(design, design.widths)
    return longest + fmt.bits("scalar") + max(0, fmt.vector_fraction - fmt.force_fraction)


def share(design: LearnedDesign) -> data.StructLayout:
    """A mantissa of :class:`tfra.model.fixed.learned.share.Share`, with its shift."""
    mantissa, shift = signed(design.formats.bits("scalar")), counter_shape(most_shift(design))
    return data.StructLayout({"mantissa": mantissa, "shift": shift, "even": 1})


def force(design: LearnedDesign) -> data.StructLayout:
    """A force at a taxel in a result word; ``limited``: it was saturated; ``last``: of its frame."""
    return data.StructLayout({"word": signed(design.widths.output), "limited": 1, "last": 1})
