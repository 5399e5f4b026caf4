"""TFRA in fractions: what the bounds are bounds from, written without the model and its float64 reference."""

from fractions import Fraction

import numpy as np

from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.fixed.tfra.pipeline import Trace

Vector = list[Fraction]


def fractions(values: np.ndarray) -> list:
    return [fractions(row) for row in values] if values.ndim > 1 else [Fraction(float(value)) for value in values]


def times(matrix: list[Vector], vector: Vector) -> Vector:
    return [sum((a * x for a, x in zip(row, vector, strict=True)), Fraction(0)) for row in matrix]


def dot(left: Vector, right: Vector) -> Fraction:
    return sum((a * b for a, b in zip(left, right, strict=True)), Fraction(0))


def plus(left: Vector, factor: Fraction, right: Vector) -> Vector:
    return [a + factor * b for a, b in zip(left, right, strict=True)]


def offset(design: TfraDesign, codes: list[int]) -> tuple[Fraction, Fraction]:
    """c - t, centroids of the compression and of the traction."""
    places = [(Fraction(x), Fraction(y)) for x, y in zip(*design.sensor.positions(), strict=True)]

    def centroid(zone: list[int], axis: int) -> Fraction:
        return sum(weight * place[axis] for weight, place in zip(zone, places, strict=True)) / sum(zone)

    zones = [max(0, -code) for code in codes], [max(0, code) for code in codes]
    return centroid(zones[0], 0) - centroid(zones[1], 0), centroid(zones[0], 1) - centroid(zones[1], 1)


def candidate(design: TfraDesign, trace: Trace) -> dict[str, Vector]:
    """Signals of the only frame of ``trace``, with its decisions, on the vector grid; p and q times four."""
    ops, h2 = design.exact_operators, Fraction(design.sensor.thickness) ** 2
    c31, c32, c33, pinv1, pinv2, pinv3, inverse = (
        fractions(getattr(ops, name)) for name in ("c31", "c32", "c33", "pinv1", "pinv2", "pinv3", "c33_inv")
    )
    codes = [int(code) for code in trace.codes[0]]
    scale = 2 ** int(trace.frame.exponent[0]) << design.formats.vector_fraction
    b = [Fraction(code * scale) for code in codes]
    n = [max(Fraction(0), -w / h2) for w in times(inverse, b)]
    g, d1, d2 = ([sign * h2 * x for x in times(c, n)] for sign, c in ((1, c33), (-1, c31), (-1, c32)))
    d0, total = plus(b, Fraction(1), g), sum(n)
    s1, s2 = ([sum(column) / h2 for column in zip(*pinv, strict=True)] for pinv in (pinv1, pinv2))
    x = dot(s1, d0), total + dot(s1, d1), dot(s1, d2)
    y = dot(s2, d0), dot(s2, d1), total + dot(s2, d2)
    cos, sin = (Fraction(1), Fraction(0)) if trace.direction.vanishing[0] else offset(design, codes)
    u0, ux, uy = (a * sin - c * cos for a, c in zip(x, y, strict=True))
    swap = bool(trace.direction.sweep_y[0])
    if trace.affine.vanishing[0]:
        alpha = beta = Fraction(0)
    else:  # u0 + mu_x ux + mu_y uy = 0
        alpha, beta = (-u0 / ux, -uy / ux) if swap else (-u0 / uy, -ux / uy)
    d_ind, d_dep = (d2, d1) if swap else (d1, d2)
    e0, e1 = plus(d0, alpha, d_dep), plus(d_ind, beta, d_dep)
    p = plus(times(c33, times(pinv3, e0)), Fraction(-1), g)
    q = times(c33, times(pinv3, e1))
    mu_ind = Fraction(int(trace.chosen.index[0]), design.search.steps) - int(trace.direction.negative[0])
    mu_dep, d = alpha + beta * mu_ind, plus(e0, mu_ind, e1)
    mu = (mu_dep, mu_ind) if swap else (mu_ind, mu_dep)
    planes = [
        plus([f / h2 for f in times(pinv, d)], factor, n)
        for pinv, factor in ((pinv1, mu[0]), (pinv2, mu[1]), (pinv3, Fraction(-1)))
    ]
    return {
        "alpha": [alpha], "beta": [beta], "p": [4 * value for value in p], "q": [4 * value for value in q],
        "planes": [value for plane in planes for value in plane],
    }  # fmt: skip
