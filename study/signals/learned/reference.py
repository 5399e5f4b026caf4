"""The learned estimator in float64 stage by stage: the stages of the bit-accurate model without rounding.

Values have the model's scaling: normalised frames, vectors on the vector grid and folded, ``(n, quads, 4)``.  The
reference takes over the exponent and the turn of phi, so it differs from the words by arithmetic alone.
"""

from dataclasses import dataclass

import numpy as np

from tfra.model.arrays import Floats, Ints
from tfra.model.fixed.butterfly import EE, butterfly, to_quads, to_taxels
from tfra.model.fixed.coefficients import Folding
from tfra.model.fixed.learned.design import LearnedDesign
from tfra.model.fixed.learned.operators import PLACES, field_matrices, network_rows
from tfra.model.fixed.learned.pipeline import Trace
from tfra.model.learned.field import MOST_FRICTION
from tfra.study.signals.measures import Values
from tfra.study.signals.stages import Stages


@dataclass(frozen=True)
class Decisions:
    """Decisions of the model for frames ``(n,)``; ``turn`` is its phi in turns, which resolves 0 and 1."""

    exponent: Ints
    turn: Floats

    @classmethod
    def of(cls, design: LearnedDesign, trace: Trace) -> "Decisions":
        """Decisions of ``trace``."""
        turn = np.ldexp(trace.turned.phi, -next(f.fraction for f in design.layout if f.name == "phi"))
        return cls(trace.frame.exponent, turn)


class Reference(Stages):
    """The unquantised stages of ``design``, for frames with contact."""

    def __init__(self, design: LearnedDesign) -> None:
        self._design = design
        self._rows = {name: (rows, EE) for name, rows in network_rows(design, design.weights).items()}
        self._grid = 2.0**design.formats.vector_fraction
        self.steps = [
            self._normaliser, self._first, self._second, self._outputs, self._resultant, self._angle, self._friction,
        ]  # fmt: skip
        if design.taxel_forces:
            folding = Folding(design)
            self._rows |= {
                name: (folding.rows(matrix, flip), flip)
                for name, (matrix, flip) in field_matrices(design.sensor).items()
            }
            self.steps += [self._still, self._sheared, self._field, self._forces]

    def _product(self, name: str, vector: Floats) -> Floats:
        rows, flip = self._rows[name]
        return np.asarray(np.einsum("ipk,nkp->nip", rows, vector[:, :, np.arange(4) ^ flip], optimize=True))

    def _b(self, v: Values) -> Floats:
        return butterfly(to_quads(self._design, v["stress"] * self._grid))

    def _normaliser(self, v: Values, t: Decisions) -> Values:
        return {"stress": v["codes"] * 2.0 ** t.exponent[:, None]}

    def _first(self, v: Values, t: Decisions) -> Values:
        first = self._product("first", self._b(v))
        return {"first": first, "h1": _activated(v.get("first", first))}

    def _second(self, v: Values, t: Decisions) -> Values:
        second = self._product("second", v["h1"])
        return {"second": second, "h2": _activated(v.get("second", second))}

    def _outputs(self, v: Values, t: Decisions) -> Values:
        direct, read1 = self._product("direct", self._b(v)), self._product("read1", v["h1"])
        quads = direct + read1 + self._product("read2", v["h2"])
        return {"outputs": np.stack([quads[:, quad, parity] for quad, parity in PLACES], axis=1)}

    def _resultant(self, v: Values, t: Decisions) -> Values:
        results = v["outputs"] / self._grid
        return {"resultant": results[:, :3], "uncertainty": np.maximum(results[:, 3], 0.0)}

    def _angle(self, v: Values, t: Decisions) -> Values:
        phi = np.arctan2(v["outputs"][:, 1], v["outputs"][:, 0]) / (2 * np.pi)
        return {"phi": t.turn + (phi - t.turn + 0.5) % 1.0 - 0.5}

    def _friction(self, v: Values, t: Decisions) -> Values:
        x, y, z, _ = v["outputs"].T
        return {"mu": np.hypot(x, y) / np.abs(z), "mu_x": x / np.abs(z), "mu_y": y / np.abs(z)}

    def _still(self, v: Values, t: Decisions) -> Values:
        inverse = self._product("inverse", self._b(v))
        return {"inverse": inverse, "p0": _activated(v.get("inverse", inverse))}

    def _sheared(self, v: Values, t: Decisions) -> Values:
        return {name: self._product(name, v["p0"]) for name in ("shear_x", "shear_y")}

    def _field(self, v: Values, t: Decisions) -> Values:
        mu_x, mu_y = (np.clip(v[name], -MOST_FRICTION, MOST_FRICTION)[:, None, None] for name in ("mu_x", "mu_y"))
        quads = v["inverse"] + mu_x * v["shear_x"] + mu_y * v["shear_y"]
        return {"p": to_taxels(self._design, np.maximum(butterfly(quads), 0.0))}

    def _forces(self, v: Values, t: Decisions) -> Values:
        p, total = v["p"], v["outputs"][:, :3] / self._grid
        return {"forces": total[:, :, None] * (p / p.sum(axis=1, keepdims=True))[:, None]}


def _activated(quads: Floats) -> Floats:
    """The folded units of a layer from its folded sums, :func:`tfra.model.fixed.learned.activation.activation`."""
    return butterfly(np.maximum(butterfly(quads), 0.0))
