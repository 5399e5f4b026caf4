"""TFRA in float64 stage by stage: the stages of the bit-accurate model without rounding.

Values have the model's scaling: normalised frames, vectors on the vector grid and folded, ``(n, Q, 4)``.  The reference
takes over the model's decisions, so it differs from the words by arithmetic alone.
"""

from dataclasses import dataclass

import numpy as np

from tfra.model.arrays import Bools, Floats, Ints
from tfra.model.fixed.butterfly import butterfly, to_quads, to_taxels
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.fixed.tfra.pipeline import Trace
from tfra.study.signals.measures import Values
from tfra.study.signals.stages import Stages


@dataclass(frozen=True)
class Decisions:
    """Decisions of the model for frames ``(n,)``; ``turn`` is its phi in turns, which resolves 0 and 1."""

    exponent: Ints
    sweep_y: Bools
    negative: Bools
    no_direction: Bools
    no_denominator: Bools
    index: Ints
    turn: Floats

    @classmethod
    def of(cls, design: TfraDesign, trace: Trace) -> "Decisions":
        """Decisions of ``trace``."""
        direction = trace.direction
        turn = np.ldexp(trace.phi, -next(f.fraction for f in design.layout if f.name == "phi"))
        return cls(
            trace.frame.exponent, direction.sweep_y, direction.negative, direction.vanishing, trace.affine.vanishing,
            trace.chosen.index, turn,
        )  # fmt: skip


