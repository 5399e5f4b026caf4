"""Stress under contacts by TFRA's own kernel (Eq. 5), as an elastic half-space would have it, by quadrature."""

import numpy as np
from scipy import special

from tfra.model.arrays import Floats
from tfra.model.cover.contact import Contacts, ContactShape
from tfra.model.sensor import SensorArray


def nodes(shape: ContactShape, order: int) -> tuple[Floats, Floats, Floats]:
    """u, v in [-1, 1] and weights of sum 1, ``(order^2,)`` each: Gauss points of the shape's own profile.

    The root at the edge of ``hertz`` goes by u = r cos t, v = r sin t with s = sqrt(1 - r^2): the load is
    3 s^2 ds dt / (2 pi), smooth in both.  That of ``rounded`` is the weight of Chebyshev's second kind.
    """
    if shape is ContactShape.HERTZ:
        x, w = np.polynomial.legendre.leggauss(order)
        s, t = (x[:, None] + 1) / 2, 2 * np.pi * np.arange(order) / order
        r = np.sqrt(1 - s * s)
        weight = 1.5 * w[:, None] * s * s / order * np.ones(order)
        return (r * np.cos(t)).ravel(), (r * np.sin(t)).ravel(), weight.ravel()
    x, w = special.roots_chebyu(order) if shape is ContactShape.ROUNDED else np.polynomial.legendre.leggauss(order)
    u, v = np.meshgrid(x, x)
    return u.ravel(), v.ravel(), np.outer(w, w).ravel() / w.sum() ** 2


def half_space(sensor: SensorArray, contacts: Contacts, order: int = 48) -> Floats:
    """b_z at the taxels' centres, ``(n, rows, columns)`` in Pa, at depth h of a half-space without walls."""
    x, y = (p[:, None] for p in sensor.positions())
    stress = np.empty((len(contacts), sensor.taxels))
    loads = zip(contacts.shape, contacts.center, contacts.half, contacts.force, strict=True)
    for row, (shape, center, half, (f_x, f_y, f_z)) in zip(stress, loads, strict=True):
        u, v, weight = nodes(ContactShape(shape), order)
        rx, ry = center[0] + half[0] * u - x, center[1] + half[1] * v - y
        h = sensor.thickness
        c0 = 3 * h * h / (2 * np.pi * (rx * rx + ry * ry + h * h) ** 2.5)  # Eq. 5
        row[:] = (c0 * (rx * f_x + ry * f_y + h * f_z)) @ weight
    return stress.reshape(-1, sensor.rows, sensor.columns)
