"""Types and memory of a core in C: its state, byte by byte, and the most that it takes of a stack."""

from tfra.codegen.blocks.types import types, vectors
from tfra.model.fixed.design import Design
from tfra.model.fixed.tfra.design import TfraDesign

_SAVED = 1536
"""Bytes for scalars, saved registers and what compilers spill, in all frames of the deepest call."""


def size_of(bits: int, signed: bool = True) -> int:
    """Bytes of the shortest type that holds ``bits``: two or more if ``signed``, since C calculates with int."""
    return next(size for size in (1, 2, 4, 8) if bits <= 8 * size and size > signed)


def c_type(bits: int, signed: bool = True) -> str:
    """That type."""
    return f"{'' if signed else 'u'}int{8 * size_of(bits, signed)}_t"


def state(design: Design) -> list[tuple[str, str]]:
    """Type and declarator of every member of the state, the longest types first, so that nothing is between them."""
    vector = c_type(types(design)["vector_t"])
    members = [(vector, f"{name}[{words}]") for name, words in vectors(design).items()]
    return [*members, (c_type(design.adc.bits), f"codes[{design.sensor.taxels}]"), ("uint16_t", "frame")]


def ram_bytes(design: Design) -> int:
    """Bytes of the state."""
    vector = size_of(types(design)["vector_t"])
    code = size_of(design.adc.bits)
    used = vector * sum(vectors(design).values()) + code * design.sensor.taxels + 2
    return -(-used // vector) * vector


def stack_bytes(design: Design) -> int:
    """A bound for the stack: the arrays of a frame and of the block that has most of them, and what is beside them."""
    bits = types(design)
    vector, wide, operand = size_of(bits["vector_t"]), size_of(bits["wide_t"]), size_of(bits["operand_t"])
    plane, taxels = 4 * design.quads * vector, design.sensor.taxels
    most = max(stack.operand_quads for stack in design.stacks.values())
    blocks = [2 * plane + operand * design.quads, 4 * most * operand + plane]
    if isinstance(design, TfraDesign):
        candidates = design.candidates + 1
        blocks.append(taxels * (size_of(bits["candidate_t"]) + vector + wide) + 4 * candidates * wide)
    else:
        blocks.append(3 * plane + 4 * most * vector)
    frame = size_of(design.adc.bits) * taxels
    return -(-(frame + max(blocks) + _SAVED) // 256) * 256
