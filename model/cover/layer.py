"""Exact normal stress under a loaded elastic cover: the default source of simulated frames.

The cover is a linear elastic block, bonded to a rigid base at z = 0 (all displacements vanish), loaded by the
contacts' tractions at z = h and held by rollers at its four sides (no normal displacement, no shear), as in
the paper's finite-element model (Section 4).  The rollers are met by mirroring the load at each side: q_z and
sigma_zz become cosine series, q_x a sine series in x and a cosine series in y, q_y the reverse.

Every wave vector (kx, ky) with k = hypot(kx, ky), H = k h is then a problem of its own in z.  Its four
constants of integration are fixed by two displacements at the base and two tractions at the top; the part
with displacement across the wave vector carries no sigma_zz and drops out.  Eliminated by hand,

    sigma_zz(0) = n [(n cosh H + H sinh H) q_z + (m sinh H + H cosh H) t] / D,
    D = (3 - 4 nu) cosh^2 H + H^2 + m^2,    n = 2 (1 - nu),    m = 1 - 2 nu,    t = (kx q_x + ky q_y) / k,

with q_z, q_x, q_y the amplitudes of cos cos, sin cos and cos sin.  Young's modulus drops out.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from tfra.model.arrays import Floats
from tfra.model.cover.contact import Contact, Contacts, ContactShape
from tfra.model.sensor import SensorArray, require_finite

Sampling = Literal["point", "area"]

TRUNCATION = 1e-10
"""Bound on the contribution of omitted modes to b_z, relative to max(1, mu) |F_z| / (size_x size_y).

