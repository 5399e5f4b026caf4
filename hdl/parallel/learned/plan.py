"""The products of the learned estimator and what they wait for."""

from tfra.hdl.parallel.matvec.plan import Plan, Source
from tfra.model.fixed.learned.bounds import bounds
from tfra.model.fixed.learned.design import LearnedDesign
from tfra.model.fixed.numbers import signed_bits

FRAMES = 4
"""Frames in flight between the first product and the last result word; memories have a place for each."""

UNITS = {"first": "h1", "inverse": "p0", "second": "h2"}
"""By operator in front of an activation, the source that holds the units."""


def mirror_bits(design: LearnedDesign) -> int:
    """Bits of a unit at a mirror, and of a sum in front of it."""
    most = bounds(design, design.stacks)
    return signed_bits(max(most[name] for name in UNITS.values() if name in most))


def plan(design: LearnedDesign) -> Plan:
    """A first product needs a place of its frame, and banks for the units that it leads to; a read-out needs friction
    to have ended with the frame before, since its scalars are found for one frame at a time.

    The field comes after the read-out, which all that leaves first depends on.
    """
    bits = mirror_bits(design) + 2
    sources = (
        Source("h2", ("read",), 2, "h2_token", bits),
        Source("p0", ("field",), 2, "p0_token", bits),
        Source("h1", ("second",), 2, "h1_token", bits),
        Source("b", ("first",), 1),
    )
    needs: dict[str, tuple[str, ...]] = {
        "first": ("frame_token", "h1_token"),
        "second": ("h2_token",),
        "read": ("scalars_token",),
    }
    if not design.taxel_forces:
        return Plan(tuple(source for source in sources if source.name != "p0"), needs)
    needs["first"] += ("p0_token",)
    return Plan(sources, needs | {"field": ("read_begun",)}, {"read_begun": "read"})
