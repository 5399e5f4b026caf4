"""The products of the learned estimator and what they wait for."""

from __future__ import annotations

from tfra.hdl.parallel.matvec.plan import Plan, Source
from tfra.model.fixed.learned.design import LearnedDesign

FRAMES = 4
"""Frames in flight between the first product and the last result word; memories have a place for each."""

UNITS = {"first": "h1", "inverse": "p0", "second": "h2"}
"""By operator in front of an activation, the source that holds the units."""


def plan(design: LearnedDesign) -> Plan:
    """A first product needs a place of its frame, and banks for the units that it leads to; a read-out needs friction
    to have ended with the frame before, since its scalars are found for one frame at a time.

    The field comes after the read-out, which all that leaves first depends on.
    """
    sources = (
        Source("h2", ("read",), 2, "h2_token"),
        Source("p0", ("field",), 2, "p0_token"),
        Source("h1", ("second",), 2, "h1_token"),
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
