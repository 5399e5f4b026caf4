"""Largest magnitudes of any frame, where the proven bounds add up worst cases that no single frame combines.

Every vector is linear in b and in n.  In frames that are swept an entry of n is that of -C33^-1 b or, where this is
negative, zero.  So a word is at most what the coefficients of n of one sign give alone; of the terms
-C33^-1[j, k] b[k] in it, those of one sign or those of the other count at most, for every k.  In all other frames
n = -C33^-1 b, and there are no frictions.  Frictions are at the ends of their ranges, as words are affine in each of
them.  Rounding is not counted.
"""

from itertools import product

import numpy as np

from tfra.model.arrays import Floats
from tfra.model.fixed.coefficients import Folding
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.fixed.widths import MU_LIMIT, force_drop
from tfra.model.tfra import COEFFICIENT_LIMIT

Linear = tuple[Floats, Floats]
"""Factors of n and of b, each ``(words, m)``."""

Pair = tuple[float, float]


def ceilings(design: TfraDesign) -> dict[str, float]:
    """Ceilings of signals of the catalogue; a signal without a ceiling has its bound."""
    sensor, code = design.sensor, 2 ** (design.adc.bits - 1)
    most = Forms(design).largest()
    return {
        **{name: float(words.max()) for name, words in most.items()},
        "b_z": float(most["candidate"].sum()),
        "b_xy": float(most["candidate"].sum()),
        "force": float(most["unscaled"].max()) / 2 ** force_drop(design),
        # Both zones share the taxels, so the product of their sums is at most a quarter of the square of all.
        "direction": (sensor.taxels * code) ** 2 / 4 * (max(sensor.rows, sensor.columns) - 1),
    }


class Forms:
    """Signals as linear forms."""

    def __init__(self, design: TfraDesign) -> None:
        ops, h2 = design.exact_operators, design.sensor.thickness**2
        self._full = 2.0 ** (design.adc.bits - 1 + design.formats.vector_fraction)
        self._solve = -ops.c33_inv / h2
        self._c = np.stack([ops.c31, ops.c32, ops.c33]) * h2
        self._pinv = np.stack([ops.pinv1, ops.pinv2, ops.pinv3]) / h2
        self._normal, self._one = ops.c33 @ ops.pinv3, np.eye(design.sensor.taxels)
        self._fold, self._steps = Folding(design).fold, design.search.steps

    def largest(self) -> dict[str, Floats]:
        """Largest value of each word of a signal, ``(words,)``, by the signal's name."""
        limit, mu = COEFFICIENT_LIMIT, float(MU_LIMIT)
        swept = self._signals(_ends(limit, 0.0), _ends(limit, 1.0), _ends(mu, 1.0))
        other = self._signals([(0.0, 0.0)], [(1.0, 0.0), (0.0, 1.0)], [(0.0, 0.0)])
        return {
            name: np.max([*map(self._clipped, swept[name]), *map(self._unclipped, other[name])], axis=0)
            for name in swept
        }

    def _unclipped(self, form: Linear) -> Floats:
        on_n, on_b = form
        return np.asarray(np.abs(on_b + on_n @ self._solve).sum(axis=1) * self._full)

    def _clipped(self, form: Linear) -> Floats:
        on_n, on_b = form
        add, take = np.maximum(self._solve, 0), np.minimum(self._solve, 0)
        sides = [
            np.maximum(np.abs(on_b + n @ add), np.abs(on_b + n @ take))
            for n in (np.maximum(on_n, 0), np.minimum(on_n, 0))
        ]
        return np.asarray(np.max([side.sum(axis=1) for side in sides], axis=0) * self._full)

    def _signals(self, alphas: list[Pair], betas: list[Pair], frictions: list[Pair]) -> dict[str, list[Linear]]:
        """Forms by name; pairs are what d1 and d2 count in e0, in e1 and in d."""
        g, one, none = self._c[2], self._one, 0 * self._one
        e0, d = ([self._residual(*pair) for pair in pairs] for pairs in (alphas, frictions))
        e1 = [(self._residual(*pair)[0] - g, none) for pair in betas]
        normal0, normal1 = _through(self._normal, e0), _through(self._normal, e1)
        p, candidate = ([(n - g, b) for n, b in forms] for forms in (normal0, _through(self._normal, d)))
        folded = {
            "c33": [(g, none)], "c31": [(-self._c[0], none)], "c32": [(-self._c[1], none)], "d0": [(g, one)],
            "e0": e0, "e1": e1, "normal0": normal0, "normal1": normal1, "d": d,
            **{f"pinv{i}": _through(pinv, d) for i, pinv in enumerate(self._pinv, 1)},
        }  # fmt: skip
        of_n, of_b = self._sums()
        return {
            **{name: _through(self._fold, forms) for name, forms in folded.items()},
            **{"p": _times(4, p), "q": _times(4, normal1), "unscaled": _times(4, self._unscaled(frictions))},
            "candidate": _times(4 * self._steps, candidate),
            **{"sums_n": [(of_n, 0 * of_b)], "sums": [(of_n, of_b)]},
        }

    def _residual(self, mu_x: float, mu_y: float) -> Linear:
        return self._c[2] - mu_x * self._c[0] - mu_y * self._c[1], self._one

    def _unscaled(self, frictions: list[Pair]) -> list[Linear]:
        found = []
        for mu in frictions:
            n, b = self._residual(*mu)
            found += [(a @ n + s * self._one, a @ b) for a, s in zip(self._pinv, (*mu, -1.0), strict=True)]
        return found

    def _sums(self) -> Linear:
        """A_pq of Eq. 12."""
        s = self._pinv.sum(axis=1)
        on_n = np.stack([s @ self._c[2], -s @ self._c[0], -s @ self._c[1]], axis=1)
        on_n += np.array([[0, 1, 0], [0, 0, 1], [-1, 0, 0]])[:, :, None]
        on_b = np.zeros_like(on_n)
        on_b[:, 0] = s
        return on_n.reshape(9, -1), on_b.reshape(9, -1)


def _through(matrix: Floats, forms: list[Linear]) -> list[Linear]:
    return [(matrix @ n, matrix @ b) for n, b in forms]


def _times(factor: float, forms: list[Linear]) -> list[Linear]:
    return [(factor * n, factor * b) for n, b in forms]


def _ends(dependent: float, independent: float) -> list[Pair]:
    """Pairs of what the dependent friction and the swept one are at most, either of them along x."""
    ends = product({-dependent, dependent}, {-independent, independent})
    return [pair for a, b in sorted(ends) for pair in ((a, b), (b, a))]
