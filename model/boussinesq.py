"""Boussinesq operators of a taxel array: Eqs. 1-6 and 9 of doi:10.1016/j.mechatronics.2023.103070."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from tfra.model.arrays import Floats
from tfra.model.sensor import SensorArray


@dataclass(frozen=True, eq=False)
class Operators:
    """Precomputed ``(m, m)`` matrices of one sensor; stress in Pa, forces in N, so C is in 1/m^2.

    ``c31, c32, c33`` map f_x, f_y, f_z to normal stress (Eq. 5); ``pinv1, pinv2, pinv3`` are the blocks of
    A-dagger (Eq. 6), in m^2; ``c33_inv`` solves for normal forces alone (Eq. 9), in m^2.
    """

    c31: Floats
    c32: Floats
    c33: Floats
    c33_inv: Floats
    pinv1: Floats
    pinv2: Floats
    pinv3: Floats

    @property
    def a(self) -> Floats:
        """A = [C31 C32 C33], shape ``(m, 3m)`` (Eq. 4)."""
        return np.hstack([self.c31, self.c32, self.c33])


def boussinesq(sensor: SensorArray) -> tuple[Floats, Floats, Floats]:
    """C31, C32, C33 of Eq. 5, each ``(m, m)`` in 1/m^2: row = taxel, column = force.

    The projection r-hat runs from the taxel to the force.
    """
    x, y = sensor.positions()
    rx = x[None, :] - x[:, None]
    ry = y[None, :] - y[:, None]
    h = sensor.thickness
    c0 = 3 * h**2 / (2 * np.pi * (rx**2 + ry**2 + h**2) ** 2.5)
    return c0 * rx, c0 * ry, c0 * h


@lru_cache(maxsize=32)
def operators(sensor: SensorArray) -> Operators:
    """Every precomputed matrix of ``sensor``; read-only and cached.

    They are derived in units of the cover thickness, where they are well conditioned, and scaled back.
    """
    h2 = sensor.thickness**2
    c31, c32, c33 = (h2 * c for c in boussinesq(sensor))
    gram = c31 @ c31.T + c32 @ c32.T + c33 @ c33.T
    c33_inv = np.asarray(np.linalg.inv(c33), dtype=np.float64)
    pinv1, pinv2, pinv3 = (  # gram is symmetric
        np.asarray(np.linalg.solve(gram, c).T, dtype=np.float64) for c in (c31, c32, c33)
    )
    result = Operators(c31 / h2, c32 / h2, c33 / h2, c33_inv * h2, pinv1 * h2, pinv2 * h2, pinv3 * h2)
    for matrix in vars(result).values():
        matrix.setflags(write=False)
    return result