F_z / (size_x size_y) is the mean of b_z over the base: for mu <= 1 the bound also holds relative to the peak.
"""

_CHUNK = 1 << 16  # entries of one (contacts, modes in x, modes in y) temporary: 512 KiB, so that a few stay in a cache
_SLACK = 1e-9  # share of the block's size by which rounding may push a footprint or window over the side


@dataclass(frozen=True, slots=True)
class ElasticLayer:
    """A bonded elastic block with roller sides: extents, height h, Poisson's ratio and lowest corner; lengths in m.

    Raises ``ValueError`` naming the field for a value that is not finite, for lengths that are not positive, and for a
    ratio outside -1 < nu <= 0.5; 0.5 (incompressible) is fine.
    """

    size_x: float
    size_y: float
    thickness: float
    poisson: float
    origin_x: float
    origin_y: float

    def __post_init__(self) -> None:
        require_finite(self, "size_x", "size_y", "thickness")
        require_finite(self, "poisson", needed="a value in (-1, 0.5]", good=lambda value: -1.0 < value <= 0.5)
        require_finite(self, "origin_x", "origin_y", needed="a finite coordinate", good=lambda value: True)

    @classmethod
    def under(
        cls, sensor: SensorArray, poisson: float = 0.48, thickness: float | None = None, margin: float = 0.0
    ) -> "ElasticLayer":
        """Return the cover of ``sensor``, of another ``thickness`` if given: ``margin`` beyond its outer cells."""
        sizes, height = (sensor.size_x + 2 * margin, sensor.size_y + 2 * margin), thickness or sensor.thickness
        return cls(*sizes, height, poisson, -sensor.pitch_x / 2 - margin, -sensor.pitch_y / 2 - margin)

    @property
    def modes(self) -> int:
        """Number of modes of the series; memory and time of a frame are proportional to it."""
        return math.prod(_counts(self))

    def transfer(self, k: npt.ArrayLike) -> tuple[Floats, Floats]:
        """Return sigma_zz at the base per unit of q_z and of t (see the module's equation) at k >= 0, rad/m.

        Both are dimensionless with the shape of ``k``; they tend to 1 and to k h for k -> 0 and decay like
        k h exp(-k h).  Exponentials are scaled by exp(-k h), so nothing overflows.
        """
        height = np.asarray(k, dtype=np.float64) * self.thickness
        n, m = 2.0 * (1.0 - self.poisson), 1.0 - 2.0 * self.poisson
        square = np.exp(-2.0 * height)
        cosh, sinh = 0.5 * (1.0 + square), -0.5 * np.expm1(-2.0 * height)  # both times exp(-H)
        determinant = (3.0 - 4.0 * self.poisson) * cosh**2 + (height**2 + m * m) * square
        scale = n * np.exp(-height) / determinant
        return scale * (n * cosh + height * sinh), scale * (m * sinh + height * cosh)

    def base_stress(
        self,
        contacts: Sequence[Contact] | Contacts,
        x: npt.ArrayLike,
        y: npt.ArrayLike,
        window: tuple[float, float] = (0.0, 0.0),
    ) -> Floats:
        """Return the normal stress b_z at the base, ``(len(contacts), len(y), len(x))``, Pa, compression negative.

        Each contact is a frame of its own; ``x`` and ``y`` are the grid's columns and rows, m, and ``window`` the sides
        of the rectangle about each point to average over, zero for point values.  Modes reach up to ``TRUNCATION``.
        Raises ``ValueError`` if a footprint (named by the contact's index and the field), a point or a window leaves
        the block, or if ``x`` or ``y`` is not one-dimensional.
        """
        loads, modes = Contacts.of(contacts), _modes(self)
        self._check_footprints(loads)
        waves_x = _sampled_cosines(modes.kx, x, window[0], self.origin_x, self.size_x, "x")
        waves_y = _sampled_cosines(modes.ky, y, window[1], self.origin_y, self.size_y, "y")
        center = loads.center - (self.origin_x, self.origin_y)
        result = np.empty((len(loads), waves_y.shape[0], waves_x.shape[0]))
        step = max(1, _CHUNK // modes.normal.size)
        for shape in ContactShape:
            which = np.flatnonzero(loads.shape == shape.value)
            for rows in (which[start : start + step] for start in range(0, len(which), step)):
                part = center[rows], loads.half[rows], loads.force[rows]
                result[rows] = _superpose(modes, shape, *part, waves_x, waves_y)
        return result

    def influence(self, x: npt.ArrayLike, y: npt.ArrayLike, load: tuple[float, float]) -> tuple[Floats, Floats, Floats]:
        """Return b_z at each point of a grid per newton along x, y, z at each point, ``(points, points)`` each, 1/m^2.

        ``x`` and ``y`` as for ``base_stress``; points are row-major, row = stress, column = force.  A force is spread
        evenly over a rectangle with the sides ``load``, in m, about its point.  Raises ``ValueError`` as
        ``base_stress`` does for grid points and windows.
        """
        modes = _modes(self)
        pairs_x = _pairs(modes.kx, x, load[0], self.origin_x, self.size_x, "x")
        pairs_y = _pairs(modes.ky, y, load[1], self.origin_y, self.size_y, "y")

        def superposed(weight: Floats, along_x: Floats, along_y: Floats) -> Floats:
            columns, rows = len(along_x), len(along_y)
            across = np.tensordot(along_y, weight, axes=(2, 1))
            whole = np.tensordot(across, along_x, axes=(2, 2))
            return np.ascontiguousarray(whole.transpose(0, 2, 1, 3)).reshape(rows * columns, rows * columns)

        straight = superposed(modes.normal, pairs_x[0], pairs_y[0])
        shear_x = superposed(modes.tangential, pairs_x[1], pairs_y[0])
        shear_y = superposed(modes.tangential, pairs_x[0], pairs_y[1])
        return shear_x, shear_y, straight

    def _check_footprints(self, loads: Contacts) -> None:
        low, size = np.array([self.origin_x, self.origin_y]), np.array([self.size_x, self.size_y])
        under = loads.center - loads.half < low - _SLACK * size
        over = loads.center + loads.half > low + size * (1 + _SLACK)
        if len(outside := np.argwhere(under | over)):
            index, axis = outside[0]
            raise ValueError(
                f"contact {index}: center_{'xy'[axis]}: the footprint {loads.center[index, axis]:g} +- "
                f"{loads.half[index, axis]:g} m (half_{'xy'[axis]}) "
                f"leaves the block from {low[axis]:g} to {low[axis] + size[axis]:g} m"
            )


def frames(
    sensor: SensorArray,
    contacts: Sequence[Contact] | Contacts,
    sampling: Sampling = "point",
    poisson: float = 0.48,
) -> Floats:
    """Return the frames an ideal array reports, shape ``(n, rows, columns)``, Pa, compression negative.

    ``sampling`` is ``"point"`` for b_z at the taxel centres or ``"area"`` for its mean over each taxel's
    pitch_x x pitch_y cell.  Raises ``ValueError`` for another sampling and as ``ElasticLayer.base_stress``.
    """
    if sampling not in ("point", "area"):
        raise ValueError(f'sampling: "point" or "area" is needed, got {sampling!r}')
    window = (sensor.pitch_x, sensor.pitch_y) if sampling == "area" else (0.0, 0.0)
    x, y = np.arange(sensor.columns) * sensor.pitch_x, np.arange(sensor.rows) * sensor.pitch_y
    return ElasticLayer.under(sensor, poisson).base_stress(contacts, x, y, window)


class _Modes(NamedTuple):
    """Wavenumbers of the two series and transfer functions on their grid, weights of the series included.

    ``tangential`` is the transfer function of t over k, so that kx and ky stay separable factors.
    """

    kx: Floats  # (p,) rad/m
    ky: Floats  # (q,) rad/m
    normal: Floats  # (p, q) 1/m^2
    tangential: Floats  # (p, q) 1/m


@lru_cache(maxsize=16)
def _modes(layer: ElasticLayer) -> _Modes:
    count_x, count_y = _counts(layer)
    kx = np.asarray(np.arange(count_x) * (math.pi / layer.size_x))
    ky = np.asarray(np.arange(count_y) * (math.pi / layer.size_y))
    k = np.hypot(kx[:, None], ky)
    normal, tangential = layer.transfer(k)
    slope = np.divide(tangential, k, out=np.zeros_like(k), where=k > 0)  # at k = 0 kx, ky vanish
    # of a cosine series on [0, size]: 1 for the mean, 2 for the rest
    weight = np.outer(np.where(kx > 0, 2.0, 1.0), np.where(ky > 0, 2.0, 1.0)) / (layer.size_x * layer.size_y)
    modes = _Modes(kx, ky, weight * normal, weight * slope)
    for array in modes:
        array.flags.writeable = False
    return modes


def _counts(layer: ElasticLayer) -> tuple[int, int]:
    """Modes along x and along y up to the smallest k h, in quarters, above which all stay below ``TRUNCATION``."""
    spacing = math.pi * layer.thickness * math.hypot(1 / layer.size_x, 1 / layer.size_y)
    cutoff = max(4.0, math.floor(4 * spacing) / 4)  # below, the bound is infinite
    while _tail(layer, cutoff) > TRUNCATION:
        cutoff += 0.25
    k = cutoff / layer.thickness
    return math.floor(k * layer.size_x / math.pi) + 1, math.floor(k * layer.size_y / math.pi) + 1


def _tail(layer: ElasticLayer, cutoff: float) -> float:
    """Bound the sum over all modes with k h > cutoff of weight times |normal| + |tangential| transfer.

    With H = k h both transfers together stay below g(H) = 2 n (n + m + 2 H) exp(-H) / (3 - 4 nu), which falls
    for H > 1.  A lattice sum of a falling function is below the integral over the cells towards the origin:
    weight 4 over a quarter plane for kx, ky > 0 and weight 2 along each axis.
    """
    n, m = 2.0 * (1.0 - layer.poisson), 1.0 - 2.0 * layer.poisson
    dx, dy = math.pi * layer.thickness / layer.size_x, math.pi * layer.thickness / layer.size_y
    start = cutoff - math.hypot(dx, dy)
    if start <= 1.0:
        return math.inf
    plane = (n + m) * (start + 1.0) + 2.0 * (start * start + 2.0 * start + 2.0)
    line = n + m + 2.0 * start + 2.0
    scale = 2.0 * n / (3.0 - 4.0 * layer.poisson) * math.exp(-start)
    return scale * (2.0 * math.pi / (dx * dy) * plane + 2.0 * (1.0 / dx + 1.0 / dy) * line)


def _sampled_cosines(k: Floats, at: npt.ArrayLike, width: float, low: float, size: float, name: str) -> Floats:
    """cos(k (at - low)) averaged over ``width``, shape ``(len(at), len(k))``."""
    points = np.asarray(at, dtype=np.float64)
    if points.ndim != 1:
        raise ValueError(f"{name}: a one-dimensional array is needed, got shape {points.shape}")
    if not (math.isfinite(width) and width >= 0):
        raise ValueError(f"window: a finite width >= 0 along {name} is needed, got {width}")
    place = points - low
    inside = (place - width / 2 >= -_SLACK * size) & (place + width / 2 <= size * (1 + _SLACK))
    if not inside.all():
        raise ValueError(f"{name}: points (with their window) must lie from {low:g} to {low + size:g} m")
    return np.asarray(np.cos(np.outer(place, k)) * np.sinc(k * (width / (2 * np.pi))))


def _pairs(k: Floats, at: npt.ArrayLike, width: float, low: float, size: float, name: str) -> tuple[Floats, Floats]:
    """Products of the cosine at each point with the load at each, ``(len(at), len(at), len(k))``.

    The load is even about its point; the second array is for a load along the axis, as sine times k.
    """
    cosines = _sampled_cosines(k, at, 0.0, low, size, name)
    even = _sampled_cosines(k, at, width, low, size, name)
    odd = np.sin(np.outer(np.asarray(at) - low, k)) * np.sinc(k * (width / (2 * np.pi))) * k
    return cosines[:, None] * even, cosines[:, None] * odd


def _superpose(
    modes: _Modes, shape: ContactShape, center: Floats, half: Floats, forces: Floats, waves_x: Floats, waves_y: Floats
) -> Floats:
    """Sum the series of n contacts of one ``shape`` at (rows, columns) points: shape ``(n, rows, columns)``.

    ``center (n, 2)`` is relative to the block's corner; ``half (n, 2)``, ``forces (n, 3)``.  The load's phases and the
    samples' cosines are separable, so with the (n, p, q) spectrum in the middle

        b_z = F_z Cx N Cy' + F_x Sx T Cy' + F_y Cx T Sy',    Sx, Sy including kx, ky.
    """
    sides = half[:, :, None]
    spectrum = shape.transform((sides[:, 0] * modes.kx)[:, :, None], (sides[:, 1] * modes.ky)[:, None, :])
    force = forces[:, :, None, None]
    phase_x = center[:, :1] * modes.kx
    phase_y = center[:, 1:] * modes.ky
    cos_x = np.cos(phase_x)[:, None, :] * waves_x
    sin_x = (np.sin(phase_x) * modes.kx)[:, None, :] * waves_x
    cos_y = (np.cos(phase_y)[:, None, :] * waves_y).transpose(0, 2, 1)
    sin_y = (np.sin(phase_y) * modes.ky)[:, None, :] * waves_y
    sheared = spectrum * modes.tangential
    straight = force[:, 2] * (spectrum * modes.normal @ cos_y)
    straight += force[:, 1] * (sheared @ sin_y.transpose(0, 2, 1))
    across = force[:, 0] * (sheared @ cos_y)
    return np.asarray((cos_x @ straight + sin_x @ across).transpose(0, 2, 1))
