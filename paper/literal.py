"""The paper's loop, taken literally: a baseline for timing only.  :class:`tfra.model.tfra.Tfra` gives the same results.

doi:10.1016/j.mechatronics.2023.103070: the vectors a_pq of Eq. 10 once per frame, then for each candidate the three
planes of forces and the products C33 f_z and [C31 C32] [f_x f_y] of Eqs. 23-25.  That is 3 m^2 multiplications a
candidate, 3.2 million for a frame of 10 x 10 taxels and 101 candidates.  Cosine and sine of phi replace its tangent, as
everywhere in this project.
"""

import numpy as np
import numpy.typing as npt

from tfra.model.arrays import Floats
from tfra.model.boussinesq import operators
from tfra.model.sensor import SensorArray
from tfra.model.tfra import TIE, Result, Status, check_frames


class LiteralTfra:
    """TFRA for one sensor and a sweep of ``steps`` + 1 candidates, one frame and one candidate at a time.

    Frames without contact and frames of compression only are treated as in ``Tfra``; a vanishing denominator of
    Eqs. 17/18 is not.  Raises ``ValueError`` for fewer than one step.
    """

    def __init__(self, sensor: SensorArray, steps: int = 100) -> None:
        if steps < 1:
            raise ValueError(f"steps: at least 1 is needed, got {steps}")
        self.sensor = sensor
        self.steps = steps
        self._ops = operators(sensor)
        self._x, self._y = sensor.positions()

    def __call__(self, frames: npt.ArrayLike) -> Result:
        """Forces of ``frames (n, rows, columns)`` in Pa; raises ``ValueError`` for a wrong shape or NaN."""
        b = check_frames(self.sensor, frames).reshape(-1, self.sensor.taxels)
        results = [self._frame(row) for row in b]
        forces = np.array([f for f, *_ in results]).reshape(len(b), 3, self.sensor.rows, self.sensor.columns)
        phi, mu_x, mu_y = (np.array([row[k] for row in results], dtype=np.float64) for k in (1, 2, 3))
        index, status = (np.array([row[k] for row in results], dtype=np.int64) for k in (4, 5))
        resultant = forces.sum(axis=(2, 3))  # Eq. 12
        tangential, normal = np.hypot(resultant[:, 0], resultant[:, 1]), np.abs(resultant[:, 2])
        mu = np.divide(tangential, normal, out=np.zeros(len(b)), where=normal > 0)  # Eq. 15
        return Result(forces, resultant, np.degrees(phi) % 360.0 % 360.0, mu, mu_x, mu_y, index, status)

    def _frame(self, b: Floats) -> tuple[Floats, float, float, float, int, int]:
        """Forces ``(3, m)`` in N, phi in rad, mu_x, mu_y, sweep index and status of one frame ``(m,)``."""
        forces = np.zeros((3, len(b)))
        if not (b < 0).any():
            return forces, 0.0, 0.0, 0.0, 0, Status.NO_CONTACT
        if not (b > 0).any():
            forces[2] = self._ops.c33_inv @ b
            return forces, 0.0, 0.0, 0.0, 0, Status.COMPRESSION_ONLY
        phi, a = self._phi(b), self._coefficients(b)
        forces, mu_x, mu_y, index = self._sweep(b, a, phi)
        f_sens = np.abs(b).sum() * self.sensor.taxel_area  # Eq. 29
        f_star = np.linalg.norm(forces.sum(axis=1))  # Eq. 30
        status = Status.DEPENDENT_OUT_OF_RANGE if max(abs(mu_x), abs(mu_y)) > 1 + TIE else 0
        return forces * (f_sens / f_star), phi, mu_x, mu_y, index, status  # Eq. 31

    def _phi(self, b: Floats) -> float:
        """Direction from the centroid of traction to that of compression, in rad (Eqs. 11, 19-22)."""
        compression, traction = np.minimum(b, 0.0), np.maximum(b, 0.0)
        step_x, step_y = (
            compression @ at / compression.sum() - traction @ at / traction.sum() for at in (self._x, self._y)
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

    def _sweep(self, b: Floats, a: Floats, phi: float) -> tuple[Floats, float, float, int]:
        """Unscaled forces, mu_x, mu_y and index of the smallest (B^z, B^xy), the first of equals (Eqs. 12-28)."""
        ops, sums, traction = self._ops, a.sum(axis=2), b[b > 0].sum()  # Eq. 12
        cos, sin = np.cos(phi), np.sin(phi)
        u0, u_x, u_y = sums[0] * sin - sums[1] * cos
        along_y = abs(sin) > abs(cos) * (1 + TIE)  # Fig. 3
        start = self.steps if (sin if along_y else cos) < 0 else 0
        best, chosen = (np.inf, np.inf), (a[:, 0], 0.0, 0.0, 0)
        for index in range(self.steps + 1):
            mu = (index - start) / self.steps
            mu_x, mu_y = (-(u0 + mu * u_y) / u_x, mu) if along_y else (mu, -(u0 + mu * u_x) / u_y)  # Eqs. 17, 18
            f = a[:, 0] + mu_x * a[:, 1] + mu_y * a[:, 2]  # Eq. 10
            normal = ops.c33 @ f[2]
            tangential = ops.c31 @ f[0] + ops.c32 @ f[1]  # Eq. 24
            b_z = float(normal[normal > 0].sum())  # Eq. 23
            b_xy = float(abs(tangential[tangential > 0].sum() - traction))  # Eq. 25
            if (b_z, b_xy) < best:
                best, chosen = (b_z, b_xy), (f, float(mu_x), float(mu_y), index)
        return chosen
