"""Friction and direction of a resultant (Eqs. 15, 16), for estimators that find the resultant itself."""

import numpy as np

from tfra.model.arrays import Bools, Floats

STILL = 1e-6
"""A tangential resultant below this share of the normal one is rounding error and has no direction."""


def friction(resultant: Floats) -> Floats:
    """mu ``(n,)`` of ``resultant (n, 3)`` in N: tangential over normal force, 0 without the latter."""
    normal = np.abs(resultant[:, 2])
    return np.divide(tangential(resultant), normal, out=np.zeros(len(normal)), where=normal > 0)


def direction(resultant: Floats) -> tuple[Floats, Bools]:
    """phi ``(n,)`` in degrees, in [0, 360), and where there is none: there it is 0."""
    still = tangential(resultant) <= STILL * np.abs(resultant[:, 2])
    phi = np.degrees(np.arctan2(resultant[:, 1], resultant[:, 0])) % 360.0 % 360.0  # -1e-20 % 360 is 360
    return np.where(still, 0.0, phi), still


def tangential(resultant: Floats) -> Floats:
    """Modulus ``(n,)`` of the tangential force, N."""
    return np.hypot(resultant[:, 0], resultant[:, 1])
