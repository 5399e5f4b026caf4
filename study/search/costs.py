"""Costs of a design from its choices, without elaboration, for the thousands of designs of a study; and of its core."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from tfra.families import FAMILIES, Family
from tfra.hdl.cores import microarchitecture
from tfra.hdl.parallel.scaling import CHUNK, word_bits
from tfra.hdl.serial.product import low_bits
from tfra.hdl.serial.program.learned.memory import sizes as learned_sizes
from tfra.hdl.serial.program.tfra.memory import sizes as tfra_sizes
from tfra.hdl.serial.sizes import Sizes
from tfra.model.fixed.design import Design
from tfra.model.fixed.learned.design import LearnedDesign
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.synth.estimate import estimate, multipliers

STORED = ("coefficient_kbit", "multiplier_kbit", "DSP")
CYCLES = ("latency_cycles", "interval_cycles")
ELABORATED = ("LUT", "FF", "BRAM")
COSTS = (*STORED, *CYCLES, *ELABORATED)
"""Costs of a core: bits of all coefficients, each counted once; bits of both factors of a frame's products, multiplied;
multiplier cells, from the choices; cycles from its timeline; and the estimate's resources."""

Factors = list[tuple[int, int]]
"""Widths of the factors of multipliers."""


def costs_of(design: Design, names: tuple[str, ...], family: Family) -> dict[str, float]:
    """The costs ``names`` of a core on ``family``."""
    values = {
        "coefficient_kbit": coefficient_kbit(design),
        "multiplier_kbit": multiplier_kbit(design),
        "DSP": float(dsp(design, family)),
    }
    if any(name in CYCLES for name in names):
        core = microarchitecture(design)
        values |= {"latency_cycles": float(core.latency), "interval_cycles": float(core.initiation_interval)}
    if any(name in ELABORATED for name in names):
        values |= {name: float(used) for name, used in estimate(design, family).total.items()}
    return {name: values[name] for name in names}


def coefficient_kbit(design: Design) -> float:
    """Coefficients of all operators, each stored once, in 1000 bits."""
    return design.coefficient_bits / 1000


def multiplier_kbit(design: Design) -> float:
    """Bits of coefficient times bits of operand, over all products of a frame, in 1000."""
    bits = design.formats.bits
    products = [(stack, op) for stack in design.products for op in design.stacks[stack].operators]
    whole = sum(op.rows.size * bits(f"coefficient.{op.name}") * bits(f"operand.{stack}") for stack, op in products)
    return whole / 1000


def products(design: Design) -> Factors:
    """Widths of the factors of every multiplier of the core; those that may be cells by name come first."""
    parallel, sizes = _ESTIMATORS[type(design)]
    if design.architecture.kind == "serial":
        size = sizes(design)
        pairs = [(size.multiplicand, size.multiplier), *[(size.operand, size.coefficient)] * size.lanes]
        return [(a - low_bits(a), b - low_bits(b)) for a, b in pairs]
    named, others = parallel(design)
    return [*named, *others]


def dsp(design: Design, family: Family) -> int:
    """Multiplier cells that the core takes of ``family``, as :func:`tfra.synth.estimate.estimate` counts them.

    Some targets have instances of cells, however short the products are.
    """
    cell, cells = family.multiplier, FAMILIES[design.target].gateware if design.target in FAMILIES else {}
    if design.architecture.kind == "serial" or "multiplier" not in cells:
        return sum(multipliers(each, cell) for each in products(design))
    named, others = _ESTIMATORS[type(design)][0](design)
    whole = cell and replace(cell, shortest=(0, 0), sign_bits=1)
    return sum(multipliers(each, whole) for each in named) + sum(multipliers(each, cell) for each in others)


def _lanes(design: Design) -> Factors:
    return [(design.coefficient_word, design.operand_word)] * design.architecture.mac_lanes


def _tfra(design: TfraDesign) -> tuple[Factors, Factors]:
    """Those that may be cells by name, and the others."""
    bits, scalar = design.formats.bits, design.formats.bits("scalar")
    return _lanes(design), [
        *[(bits("operand.combine"), scalar)] * design.architecture.vector_words,
        (bits("sums"), bits("direction")),  # dependent
        (scalar, scalar - 1),  # friction: |mu_ind| is at most one
        (bits("sums"), scalar),  # resultant
        *((chunk, scalar) for chunk in _chunks(word_bits(design))),  # scaling
    ]


def _chunks(bits: int) -> list[int]:
    """Words of the partial products of a word of ``bits``; all but the last are unsigned."""
    return [bits] if bits <= CHUNK + 1 else [CHUNK + 1, *_chunks(bits - CHUNK)]


def _learned(design: LearnedDesign) -> tuple[Factors, Factors]:
    """The same for the network and the forward model."""
    if not design.taxel_forces:
        return _lanes(design), []
    scalar = design.formats.bits("scalar")
    return [*_lanes(design), (design.widths.force, scalar)], [(design.formats.bits("operand.combine"), scalar)] * 2


_ESTIMATORS: Mapping[type[Design], tuple[Callable[[Any], tuple[Factors, Factors]], Callable[[Any], Sizes]]] = {
    TfraDesign: (_tfra, tfra_sizes),
    LearnedDesign: (_learned, learned_sizes),
}
"""Multipliers of the parallel core, and sizes of the serial one, an estimator a line."""
