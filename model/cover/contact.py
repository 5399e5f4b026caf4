"""Static contacts: shape, place and resultant of a load on the cover of the array, and its part on each taxel."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy import special

from tfra.model.arrays import Floats
from tfra.model.sensor import SensorArray, require_finite
from tfra.runtime.errors import quoted


class ContactShape(StrEnum):
    """Distribution of the pressure, in the scaled coordinates u = x / half_x, v = y / half_y.

    =========  =========  ==================================  =================================
    Name       Footprint  Pressure ~                          Unit-force transform, s = k half
    =========  =========  ==================================  =================================
    hertz      ellipse    sqrt(1 - u^2 - v^2)                 3 (sin s - s cos s) / s^3
    uniform    rectangle  1                                   sin(s_x)/s_x * sin(s_y)/s_y
    rounded    rectangle  sqrt(1 - u^2) sqrt(1 - v^2)         2 J1(s_x)/s_x * 2 J1(s_y)/s_y
    =========  =========  ==================================  =================================

    For the ellipse s = hypot(s_x, s_y).
    """

    HERTZ = "hertz"
    UNIFORM = "uniform"
    ROUNDED = "rounded"

    def transform(self, s_x: npt.ArrayLike, s_y: npt.ArrayLike) -> Floats:
        """Return the cosine transform of the unit-force profile at s_x = kx half_x, s_y = ky half_y.

        That is the integral of p(x, y) cos(kx x) cos(ky y) about the centre; the sine parts vanish, as every shape is
        even in x and in y.  Dimensionless, 1 at s = 0 and never larger in magnitude.  The arguments broadcast.
        """
        return _PROFILES[self].transform(np.asarray(s_x, dtype=np.float64), np.asarray(s_y, dtype=np.float64))

    def density(self, u: npt.ArrayLike, v: npt.ArrayLike) -> Floats:
        """Return the profile at (u, v), scaled to integral 1 over the plane; zero off the footprint."""
        return _PROFILES[self].density(np.asarray(u, dtype=np.float64), np.asarray(v, dtype=np.float64))

    def gathered(self, u: npt.ArrayLike, v: npt.ArrayLike) -> Floats:
        """Return the integral of the profile over [0, u] x [0, v]: odd in u and in v, 1/4 beyond the corner (1, 1)."""
        inside = (np.clip(np.asarray(w, dtype=np.float64), -1.0, 1.0) for w in (u, v))
        return _PROFILES[self].integral(*inside)


@dataclass(frozen=True, slots=True)
class Contact:
    """One contact on the cover; SI units and radians.

    The normal load is compressive, q_z < 0, and the tangential load is proportional to it (Eq. 32):
    ``(q_x, q_y) = mu |q_z| (cos phi, sin phi)``, so that ``F_x = mu |F_z| cos phi`` and ``F_y = mu |F_z| sin phi``
    as in the paper's Tables 1 and 2.  Eqs. 13, 14 and 32 print F_z and q_z without the modulus; with F_z < 0 that
    would turn phi by 180 degrees against the tables and against Eq. 11.

    ``shape`` is a ``ContactShape`` or its name; the centre of the footprint, origin in the first taxel, and its
    semi-axes or half sides > 0 are in m; F_z < 0 in N, mu >= 0 is the ratio of the tangential to the normal resultant
    (Eq. 15), phi the direction of the former from the x axis.  Raises ``ValueError`` naming the field for other values.
    """

    shape: ContactShape
    center_x: float
    center_y: float
    half_x: float
    half_y: float
    normal_force: float
    mu: float
    phi: float

    def __post_init__(self) -> None:
        try:
            object.__setattr__(self, "shape", ContactShape(self.shape))
        except ValueError:
            known = ", ".join(ContactShape)
            raise ValueError(f"shape: one of {known} is needed, got {quoted(self.shape)}") from None
        require_finite(self, "center_x", "center_y", "phi", needed="a finite number", good=lambda value: True)
        require_finite(self, "half_x", "half_y")
        force = "a negative (compressive), finite force"
        require_finite(self, "normal_force", needed=force, good=lambda value: value < 0)
        require_finite(self, "mu", needed="a finite number >= 0", good=lambda value: value >= 0)

    @property
    def force(self) -> tuple[float, float, float]:
        """Resultant (F_x, F_y, F_z) on the cover, N."""
        tangential = self.mu * abs(self.normal_force)
        return tangential * math.cos(self.phi), tangential * math.sin(self.phi), self.normal_force

    def pressure(self, x: npt.ArrayLike, y: npt.ArrayLike) -> Floats:
        """Return the contact pressure -q_z >= 0 at (x, y), Pa; ``x`` and ``y`` in m broadcast."""
        u = np.subtract(x, self.center_x) / self.half_x
        v = np.subtract(y, self.center_y) / self.half_y
        return abs(self.normal_force) / (self.half_x * self.half_y) * self.shape.density(u, v)

    def tractions(self, x: npt.ArrayLike, y: npt.ArrayLike) -> Floats:
        """Return (q_x, q_y, q_z) of Eq. 32 at (x, y), Pa, in an array of shape ``(3, ...)``."""
        pressure = self.pressure(x, y)
        tangential = self.mu * pressure
        return np.stack([tangential * math.cos(self.phi), tangential * math.sin(self.phi), -pressure])


@dataclass(frozen=True)
class Contacts:
    """Many contacts as arrays, for mixtures too large for an object each; nothing is checked here.

    Attributes:
        shape: Names of the ``ContactShape``, ``(n,)``.
        center, half: Centres and half sizes along x and y, ``(n, 2)``, m.
        force: Resultants, ``(n, 3)``, N.
    """

    shape: npt.NDArray[np.str_]
    center: Floats
    half: Floats
    force: Floats

    @classmethod
    def of(cls, contacts: "Sequence[Contact] | Contacts") -> "Contacts":
        """The same contacts as arrays."""
        return contacts if isinstance(contacts, Contacts) else cls(
            np.array([c.shape.value for c in contacts], dtype=np.str_),
            np.array([(c.center_x, c.center_y) for c in contacts], dtype=np.float64).reshape(-1, 2),
            np.array([(c.half_x, c.half_y) for c in contacts], dtype=np.float64).reshape(-1, 2),
            np.array([c.force for c in contacts], dtype=np.float64).reshape(-1, 3),
        )

    def __len__(self) -> int:
        return len(self.shape)


def _hertz_transform(s_x: Floats, s_y: Floats) -> Floats:
    """3 (sin s - s cos s) / s^3 with s = hypot(s_x, s_y).

    Below s = 0.5, where the difference cancels, six terms of the series 3 sum_j (-s^2)^j (2j + 2) / (2j + 3)!
    leave less than 1e-14.
    """
    square = s_x * s_x + s_y * s_y
    small = square < 0.25
    s = np.sqrt(np.where(small, 1.0, square))
    result = np.asarray(3.0 * (np.sin(s) - s * np.cos(s)) / (s * s * s))
    result[small] = np.polynomial.polynomial.polyval(square[small], _HERTZ_SERIES)
    return result


_HERTZ_SERIES = [3.0 * (-1) ** j * (2 * j + 2) / math.factorial(2 * j + 3) for j in range(6)]


def _jinc(s: Floats) -> Floats:
    """2 J1(s) / s, which rounds to 1 below s = 1e-8 (j1 itself loses digits near 1e-308)."""
    small = np.abs(s) < 1e-8
    safe = np.where(small, 1.0, s)
    return np.asarray(np.where(small, 1.0, 2.0 * special.j1(safe) / safe))


def _hertz_integral(u: Floats, v: Floats) -> Floats:
    """The volume under the hemisphere, cut by two planes, in closed form; |u|, |v| <= 1.

    Where the corner (u, v) lies off the ellipse the same formula holds with a root of zero: what is beyond each edge
    is then a cap of its own.
    """
    root = np.sqrt(np.maximum(0.0, 1.0 - u * u - v * v))
    a, b = np.abs(u), np.abs(v)
    sides = (a - a**3 / 3.0) * np.arctan2(b, root) + (b - b**3 / 3.0) * np.arctan2(a, root)
    volume = a * b * root / 3.0 + sides / 2.0 - np.arctan2(a * b, root) / 3.0
    return np.asarray(np.copysign(1.5 / np.pi, u * v) * volume)


class _Profile(NamedTuple):
    """A profile of unit force: its transform, the profile itself, and its integral from (0, 0)."""

    transform: Callable[[Floats, Floats], Floats]
    density: Callable[[Floats, Floats], Floats]
    integral: Callable[[Floats, Floats], Floats]

    @classmethod
    def product(cls, *lines: Callable[[Floats], Floats]) -> "_Profile":
        """A profile that is the product of two equal ones along a line, given by its own three functions."""
        return cls(*((lambda u, v, line=line: line(u) * line(v)) for line in lines))


_PROFILES = {
    ContactShape.HERTZ: _Profile(
        _hertz_transform, lambda u, v: 1.5 / np.pi * np.sqrt(np.maximum(0.0, 1.0 - u * u - v * v)), _hertz_integral
    ),
    ContactShape.UNIFORM: _Profile.product(
        lambda s: np.sinc(s / np.pi), lambda u: np.where(np.abs(u) <= 1.0, 0.5, 0.0), lambda u: 0.5 * u
    ),
    ContactShape.ROUNDED: _Profile.product(
        _jinc,
        lambda u: 2.0 / np.pi * np.sqrt(np.maximum(0.0, 1.0 - u * u)),
        lambda u: (u * np.sqrt(1.0 - u * u) + np.arcsin(u)) / np.pi,
    ),
}


def cell_shares(sensor: SensorArray, contacts: Sequence[Contact] | Contacts) -> Floats:
    """Return the share of each contact's load on each taxel's pitch_x x pitch_y cell, ``(n, rows, columns)``.

    The cells tile the block, so that the shares of a contact inside it add up to 1.  No quadrature: profiles are
    integrated in closed form (:meth:`ContactShape.gathered`).
    """
    loads = Contacts.of(contacts)
    x = (np.arange(sensor.columns + 1) - 0.5) * sensor.pitch_x
    y = (np.arange(sensor.rows + 1) - 0.5) * sensor.pitch_y
    shares = np.empty((len(loads), sensor.rows, sensor.columns))
    for shape in ContactShape:
        which = np.flatnonzero(loads.shape == shape.value)
        center, half = loads.center[which, :, None], loads.half[which, :, None]
        u, v = (x - center[:, 0]) / half[:, 0], (y - center[:, 1]) / half[:, 1]
        corners = shape.gathered(u[:, None, :], v[:, :, None])
        shares[which] = np.diff(np.diff(corners, axis=1), axis=2)
    return np.maximum(shares, 0.0)  # rounding leaves some below


def taxel_forces(sensor: SensorArray, contacts: Sequence[Contact] | Contacts) -> Floats:
    """Return the load on each taxel's cell, the f of Eq. 3: ``(n, 3, rows, columns)`` in N."""
    loads = Contacts.of(contacts)
    return np.asarray(loads.force[:, :, None, None] * cell_shares(sensor, loads)[:, None])
