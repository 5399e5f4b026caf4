"""The types and the vectors that the sources of the blocks name, by their proven bits and by their words."""

import numpy as np

from tfra.model.fixed.design import Design
from tfra.model.fixed.learned.design import LearnedDesign
from tfra.model.fixed.numbers import signed_bits
from tfra.model.fixed.tfra.design import TfraDesign

WIDE = 64
"""Bits of what has no type of its own: the model's integers, which are proven to fit 63."""

INT = 32
"""Fewest bits of what is calculated with: C would make these of shorter words."""

_STORED = ("code_t", "operand_t", "coefficient_t", "step_t")
"""Words that are read for an int or a longer type, and may be shorter themselves."""

_SCALARS = ("scalar", "division", "sums", "direction")
"""Formats of what is no vector."""


def types(design: Design, fewest: int = INT) -> dict[str, int]:
    """Bits of every signed type by its name, ``fewest`` of what is calculated with."""
    w = design.widths
    operators = (op for stack in design.stacks.values() for op in stack.operators)
    combined = design.formats.bits("operand.combine")
    found = {
        "code_t": w.stress,
        "magnitude_t": w.magnitude + 1,
        "vector_t": 1 + max(w.vector, w.force, combined),
        "operand_t": max(design.operand_word, combined),
        "coefficient_t": max(signed_bits(int(np.abs(op.rows).max())) for op in operators),
        "accumulator_t": w.accumulator + w.alignment,
        "moment_t": w.moment + 1,
        "scalar_t": 1 + max(map(design.formats.bits, _SCALARS)),
        "candidate_t": w.candidate,
        "step_t": signed_bits(2 * design.candidates) if isinstance(design, TfraDesign) else 0,
        "wide_t": WIDE,
    }
    return {name: bits if name in _STORED else max(bits, fewest) for name, bits in found.items() if bits > 1}


def vectors(design: Design) -> dict[str, int]:
    """Words of every vector between the stages by its name."""
    vector, taxels = 4 * design.quads, design.sensor.taxels
    if isinstance(design, LearnedDesign):
        units1, units2 = (4 * count for count in design.weights.counts)
        of_forces = {"inverse": vector} if design.taxel_forces else {}
        return of_forces | {"sums1": units1, "sums2": units2, "direct": 4 * 2, "read": 4 * 2}
    names = ("b", "n", "kept_n", "c33", "e0", "e1", "kept_e0", "kept_e1")
    return dict.fromkeys(names, vector) | {"sums": 4, "p": taxels, "q": taxels}
