"""Bounds on the CORDIC, on phi from the codes on, and on the scaling of given forces: of any design, for any frame."""

import math
from dataclasses import dataclass

import numpy as np

from tfra.model.arrays import Floats, Ints
from tfra.model.fixed.cordic import ANGLE_GUARD, angle_table, cordic, cordic_gain, iterations
from tfra.model.fixed.design import Design
from tfra.model.fixed.gain import gain_constants
from tfra.model.fixed.numbers import bit_length, round_shift
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.fixed.tfra.pipeline import Trace
from tfra.model.fixed.widths import scalar_fraction
from tfra.model.rounding import Rounding
from tfra.study.bounds.direction import direction_slack
from tfra.study.bounds.slack import shifted


@dataclass(frozen=True)
class Rotation:
    """What truncating rotations add to a vector: ``x``, in last bits, and ``y`` over the lengthening so far."""

    gain: float
    x: float
    y: float
    last: float
    """The last angle, in radians."""

    @classmethod
    def of(cls, design: Design) -> "Rotation":
        """|dx'| <= |dx| + 2^-i |dy| + 1 after rotation i, and the same of y; the first shifts nothing out."""
        x = y = most = 0.0
        gain = math.sqrt(2)
        for i in range(1, iterations(design)):
            most = max(most, y / gain)
            x, y = x + 0.5**i * y + 1, y + 0.5**i * x + 1
            gain *= math.sqrt(1 + 4.0**-i)
        return cls(cordic_gain(design), x, most, math.atan(2.0 ** (1 - iterations(design))))

    def angle(self, length: Floats) -> Floats:
        """Bound ``(n,)`` of the angle left of vectors of ``length``, in radians.

        A step away from zero needs |y| <= the error of y, so at most the last angle and asin(y / |v|) stay.
        """
        return np.asarray(self.last + np.arcsin(np.minimum(1.0, self.y / np.maximum(length, 1e-300))))

    def modulus(self, length: Floats) -> Floats:
        """Bound ``(n,)`` of |x' - K |v||: x' is K |v| cos(angle left), and the error of x; exact for zero."""
        short = self.gain * length * (1 - np.cos(np.minimum(self.angle(length), np.pi)))
        return np.asarray(np.where(length > 0, short + self.x, 0.0))


def phi_bound(design: TfraDesign, trace: Trace) -> Floats:
    """Bound ``(n,)`` of phi in its last bits: angle left, angles of the table, the last rounding, and the direction."""
    words = np.stack([trace.direction.cos, trace.direction.sin], axis=1).astype(np.float64)
    length, off = np.hypot(*words.T), np.hypot(*direction_slack(design, trace).T)
    guard = design.formats.bits("division") - design.formats.bits("direction")
    n, unit = iterations(design), 2.0 ** iterations(design) / (2 * np.pi)
    exact = np.array([math.atan(2.0**-i) * unit * 2**ANGLE_GUARD for i in range(n)])
    table = np.abs(exact - angle_table(design)).sum() / 2**ANGLE_GUARD
    turned = Rotation.of(design).angle(length * 2.0**guard) + np.arcsin(np.minimum(1.0, off / length))
    return np.asarray(turned * unit + table + 0.5)


def scaling_bounds(design: TfraDesign, trace: Trace) -> dict[str, Floats]:
    """Bounds ``(n, k)`` of gain, mu, resultant and forces in their last bits, given the words that are scaled.

    Frames are swept, and none of their results is limited.
    """
    factor, total = trace.factor, trace.total
    first, second = gain_constants(design)
    n, rotation = iterations(design), Rotation.of(design)
    k = rotation.gain
    word = np.abs(total.words).astype(np.float64)
    flat, length = np.hypot(word[:, 0], word[:, 1]), np.sqrt((word**2).sum(axis=1))
    # K |F_xy| from the first run, K |F_z| from a constant: truncated, one unit at most.
    tangential, _ = cordic(design, *np.abs(total.words[:, :2]).T)
    normal = round_shift(np.abs(total.words[:, 2]) * first, n - 2, Rounding.TRUNCATE)
    off_t = rotation.modulus(flat)
    off_n = word[:, 2] * abs(first / 2.0 ** (n - 2) - k) + (word[:, 2] > 0)
    # K^2 |F| from the second: the modulus is 1-Lipschitz.
    modulus, _ = cordic(design, tangential, normal)
    off_m = k * np.hypot(off_t, off_n) + rotation.modulus(np.hypot(tangential, normal))
    off_m += cut(modulus, design.widths.division)
    numerator = trace.frame.magnitude * second
    over = abs(second / (k**2 * 2.0 ** (n - 3)) - 1) + cut(numerator, design.widths.division) / numerator
    under = off_m / (k**2 * length)
    relative = (over + under) / (1 - under)  # (1 + a) / (1 + b) - 1
    scalar = design.formats.bits("scalar")
    limit = np.where(factor.mantissa == (1 << scalar) - 1, 1.0, 0.5)
    mantissa = (factor.mantissa + limit) * relative / (1 - relative) + limit
    top = (1 << (scalar - 1)) - 1
    ratio = flat / np.maximum(word[:, 2], 1)
    mu = (off_t + ratio * off_n) / np.maximum(normal, 1) * 2.0 ** scalar_fraction(design)
    scaled = {
        "resultant": word * (mantissa * 2.0**-factor.resultant_shift)[:, None] + shifted(factor.resultant_shift)[:, None],
        "forces": np.abs(trace.planes.reshape(len(word), -1)) * (mantissa * 2.0**-factor.force_shift)[:, None]
        + shifted(factor.force_shift)[:, None],
    }
    return {"gain": mantissa[:, None], "mu": (mu + np.where(factor.mu == top, 1.0, 0.5))[:, None], **scaled}


def cut(value: Ints, bits: int) -> Floats:
    """Most that is cut off when the highest ``bits`` of ``value`` stay."""
    return 2.0 ** np.maximum(bit_length(value) - bits, 0) - 1
