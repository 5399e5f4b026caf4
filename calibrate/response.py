"""Stress under presses, and how it changes with what is unknown of them: the model that a calibration fits.

A press is a round body on an elastic layer (:mod:`tfra.model.cover.layer`) whose sides are rollers, at the outer cells
of the array or further out.
"""

import math
from dataclasses import dataclass
from enum import StrEnum
from functools import cached_property
from typing import NamedTuple

import numpy as np

from tfra.model.arrays import Bools, Floats
from tfra.model.cover.contact import ContactShape
from tfra.model.cover.layer import ElasticLayer
from tfra.model.sensor import SensorArray

CUTOFF = 12.0
"""Largest k h of the modes, with the thickness in CONFIG; those above add less than 1e-3 of the peak."""

STIFFEST, SOFTEST = 0.3, 0.5
"""Limits of Poisson's ratio; rubber is at 0.45 to 0.5."""

_STEP = 1e-5
"""Of the difference quotients by thickness and Poisson's ratio."""


class Indenter(StrEnum):
    """What presses: a ball, a rigid flat punch of known radius, or a finger, a ball of unknown radius."""

    BALL = "ball"
    FLAT = "flat"
    FINGER = "finger"


class Presses(NamedTuple):
    """n presses: places and radii of their contacts, m; forces ``(n, 3)``, N; the normal ones are negative."""

    x: Floats
    y: Floats
    log_radius: Floats
    force: Floats
    flat: Bools


class Stress(NamedTuple):
    """Stress in Pa, ``(n, m)``, compression negative, and its derivatives by what is named.

    Those by logarithms, and by Poisson's ratio, are in Pa, by places in Pa/m, by ``force`` ``(3, n, m)`` in 1/m^2.
    """

    value: Floats
    log_thickness: Floats
    poisson: Floats
    x: Floats
    y: Floats
    log_radius: Floats
    force: Floats


_Factors = tuple[tuple[Floats, ...], tuple[Floats, ...]]
"""Products with the cosines at the taxels ``(n, taxels, p)``, of normal loads and of those along the axis."""


class _Line(NamedTuple):
    """The series along an axis: wavenumbers ``(p,)``, origin, and cosines at the taxels ``(taxels, p)``."""

    k: Floats
    origin: float
    cosines: Floats

    def factors(self, places: Floats) -> _Factors:
        """Those of loads at ``places (n,)``, and their derivatives by the place."""
        phase = (places - self.origin)[:, None] * self.k
        cosine, sine = np.cos(phase), self.k * np.sin(phase)
        pairs = ((cosine, sine), (-sine, self.k**2 * cosine))
        values, derivatives = (tuple(factor[:, None, :] * self.cosines for factor in pair) for pair in pairs)
        return values, derivatives


class _Transfer(NamedTuple):
    """Transfer functions on the modes ``(q, p)``, weights of the series included; of tangential loads over k."""

    normal: Floats
    tangential: Floats


@dataclass(frozen=True)
class Response:
    """What presses on ``sensor`` do, whose cover continues for a ``margin`` in m beyond its outer cells."""

    sensor: SensorArray
    margin: float

    def __call__(self, log_thickness: float, poisson: float, presses: Presses) -> Stress:
        """The stress of ``presses`` under a cover of this thickness, its logarithm in m, and Poisson's ratio."""
        transfer = self._transfer(log_thickness, poisson)
        thicker = _slope(transfer, self._transfer(log_thickness + _STEP, poisson), _STEP)
        softer = _slope(transfer, self._transfer(log_thickness, poisson - _STEP), -_STEP)
        lines = [line.factors(places) for line, places in zip(self._lines, (presses.x, presses.y), strict=True)]
        profile, wider = _profiles(self._k * np.exp(presses.log_radius)[:, None, None], presses.flat)
        parts = self._parts(profile, transfer, lines)
        force = presses.force.T[:, :, None]

        def of(parts: Floats) -> Floats:
            return np.asarray((force * parts).sum(axis=0))

        return Stress(
            value=of(parts),
            log_thickness=of(self._parts(profile, thicker, lines)),
            poisson=of(self._parts(profile, softer, lines)),
            x=of(self._parts(profile, transfer, lines, along_x=1)),
            y=of(self._parts(profile, transfer, lines, along_y=1)),
            log_radius=of(self._parts(wider, transfer, lines)),
            force=parts,
        )

    def _parts(
        self, profile: Floats, transfer: _Transfer, lines: list[_Factors], along_x: int = 0, along_y: int = 0
    ) -> Floats:
        """Stress per newton along x, y and z, ``(3, n, m)`` in 1/m^2, or its derivative by the place."""
        (even_x, odd_x), (even_y, odd_y) = lines[0][along_x], lines[1][along_y]
        sheared, straight = profile * transfer.tangential, profile * transfer.normal
        found = (
            (even_y @ sheared) @ odd_x.transpose(0, 2, 1),
            (odd_y @ sheared) @ even_x.transpose(0, 2, 1),
            (even_y @ straight) @ even_x.transpose(0, 2, 1),
        )
        return np.stack(found).reshape(3, len(profile), self.sensor.taxels)

    def _transfer(self, log_thickness: float, poisson: float) -> _Transfer:
        layer = ElasticLayer(*self._sizes, math.exp(log_thickness), poisson, 0.0, 0.0)
        normal, tangential = layer.transfer(self._k)
        slope = np.divide(tangential, self._k, out=np.zeros_like(tangential), where=self._k > 0)
        return _Transfer(self._weights * normal, self._weights * slope)

    @property
    def _sizes(self) -> tuple[float, float]:
        return self.sensor.size_x + 2 * self.margin, self.sensor.size_y + 2 * self.margin

    @cached_property
    def _lines(self) -> tuple[_Line, _Line]:
        found = []
        for size, pitch, count in zip(
            self._sizes,
            (self.sensor.pitch_x, self.sensor.pitch_y),
            (self.sensor.columns, self.sensor.rows),
            strict=True,
        ):
            k = np.arange(0.0, CUTOFF / self.sensor.thickness, math.pi / size)
            origin = -pitch / 2 - self.margin
            found.append(_Line(k, origin, np.cos(np.outer(np.arange(count) * pitch - origin, k))))
        return found[0], found[1]

    @cached_property
    def _k(self) -> Floats:
        line_x, line_y = self._lines
        return np.asarray(np.hypot(line_x.k, line_y.k[:, None]))

    @cached_property
    def _weights(self) -> Floats:
        """Of a cosine series on the block: 1 for the mean, 2 for the rest."""
        line_x, line_y = self._lines
        weights = np.outer(np.where(line_y.k > 0, 2.0, 1.0), np.where(line_x.k > 0, 2.0, 1.0))
        return np.asarray(weights / math.prod(self._sizes))


def _slope(here: _Transfer, there: _Transfer, step: float) -> _Transfer:
    """The difference quotient of the transfer functions."""
    return _Transfer(*((b - a) / step for a, b in zip(here, there, strict=True)))


def _profiles(s: Floats, flat: Bools) -> tuple[Floats, Floats]:
    """Transforms of the pressure of 1 N at ``s (n, q, p)``, k times the radius, and their derivatives by log s.

    A rigid flat punch has sin(s)/s (Boussinesq); a ball :class:`ContactShape`'s, 3 (sin s - s cos s)/s^3.
    """
    sinc = np.sinc(s / np.pi)
    ball = ContactShape.HERTZ.transform(s, 0.0)
    which = flat[:, None, None]
    return np.where(which, sinc, ball), np.where(which, np.cos(s) - sinc, 3.0 * (sinc - ball))
