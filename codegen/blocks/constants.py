"""The constants that the sources of the blocks name."""

from typing import Any

from tfra.model.fixed.butterfly import EE, OO, OX, OY
from tfra.model.fixed.cordic import ANGLE_GUARD, iterations
from tfra.model.fixed.design import Design
from tfra.model.fixed.gain import gain_constants, normal_gain
from tfra.model.fixed.learned.design import LearnedDesign
from tfra.model.fixed.learned.resultant import THRESHOLD_FRACTION
from tfra.model.fixed.learned.share import even_word
from tfra.model.fixed.tfra.centroids import pitch_ratio
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.fixed.tfra.sweep import sweep_unit
from tfra.model.fixed.widths import MU_LIMIT, force_drop, scalar_fraction
from tfra.model.learned.field import MOST_FRICTION
from tfra.model.rounding import Rounding
from tfra.model.tfra import COEFFICIENT_LIMIT

PARITIES = {"EE": EE, "OX": OX, "OY": OY, "OO": OO}
"""Places of the parities in a vector."""

Sections = dict[str, dict[str, int]]
"""Constants by their names, under what they are about."""


def constants(design: Design) -> Sections:
    """All constants of ``design``; "bits" are those of words, "fraction" counts the bits below their point."""
    formats, sensor = design.formats, design.sensor
    first, second = gain_constants(design)
    array = {"ROWS": sensor.rows, "COLUMNS": sensor.columns, "TAXELS": sensor.taxels, "QUADS": design.quads}
    words = {
        "ADC_BITS": design.adc.bits,
        "CONTACT_THRESHOLD": design.adc.threshold,
        "VECTOR_FRACTION": formats.vector_fraction,
        "FORCE_FRACTION": formats.force_fraction,
        "FORCE_DROP": force_drop(design),
        "OUTPUT": design.widths.output,
        "SCALAR": formats.bits("scalar"),
        "SCALAR_FRACTION": scalar_fraction(design),
        "DIVISION": formats.bits("division"),
        "MU_LIMIT": MU_LIMIT,
        "HALF_EVEN": int(formats.rounding is Rounding.HALF_EVEN),
        "TRUNCATE": int(formats.rounding is Rounding.TRUNCATE),
    }
    cordic = {
        "CORDIC": iterations(design),
        "ANGLE_GUARD": ANGLE_GUARD,
        "CORDIC_GAIN": first,
        "CORDIC_GAIN_SQUARED": second,
    }
    products = {f"OPERAND_{name.upper()}": formats.bits(f"operand.{name}") for name in (*design.stacks, "combine")}
    for stack in design.stacks.values():
        products |= {f"FRACTION_{op.name.upper()}": op.fraction for op in stack.operators}
    status = {flag.name: flag.value for flag in design.status_bits if flag.name}
    return {
        "the array": array,
        "the parities of a vector": PARITIES,
        "words: bits, fraction bits, limits": words,
        "the CORDIC: its iterations, guard bits of the angle, its gain and the square of it": cordic,
        "products: bits of operands, fraction bits of coefficients": products,
        "status bits": status,
        **_OWN[type(design)](design),
    }


def _tfra(design: TfraDesign) -> Sections:
    mantissa, exponent = normal_gain(design)
    pitch_x, pitch_y = pitch_ratio(design)
    direction = {
        "PITCH_X": pitch_x,
        "PITCH_Y": pitch_y,
        "DIRECTION": design.formats.bits("direction"),
        "SUMS": design.formats.bits("sums"),
        "COEFFICIENT_LIMIT": int(COEFFICIENT_LIMIT),
    }
    sweep = {
        "STEPS": design.search.steps,
        "CANDIDATES": design.candidates,
        "SWEEP_HALF": 1 << (design.candidates.bit_length() - 1),
        "SWEEP_UNIT": sweep_unit(design),
    }
    return {
        "the direction and the dependent friction": direction,
        "the sweep": sweep,
        "the gain of frames that are not swept": {"NORMAL_MANTISSA": mantissa, "NORMAL_EXPONENT": exponent},
    }


def _learned(design: LearnedDesign) -> Sections:
    units1, units2 = design.weights.counts
    network = {
        "TAXEL_FORCES": int(design.taxel_forces),
        "UNITS1": units1,
        "UNITS2": units2,
        "MOST_UNITS": max(units1, units2, design.quads),
        "THRESHOLD": design.threshold_word,
        "THRESHOLD_FRACTION": THRESHOLD_FRACTION,
        "MOST_FRICTION": int(MOST_FRICTION * 2 ** scalar_fraction(design)),
        "EVEN_WORD": even_word(design),
    }
    return {"the network and its field": network}


_OWN: dict[type[Design], Any] = {TfraDesign: _tfra, LearnedDesign: _learned}
