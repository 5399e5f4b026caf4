"""|F*|, mu and the gain F_sens / F* (Eqs. 15, 29-31)."""

import math
from dataclasses import dataclass

import numpy as np

from tfra.model.arrays import Bools, Ints
from tfra.model.fixed.cordic import cordic, cordic_gain, iterations
from tfra.model.fixed.design import Design
from tfra.model.fixed.normaliser import Normalised
from tfra.model.fixed.numbers import bit_length, divide, normalize, round_shift
from tfra.model.fixed.widths import MU_LIMIT, force_drop, scalar_fraction
from tfra.model.rounding import Rounding


@dataclass(frozen=True)
class Resultant:
    """``words (n, 3)`` = F* on the vector grid times ``2^exponent (n,)``."""

    words: Ints
    exponent: Ints


@dataclass(frozen=True)
class Gain:
    """``mantissa (n,)``, unsigned, as long as a scalar; ``shift``: right shifts that bring a force, or a resultant,
    times the mantissa to the grid of result words; ``mu`` as a scalar; ``overflow``: mu or the gain is limited."""

    mantissa: Ints
    force_shift: Ints
    resultant_shift: Ints
    mu: Ints
    overflow: Bools


def gain_constants(design: Design) -> tuple[int, int]:
    """The CORDIC gain with two fraction bits less than its iterations, and its square with three less."""
    bits, gain = iterations(design), cordic_gain(design)
    return round(gain * 2 ** (bits - 2)), round(gain**2 * 2 ** (bits - 3))


def normal_gain(design: Design) -> tuple[int, int]:
    """mantissa * 2^-exponent takes dimensionless forces on the vector grid to codes times the taxel's area.

    It is h^2 / (s_x s_y) over the grid: the gain of frames that need no scaling.
    """
    ratio = design.sensor.thickness**2 / design.sensor.taxel_area * 2.0**-design.formats.vector_fraction
    bits = design.formats.bits("scalar")
    exponent = bits - 1 - math.floor(math.log2(ratio))
    return min(round(ratio * 2.0**exponent), (1 << bits) - 1), exponent


def gain(design: Design, total: Resultant, frame: Normalised) -> Gain:
    """Gain of a frame's forces.

    The modulus takes two CORDIC runs; the second gets F_z times the gain of the first.  The quotient
    F_sens / |F*| of numbers normalised to their top bit lies in (1/2, 2).
    """
    scalar, rotations, bits = design.formats.bits("scalar"), iterations(design), design.widths.division
    first, second = gain_constants(design)
    tangential, _ = cordic(design, np.abs(total.words[:, 0]), np.abs(total.words[:, 1]))
    normal = round_shift(np.abs(total.words[:, 2]) * first, rotations - 2, Rounding.TRUNCATE)
    modulus, _ = cordic(design, tangential, normal)
    numerator = frame.magnitude * second
    n_bits, m_bits = bit_length(numerator), bit_length(modulus)
    quotient = divide(normalize(numerator, n_bits, bits), np.maximum(normalize(modulus, m_bits, bits), 1), scalar - 1)
    regular = frame.regular
    mantissa = np.where(regular, np.minimum(quotient, (1 << scalar) - 1), normal_gain(design)[0])
    # numerator / modulus = quotient * 2^(n_bits - m_bits - scalar + 1); numerator has rotations - 3 fraction bits
    exponent = np.where(
        regular, (scalar - 1) + (rotations - 3) + m_bits - n_bits - total.exponent, normal_gain(design)[1]
    )
    force_shift = exponent + 2 - force_drop(design) - design.formats.force_fraction
    resultant_shift = exponent + total.exponent - design.formats.force_fraction
    fraction = scalar_fraction(design)
    top_mu = (1 << (scalar - 1)) - 1
    unbounded = regular & (tangential >= MU_LIMIT * normal)
    ratio = divide(np.where(unbounded, 0, tangential), np.maximum(normal, 1), fraction)
    mu = np.where(regular, np.where(unbounded, top_mu, np.minimum(ratio, top_mu)), 0)
    overflow = unbounded | (regular & (modulus == 0)) | (force_shift < 0) | (resultant_shift < 0)
    return Gain(mantissa, np.maximum(force_shift, 0), np.maximum(resultant_shift, 0), mu, overflow)
