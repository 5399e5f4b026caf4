"""Types and memory of a core in C: its state, byte by byte, and the most that it takes of a stack."""

from tfra.codegen.blocks.types import types, vectors
from tfra.model.fixed.design import Design
from tfra.model.fixed.learned.design import LearnedDesign
from tfra.model.fixed.tfra.design import TfraDesign

_SAVED = 2048
"""Bytes for scalars, saved registers and what compilers spill, in all frames of the deepest call."""


def size_of(bits: int, signed: bool = True) -> int:
    """Bytes of the shortest type that holds ``bits``: two or more if ``signed``, since C calculates with int."""
    return next(size for size in (1, 2, 4, 8) if bits <= 8 * size and size > signed)


def c_type(bits: int, signed: bool = True) -> str:
    """That type."""
    return f"{'' if signed else 'u'}int{8 * size_of(bits, signed)}_t"


def state(design: Design) -> list[tuple[str, str]]:
    """Type and declarator of every member of the state, the longest types first, so that nothing is between them."""
    vector, code = c_type(types(design)["vector_t"]), c_type(design.adc.bits)
    members = [(vector, f"{name}[{words}]") for name, words in vectors(design).items()]
    return [*members, *((code, f"{name}[{design.sensor.taxels}]") for name in _codes(design)), ("uint16_t", "frame")]


def _codes(design: Design) -> tuple[str, ...]:
    return ("codes", "stress") if isinstance(design, TfraDesign) else ("codes",)


def ram_bytes(design: Design) -> int:
    """Bytes of the state."""
    vector = size_of(types(design)["vector_t"])
    code = size_of(design.adc.bits)
    used = vector * sum(vectors(design).values()) + code * len(_codes(design)) * design.sensor.taxels + 2
    return -(-used // vector) * vector


def stack_bytes(design: Design) -> int:
    """A bound for the stack: the arrays of the stage that has most of them, and what is beside them."""
    bits = types(design)
    vector, wide, operand = size_of(bits["vector_t"]), size_of(bits["wide_t"]), size_of(bits["operand_t"])
    plane, taxels = 4 * design.quads * vector, design.sensor.taxels
    most = 4 * max(stack.operand_quads for stack in design.stacks.values())
    operands, units = most * operand, most * vector
    if isinstance(design, LearnedDesign):
        # Those of the activations, or of the forces at the taxels.
        arrays = max(3 * units, (6 * plane + taxels * vector + units + operands) if design.taxel_forces else 0)
    else:
        # Those of its last stage, which compilers don't all lay over each other, or of the sweep.
        sweep = taxels * (size_of(bits["candidate_t"]) + vector + wide) + 4 * (design.candidates + 1) * wide
        arrays = max(9 * plane + taxels * vector, sweep)
    return -(-(arrays + operands + _SAVED) // 256) * 256
