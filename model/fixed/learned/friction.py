"""Friction and direction of the resultant (Eqs. 15, 16)."""

from dataclasses import dataclass

import numpy as np

from tfra.model.arrays import Bools, Ints
from tfra.model.fixed.cordic import cordic, iterations
from tfra.model.fixed.design import Design
from tfra.model.fixed.gain import Resultant, gain_constants
from tfra.model.fixed.numbers import divide, round_shift
from tfra.model.fixed.widths import MU_LIMIT, scalar_fraction
from tfra.model.rounding import Rounding


@dataclass(frozen=True)
class Angle:
    """``modulus (n,)`` of the tangential force times the CORDIC gain, ``phi (n,)`` in 2^-iterations turns; ``still``:
    there is no tangential force, and phi is 0."""

    modulus: Ints
    phi: Ints
    still: Bools


@dataclass(frozen=True)
class Friction:
    """``mu, mu_x, mu_y (n,)`` as scalars; ``overflow``: one of them is limited."""

    mu: Ints
    mu_x: Ints
    mu_y: Ints
    overflow: Bools


def angle(design: Design, total: Resultant) -> Angle:
    """Modulus and direction by one run of the CORDIC."""
    x, y = total.words[:, 0], total.words[:, 1]
    still = (x == 0) & (y == 0)
    modulus, phi = cordic(design, x, y)
    return Angle(modulus, np.where(still, 0, phi), still)


def friction(design: Design, total: Resultant, turned: Angle) -> Friction:
    """The three quotients with the normal force; mu's is multiplied by the CORDIC gain, as the modulus is."""
    first, _ = gain_constants(design)
    normal = np.abs(total.words[:, 2])
    scaled = round_shift(normal * first, iterations(design) - 2, Rounding.TRUNCATE)
    mu, unbounded = _limited(design, turned.modulus, scaled)
    mu_x, unbounded_x = _limited(design, total.words[:, 0], normal)
    mu_y, unbounded_y = _limited(design, total.words[:, 1], normal)
    return Friction(mu, mu_x, mu_y, unbounded | unbounded_x | unbounded_y)


def _limited(design: Design, force: Ints, normal: Ints) -> tuple[Ints, Bools]:
    """``force / normal`` as a scalar, limited to the longest one, and where it is; zero for no force."""
    top = (1 << (design.formats.bits("scalar") - 1)) - 1
    unbounded = (np.abs(force) >= MU_LIMIT * normal) & (force != 0)
    ratio = divide(np.where(unbounded, 0, force), np.maximum(normal, 1), scalar_fraction(design))
    return np.where(unbounded, np.where(force < 0, -top, top), np.clip(ratio, -top, top)), unbounded