class Reference(Stages):
    """The unquantised stages of ``design``, for frames that are swept."""

    def __init__(self, design: TfraDesign) -> None:
        ops, h2 = design.exact_operators, design.sensor.thickness**2
        self._design = design
        self._c = np.stack([ops.c31, ops.c32, ops.c33]) * h2
        self._pinv = np.stack([ops.pinv1, ops.pinv2, ops.pinv3]) / h2
        self._c33_inv, self._normal = ops.c33_inv / h2, ops.c33 @ ops.pinv3
        self._grid = 2.0**design.formats.vector_fraction
        self.steps = (
            self._normaliser, self._centroids, self._contact, self._weights, self._residual, self._dependent,
            self._residuals, self._products, self._sweep, self._friction, self._winner, self._force, self._forces,
            self._resultant, self._gain, self._angle, self._scaling,
        )  # fmt: skip

    def _taxels(self, folded: Floats | Ints) -> Floats:
        return to_taxels(self._design, butterfly(np.asarray(folded, dtype=np.float64))) / 4

    def _folded(self, taxels: Floats) -> Floats:
        return butterfly(to_quads(self._design, taxels))

    def _b(self, v: Values) -> Floats:
        return np.asarray(v["stress"] * self._grid, dtype=np.float64)

    def _normaliser(self, v: Values, t: Decisions) -> Values:
        stress = v["codes"] * 2.0 ** t.exponent[:, None]
        return {"stress": stress, "magnitude": np.abs(stress).sum(axis=1)}

    def direction(self, codes: Ints, none: Bools) -> Floats:
        """The unit vector ``(n, 2)`` along c - t (Eqs. 11, 19-22) of ``codes (n, m)``; where there is ``none``, x."""
        compression, traction = np.maximum(-codes, 0), np.maximum(codes, 0)
        positions = np.stack(self._design.sensor.positions(), axis=1)
        positions -= positions.mean(axis=0)
        sums = compression.sum(axis=1, keepdims=True), traction.sum(axis=1, keepdims=True)
        offset = compression @ positions * sums[1] - traction @ positions * sums[0]
        offset[none] = 1, 0
        return np.asarray(offset / np.linalg.norm(offset, axis=1, keepdims=True))

    def _centroids(self, v: Values, t: Decisions) -> Values:
        return {"direction": self.direction(v["codes"], t.no_direction)}

    def _contact(self, v: Values, t: Decisions) -> Values:
        b = self._b(v)
        return {"c33_inv": self._folded(b @ self._c33_inv.T), "sums_b": b @ self._pinv.sum(axis=1).T}

    def _weights(self, v: Values, t: Decisions) -> Values:
        return {"n": self._folded(np.maximum(-self._taxels(v["c33_inv"]), 0.0))}

    def _residual(self, v: Values, t: Decisions) -> Values:
        """g, d1, d2, and the parts of A_pq that come from n (Eq. 12)."""
        n = self._taxels(v["n"])
        by_x, by_y, by_z = (n @ c.T for c in self._c)
        parts = np.stack([by_z, -by_x, -by_y], axis=2)
        sums = np.einsum("pm,nmq->npq", self._pinv.sum(axis=1), parts)
        sums += n.sum(axis=1)[:, None, None] * np.array([[0, 1, 0], [0, 0, 1], [-1, 0, 0]])
        return {"sums_n": sums, "c33": self._folded(by_z), "c31": self._folded(-by_x), "c32": self._folded(-by_y)}

    def _dependent(self, v: Values, t: Decisions) -> Values:
        """A_pq (Eq. 12), alpha and beta (Eqs. 17, 18)."""
        sums = np.array(v["sums_n"], dtype=np.float64)
        sums[:, :, 0] += v["sums_b"]
        cos, sin = v["direction"].T
        u0, ux, uy = (sums[:, 0] * sin[:, None] - sums[:, 1] * cos[:, None]).T * np.array([1, 1, -1])[:, None]
        den = np.where(t.no_denominator, 1.0, np.where(t.sweep_y, ux, uy))
        alpha = np.where(t.no_denominator, 0.0, np.where(t.sweep_y, -u0, u0) / den)
        beta = np.where(t.no_denominator, 0.0, np.where(t.sweep_y, uy, ux) / den)
        return {"sums": sums, "alpha": alpha, "beta": beta}

    def _residuals(self, v: Values, t: Decisions) -> Values:
        swap = t.sweep_y[:, None, None]
        d_ind, d_dep = np.where(swap, v["c32"], v["c31"]), np.where(swap, v["c31"], v["c32"])
        alpha, beta = (v[name][:, None, None] for name in ("alpha", "beta"))
        return {"e0": self._folded(self._b(v)) + v["c33"] + alpha * d_dep, "e1": d_ind + beta * d_dep}

    def _products(self, v: Values, t: Decisions) -> Values:
        return {f"normal{i}": self._folded(self._taxels(v[f"e{i}"]) @ self._normal.T) for i in (0, 1)}

    def _sweep(self, v: Values, t: Decisions) -> Values:
        """p and q times four, B^z and B^xy times 4 K (Eqs. 23-25); of integers everything is exact."""
        steps, unit = self._design.search.steps, 4 * self._design.search.steps << self._design.formats.vector_fraction
        p, q = (to_taxels(self._design, butterfly(x)) for x in (v["normal0"] - v["c33"], v["normal1"]))
        normal = steps * (p - np.where(t.negative[:, None], q, 0))
        stress = unit * v["stress"]
        measured = np.maximum(stress, 0).sum(axis=1)
        b_z, b_xy = [], []
        for _ in range(steps + 1):
            b_z.append(np.maximum(normal, 0).sum(axis=1))
            b_xy.append(np.abs(np.maximum(stress - normal, 0).sum(axis=1) - measured))
            normal = normal + q
        return {"p": p, "q": q, "b_z": np.stack(b_z, axis=1), "b_xy": np.stack(b_xy, axis=1)}

    def _friction(self, v: Values, t: Decisions) -> Values:
        mu_ind = t.index / self._design.search.steps - t.negative
        mu_dep = v["alpha"] + v["beta"] * mu_ind
        mu_x, mu_y = np.where(t.sweep_y, [mu_dep, mu_ind], [mu_ind, mu_dep])
        return {"mu_ind": mu_ind, "mu_x": mu_x, "mu_y": mu_y}

    def _winner(self, v: Values, t: Decisions) -> Values:
        return {"d": v["e0"] + v["mu_ind"][:, None, None] * v["e1"]}

    def _force(self, v: Values, t: Decisions) -> Values:
        d = self._taxels(v["d"])
        return {f"pinv{i}": self._folded(d @ pinv.T) for i, pinv in enumerate(self._pinv, 1)}

    def _forces(self, v: Values, t: Decisions) -> Values:
        scalars = v["mu_x"], v["mu_y"], np.full(len(v["n"]), -1.0)
        folded = [v[f"pinv{i}"] + s[:, None, None] * v["n"] for i, s in enumerate(scalars, 1)]
        return {"planes": self._taxels(np.stack(folded, axis=1))}

    def _resultant(self, v: Values, t: Decisions) -> Values:
        a = v["sums"]
        return {"f_star": a[:, :, 0] + a[:, :, 1] * v["mu_x"][:, None] + a[:, :, 2] * v["mu_y"][:, None]}

    def _gain(self, v: Values, t: Decisions) -> Values:
        f = v["f_star"]
        return {"gain": v["magnitude"] / np.linalg.norm(f, axis=1), "mu": np.hypot(f[:, 0], f[:, 1]) / np.abs(f[:, 2])}

    def _angle(self, v: Values, t: Decisions) -> Values:
        cos, sin = v["direction"].T
        phi = np.arctan2(sin, cos) / (2 * np.pi)
        return {"phi": t.turn + (phi - t.turn + 0.5) % 1.0 - 0.5}

    def _scaling(self, v: Values, t: Decisions) -> Values:
        gain = v["gain"]
        return {"resultant": v["f_star"] * gain[:, None], "forces": v["planes"] * gain[:, None, None]}
