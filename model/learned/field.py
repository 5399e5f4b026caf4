"""Forces at the taxels for a known resultant, and how well they explain the frame: the forward model.

The cover is the elastic layer of :mod:`tfra.model.cover.layer`, each force spread evenly over its taxel's cell.  With
the normal force -p at the taxels (p >= 0) and the tangential forces mu_x p, mu_y p, the stress at the taxels is

    b = G_x mu_x p + G_y mu_y p - G_z p.

The field iterates p = max(0, -G_z^-1 (b - G_x mu_x p - G_y mu_y p)) from p = 0.  Its sum is then scaled to the normal
force, so the forces of all taxels add up to the resultant exactly.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from tfra.model.arrays import Floats
from tfra.model.cover.layer import ElasticLayer
from tfra.model.sensor import SensorArray

PASSES = 2
"""Iterations; the first one assumes no friction.  A third gains a percent of the field (docs/learned.md)."""

MOST_FRICTION = 2.0
"""Limit of mu_x and mu_y in the iteration; without it, a resultant without normal force would have no field."""


@dataclass(frozen=True, eq=False)
class Influence:
    """Matrices ``(m, m)`` of one sensor: row = stress at a taxel, column = force on a taxel's cell.

    ``x, y, z`` in 1/m^2 map forces in N to the normal stress in Pa; ``inverse`` is that of ``z``, in m^2.
    """

    x: Floats
    y: Floats
    z: Floats
    inverse: Floats


@lru_cache(maxsize=32)
def influence(sensor: SensorArray) -> Influence:
    """Every matrix of ``sensor``, by the layer's exact series; read-only and cached."""
    x, y = np.arange(sensor.columns) * sensor.pitch_x, np.arange(sensor.rows) * sensor.pitch_y
    g_x, g_y, g_z = ElasticLayer.under(sensor).influence(x, y, (sensor.pitch_x, sensor.pitch_y))
    area = sensor.taxel_area  # the inverse is derived without unit
    inverse = np.asarray(np.linalg.inv(g_z * area) * area, dtype=np.float64)
    result = Influence(g_x, g_y, g_z, inverse)
    for matrix in vars(result).values():
        matrix.setflags(write=False)
    return result


def spread(sensor: SensorArray, b: Floats, resultant: Floats) -> Floats:
    """Forces ``(n, 3, m)`` in N at the taxels for the stress ``b (n, m)`` in Pa and ``resultant (n, 3)`` in N.

    Every axis has the same distribution.  Where the iteration ends without any compression, it is uniform.
    """
    g, normal = influence(sensor), np.abs(resultant[:, 2:])
    limit = MOST_FRICTION * normal
    tangential = np.clip(resultant[:, :2], -limit, limit)
    mu = np.divide(tangential, normal, out=np.zeros_like(tangential), where=normal > 0)
    p = np.zeros_like(b)
    for _ in range(PASSES):
        sheared = mu[:, :1] * (p @ g.x.T) + mu[:, 1:] * (p @ g.y.T)
        p = np.maximum((sheared - b) @ g.inverse.T, 0.0)
    total = p.sum(axis=1, keepdims=True)
    share = np.divide(p, total, out=np.full_like(p, 1 / sensor.taxels), where=total > 0)
    return np.asarray(resultant[:, :, None] * share[:, None])


def unexplained(sensor: SensorArray, b: Floats, forces: Floats) -> Floats:
    """What ``forces (n, 3, m)`` in N leave unexplained of the stress ``b (n, m)`` in Pa: b - G f."""
    g = influence(sensor)
    return np.asarray(b - sum(forces[:, axis] @ matrix.T for axis, matrix in enumerate((g.x, g.y, g.z))))


def residual(sensor: SensorArray, b: Floats, forces: Floats) -> Floats:
    """The norm of what is ``unexplained`` over that of the stress ``b (n, m)``, ``(n,)``; 0 where b is zero."""
    left, whole = unexplained(sensor, b, forces), np.linalg.norm(b, axis=1)
    return np.asarray(np.divide(np.linalg.norm(left, axis=1), whole, out=np.zeros(len(b)), where=whole > 0))
