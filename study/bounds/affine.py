"""Affine arithmetic: errors as linear forms of bounded, independent noise, so that what cancels is not added up."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from tfra.model.arrays import Floats


@dataclass(frozen=True)
class Affine:
    """Errors ``(n, k)`` of some frames: the sum of ``matrix @ noise`` over ``terms``, each with ``|noise| <= bound``.

    A term by the name of its noise is ``matrix (n or 1, k, s)`` and ``bound (n, s)``; forms that name the same noise
    have the same bound of it.
    """

    terms: Mapping[str, tuple[Floats, Floats]]

    @classmethod
    def noise(cls, name: str, bound: Floats) -> "Affine":
        """New noise of its own within ``bound (n, k)``."""
        return cls({name: (np.eye(bound.shape[1])[None], bound)})

    def __add__(self, other: "Affine") -> "Affine":
        """The sum: matrices of the same noise add up."""
        terms = dict(self.terms)
        for name, (matrix, bound) in other.terms.items():
            terms[name] = (terms[name][0] + matrix, bound) if name in terms else (matrix, bound)
        return Affine(terms)

    def through(self, left: Floats) -> "Affine":
        """Matrices ``left (j, k)`` or ``(n, j, k)`` times the errors: exact, noise keeps its name."""
        return Affine({name: (left @ matrix, bound) for name, (matrix, bound) in self.terms.items()})

    def times(self, values: Floats) -> "Affine":
        """Errors of one column, or ``k`` of them, times ``values (n, k)``, place by place: exact."""
        return Affine({name: (values[:, :, None] * matrix, bound) for name, (matrix, bound) in self.terms.items()})

    @property
    def radius(self) -> Floats:
        """What no error exceeds, ``(n, k)``: ``sum_s |matrix_ks| bound_s``, over all noise."""
        return np.asarray(sum((np.abs(m) @ bound[:, :, None])[:, :, 0] for m, bound in self.terms.values()))


def product(name: str, one: Affine, first: Floats, other: Affine, second: Floats) -> Affine:
    """Error of a product of computed values ``first``, ``second (n, 1 or k)``, whose errors are ``one`` and ``other``.

    x' y' - x y = y' dx + x' dy - dx dy, and the last is noise ``name`` within the product of both radii.
    """
    return one.times(second) + other.times(first) + Affine.noise(name, one.radius * other.radius)


def quotient(name: str, over: Affine, values: Floats, under: Affine, divisor: Floats) -> Affine:
    """Error of ``values``, what ``over`` is the error of divided by ``divisor`` with the error ``under``, ``(n, 1)``.

    n'/d' - n/d = L/d' + L dd/(d' d) with L = dn - (n'/d') dd; |d| >= |d'| - |dd|.  Infinite where d' may be off by
    more than half.
    """
    line = over + under.times(-values)
    size, slack = np.abs(divisor), under.radius
    with np.errstate(divide="ignore"):
        second = np.where(size >= 2 * slack, line.radius * slack / (size * np.maximum(size - slack, 0)), np.inf)
    return line.times(1 / divisor) + Affine.noise(name, second)
