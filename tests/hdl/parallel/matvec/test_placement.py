"""Placement: what becomes of every quad, for products in any order."""

import random

import pytest

from tests.hdl.parallel.designs import label, make
from tfra.hdl.parallel.matvec.images import passes
from tfra.hdl.parallel.matvec.placement import Placement
from tfra.model.choices import Formats
from tfra.model.fixed.tfra.operators import STACKS
from tfra.sim.harness import play

LONG = Formats("long", coefficient=10, operand=10, vector_fraction=16, force_fraction=0)
DESIGNS = [make(4, 6, lanes=24), make(4, 4, LONG, bits=10, lanes=12), make(5, 7, lanes=48)]


SIGNIFICANT = 5
"""Bits of an operand, for the shift that the model and the gateware give its results."""


def _quads(design, name):
    """Right shift, flip and operator of the quads that leave for a product; None where lanes have no row."""
    found = []
    for op in design.stacks[name].operators:
        shift = op.fraction + design.formats.operand - 1 - SIGNIFICANT  # as the model has it
        found += [(shift, op.flip, op.name)] * op.quads
    rows = passes(design, name) * design.architecture.mac_lanes
    return found + [None] * (rows // 4 - len(found))


@pytest.mark.parametrize("design", DESIGNS, ids=label)
def test_quads_are_placed_as_their_operators_say(design):
    rng = random.Random(1)
    cycles, expected = [], []
    for _ in range(12):
        stack = rng.randrange(len(STACKS))
        quads = _quads(design, list(STACKS)[stack])
        cycles += [{"completing": 1, "new": 1, "stack": stack}, {}]
        for quad in quads:
            # Later passes begin between the quads and change nothing.
            cycles += [{"completing": 1, "stack": stack}] * rng.randrange(2) + [{"leave": 1}]
            expected.append(quad)
    record = play(Placement(design), cycles, ["quad"])
    seen = [row["quad"] for row, inputs in zip(record, cycles, strict=True) if "leave" in inputs]
    # The operand was moved left by the bits that it leaves free; sums are extended by some bits before the shift.
    amount = design.widths.vector - 1 - SIGNIFICANT - design.widths.alignment
    for quad, want in zip(seen, expected, strict=True):
        assert quad["send"] == (want is not None)
        if want is not None:
            shift, flip, operator = want
            assert (quad["offset"] + amount, quad["flip"]) == (shift, flip)
            assert quad["kind"] == 1 << design.kinds.index(operator)
