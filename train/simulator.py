"""Fast frames of the elastic layer for any pressure: the loads are grids of point forces.

The layer is a low pass: at a wavenumber k its response falls like k h exp(-k h).  So point forces that are closer
than ``SPACING`` thicknesses act like the pressure between them.  Nothing here knows a shape.  The exact series
(:mod:`tfra.model.cover.layer`), which gives the held-out frames, shares only its transfer functions.
Three stresses are kept for a load, those of unit forces along each axis, since every friction and direction
combines them linearly.
"""

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from tfra.model.arrays import Floats, Singles
from tfra.model.cover.layer import ElasticLayer
from tfra.model.sensor import SensorArray

SPACING = 0.25
"""Largest distance of point forces, in thicknesses; what their grid adds is then below exp(-20)."""

CUTOFF = 12.0
"""Largest k h of the modes; those above add less than 1e-3 of the peak."""


@dataclass(frozen=True, slots=True)
class Cover:
    """A layer and the sides of the rectangle that a taxel averages over, m; zero for one that samples a point."""

    layer: ElasticLayer
    window: tuple[float, float]


class Grids(NamedTuple):
    """Loads of 1 N as point forces: ``x (n, q)``, ``y (n, q)`` in m, shares ``(n, q, q)`` with y before x."""

    x: Floats
    y: Floats
    pressure: Floats
    traction: Floats


class _Modes(NamedTuple):
    """Wavenumbers, transfer functions with the weights of the series (``tangential`` over k), cosines at taxels."""

    kx: Singles  # (p,)
    ky: Singles  # (q,)
    normal: Singles  # (q, p)
    tangential: Singles  # (q, p)
    waves_x: Singles  # (p, columns)
    waves_y: Singles  # (rows, q)


def grid_count(longest: float, thickness: float) -> int:
    """Return how many points a side of ``longest`` metres needs, at least 24."""
    return max(24, math.ceil(longest / (SPACING * thickness)))


def responses(sensor: SensorArray, cover: Cover, loads: Grids) -> Singles:
    """Return the normal force at every taxel for a resultant of 1 N along x, along y and into the cover.

    Shape ``(n, 3, rows, columns)``: b pitch_x pitch_y in N, compression negative.
    """
    modes = _modes(sensor, cover)
    phase_x = (loads.x - cover.layer.origin_x).astype(np.float32)[:, :, None] * modes.kx
    phase_y = (loads.y - cover.layer.origin_y).astype(np.float32)[:, None, :] * modes.ky[:, None]
    pressure, traction = loads.pressure.astype(np.float32), loads.traction.astype(np.float32)
    cos_x, cos_y = np.cos(phase_x), np.cos(phase_y)
    along_x = (cos_y @ (traction @ np.sin(phase_x))) * (modes.tangential * modes.kx)
    along_y = (np.sin(phase_y) @ (traction @ cos_x)) * (modes.tangential * modes.ky[:, None])
    into = -(cos_y @ (pressure @ cos_x)) * modes.normal
    spectra = np.stack([along_x, along_y, into], axis=1)
    return np.asarray(modes.waves_y @ (spectra @ modes.waves_x) * np.float32(sensor.taxel_area))


@lru_cache(maxsize=2)
def _modes(sensor: SensorArray, cover: Cover) -> _Modes:
    layer = cover.layer
    kx, ky = (np.arange(0.0, CUTOFF / layer.thickness, math.pi / size) for size in (layer.size_x, layer.size_y))
    k = np.hypot(kx, ky[:, None])
    normal, tangential = layer.transfer(k)
    weight = np.outer(np.where(ky > 0, 2.0, 1.0), np.where(kx > 0, 2.0, 1.0)) / (layer.size_x * layer.size_y)
    slope = np.divide(tangential, k, out=np.zeros_like(k), where=k > 0)  # at k = 0 kx and ky vanish
    at_x = np.arange(sensor.columns) * sensor.pitch_x - layer.origin_x
    at_y = np.arange(sensor.rows) * sensor.pitch_y - layer.origin_y
    waves_x, waves_y = (
        np.cos(np.outer(k, at)) * np.sinc(k * (width / (2 * np.pi)))[:, None]
        for k, at, width in ((kx, at_x, cover.window[0]), (ky, at_y, cover.window[1]))
    )
    arrays = kx, ky, weight * normal, weight * slope, waves_x, waves_y.T
    return _Modes(*(array.astype(np.float32) for array in arrays))
