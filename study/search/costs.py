"""Costs of a design from its choices, without elaboration, for the thousands of designs of a study."""

from dataclasses import replace

from tfra.families import FAMILIES, Family
from tfra.hdl.parallel.scaling import CHUNK, word_bits
from tfra.hdl.serial.product import low_bits
from tfra.hdl.serial.program.tfra.memory import sizes
from tfra.model.fixed.design import Design
from tfra.synth.estimate import multipliers


def coefficient_kbit(design: Design) -> float:
    """Coefficients of all operators, each stored once, in 1000 bits."""
    return design.coefficient_bits / 1000


def products(design: Design) -> list[tuple[int, int]]:
    """Widths of the factors of every multiplier of the core."""
    return _serial(design) if design.architecture.kind == "serial" else _parallel(design)


def dsp(design: Design, family: Family) -> int:
    """Multiplier cells that the core takes of ``family``, as :func:`tfra.synth.estimate.estimate` counts them.

    Those of the lanes, which come first, are instances for some targets, however short the products are.
    """
    cell, cells = family.multiplier, FAMILIES[design.target].gateware if design.target in FAMILIES else {}
    named = design.architecture.mac_lanes if "multiplier" in cells else 0
    whole = cell and replace(cell, shortest=(0, 0), sign_bits=1)
    widths = products(design)
    return sum(multipliers(each, whole if place < named else cell) for place, each in enumerate(widths))


def _parallel(design: Design) -> list[tuple[int, int]]:
    bits, architecture = design.formats.bits, design.architecture
    scalar = bits("scalar")
    return [
        *[(design.coefficient_word, design.operand_word)] * architecture.mac_lanes,
        *[(bits("operand.combine"), scalar)] * architecture.vector_words,
        (bits("sums"), bits("direction")),  # dependent
        (scalar, scalar - 1),  # friction: |mu_ind| is at most one
        (bits("sums"), scalar),  # resultant
        *((chunk, scalar) for chunk in _chunks(word_bits(design))),  # scaling
    ]


def _chunks(bits: int) -> list[int]:
    """Words of the partial products of a word of ``bits``; all but the last are unsigned."""
    return [bits] if bits <= CHUNK + 1 else [CHUNK + 1, *_chunks(bits - CHUNK)]


def _serial(design: Design) -> list[tuple[int, int]]:
    size = sizes(design)
    pairs = [(size.multiplicand, size.multiplier), *[(size.operand, size.coefficient)] * size.lanes]
    return [(a - low_bits(a), b - low_bits(b)) for a, b in pairs]
