"""The paper's loop, taken literally: a baseline for timing only.  :class:`tfra.model.tfra.Tfra` gives the same results.

doi:10.1016/j.mechatronics.2023.103070: the vectors a_pq of Eq. 10 once per frame, then for each candidate the three
planes of forces and the products C33 f_z and [C31 C32] [f_x f_y] of Eqs. 23-25.  That is 3 m^2 multiplications a
candidate, 3.2 million for a frame of 10 x 10 taxels and 101 candidates.  Cosine and sine of phi replace its tangent, as
everywhere in this project.
"""

import numpy as np

from tfra.model.arrays import Floats
from tfra.model.boussinesq import operators
from tfra.model.sensor import SensorArray
from tfra.model.tfra import TIE


class LiteralTfra:
    """TFRA for one sensor and a sweep of ``steps`` + 1 candidates, one frame and one candidate at a time."""

    def __init__(self, sensor: SensorArray, steps: int) -> None:
        self._sensor, self._steps, self._ops = sensor, steps, operators(sensor)

    def __call__(self, frames: Floats) -> list[tuple[int, Floats]]:
        """Sweep index and forces ``(3, m)`` in N of each of ``frames (n, rows, columns)`` in Pa.

        All have compression and traction; a vanishing denominator of Eqs. 17/18 is no special case.
        """
        return [self._frame(b) for b in frames.reshape(len(frames), -1)]

    def _frame(self, b: Floats) -> tuple[int, Floats]:
        index, forces = self._sweep(b, self._coefficients(b), self._phi(b))
        f_sens = np.abs(b).sum() * self._sensor.taxel_area  # Eq. 29
        f_star = np.linalg.norm(forces.sum(axis=1))  # Eq. 30
        return index, forces * (f_sens / f_star)  # Eq. 31

    def _phi(self, b: Floats) -> float:
        """Direction from the centroid of traction to that of compression, in rad (Eqs. 11, 19-22)."""
        compression, traction = np.minimum(b, 0.0), np.maximum(b, 0.0)
        step_x, step_y = (
            compression @ at / compression.sum() - traction @ at / traction.sum() for at in self._sensor.positions()
        )
        return float(np.arctan2(step_y, step_x))

    def _coefficients(self, b: Floats) -> Floats:
        """a_pq of Eq. 10, shape ``(3, 3, m)``, in N."""
        ops = self._ops
        w_z = np.minimum(ops.c33_inv @ b, 0.0)  # Eq. 9
        n = np.abs(w_z)
        a = np.array([
            [pinv @ b - pinv @ (ops.c33 @ w_z), -pinv @ (ops.c31 @ n), -pinv @ (ops.c32 @ n)]
            for pinv in (ops.pinv1, ops.pinv2, ops.pinv3)
        ])
        a[0, 1] += n
        a[1, 2] += n
        a[2, 0] += w_z
        return a

    def _sweep(self, b: Floats, a: Floats, phi: float) -> tuple[int, Floats]:
        """Index and unscaled forces of the smallest (B^z, B^xy), the first of equals (Eqs. 12-28)."""
        ops, sums, traction = self._ops, a.sum(axis=2), b[b > 0].sum()  # Eq. 12
        cos, sin = np.cos(phi), np.sin(phi)
        u0, u_x, u_y = sums[0] * sin - sums[1] * cos
        along_y = abs(sin) > abs(cos) * (1 + TIE)  # Fig. 3
        start = self._steps if (sin if along_y else cos) < 0 else 0
        best, chosen = (np.inf, np.inf), (0, a[:, 0])
        for index in range(self._steps + 1):
            mu = (index - start) / self._steps
            mu_x, mu_y = (-(u0 + mu * u_y) / u_x, mu) if along_y else (mu, -(u0 + mu * u_x) / u_y)  # Eqs. 17, 18
            f = a[:, 0] + mu_x * a[:, 1] + mu_y * a[:, 2]  # Eq. 10
            normal = ops.c33 @ f[2]
            tangential = ops.c31 @ f[0] + ops.c32 @ f[1]  # Eq. 24
            b_z = float(normal[normal > 0].sum())  # Eq. 23
            b_xy = float(abs(tangential[tangential > 0].sum() - traction))  # Eq. 25
            if (b_z, b_xy) < best:
                best, chosen = (b_z, b_xy), (index, f)
        return chosen
