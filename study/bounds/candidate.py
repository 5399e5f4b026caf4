"""Bounds on what TFRA computes before it decides, and on the forces of a candidate: of any design, for any frame.

Each bounds the difference between words of the bit-accurate model and exact arithmetic on the same codes, with the
operators unquantised and the model's decisions.  Of a frame it takes magnitudes of words, never what was rounded off
them; of a coefficient how far it is off, never which way.
"""

import numpy as np

from tfra.model.arrays import Floats, Ints
from tfra.model.fixed.butterfly import HADAMARD, butterfly, to_taxels
from tfra.model.fixed.combine import products
from tfra.model.fixed.numbers import block_normalize, round_shift, significant_bits
from tfra.model.fixed.tfra.dependent import gather_sums, quotients
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.fixed.tfra.forces import scalars
from tfra.model.fixed.tfra.pipeline import Trace
from tfra.model.fixed.widths import force_drop, scalar_fraction
from tfra.study.bounds.affine import Affine, product, quotient
from tfra.study.bounds.direction import direction_slack
from tfra.study.bounds.slack import filled, matrix, row, shifted
from tfra.study.signals.tfra.instrument import TfraInstrument

Forms = dict[str, Affine]
_ZERO_B, _ZERO_N = np.zeros((12, 1, 4)), np.zeros((4, 3, 4))
GATHER_B = gather_sums(np.eye(4)[:, None], _ZERO_N).reshape(4, 9).T
GATHER_N = gather_sums(_ZERO_B, np.eye(12).reshape(12, 3, 4)).reshape(12, 9).T
"""Rows of the sums' operators as the nine A_pq."""


class CandidateBounds:
    """The bounds of ``design``, whose unquantised operators are those of its float64 reference."""

    def __init__(self, design: TfraDesign) -> None:
        self._design = design
        self._exact = exact_operators(design)
        self._operators = {op.name: op for stack in design.stacks.values() for op in stack.operators}
        self._fold = np.kron(np.eye(design.quads), HADAMARD)
        self._taxels = to_taxels(design, butterfly(np.eye(4 * design.quads).reshape(-1, design.quads, 4))).T

    def __call__(self, trace: Trace) -> dict[str, Floats]:
        """Bounds ``(n, k)`` by signal of frames that are swept; infinite where alpha's denominator may vanish.

        Units are those of :class:`tfra.study.signals.tfra.reference.Reference`.
        """
        forms = self._weights(trace)
        forms |= self._residual(trace, forms)
        forms |= self._dependent(trace, forms["sums"])
        forms |= self._residuals(trace, forms)
        forms |= self._normal(trace, forms)
        forms |= self._winner(trace, forms)
        bounds = {name: forms[name].radius for name in ("n", "alpha", "beta", "e0", "e1", "p", "q", "d")}
        bounds["planes"] = self._planes(trace, forms)
        return {name: np.where(np.isnan(bound), np.inf, bound) for name, bound in bounds.items()}

    def _product(self, name: str, stack: str, vector: Ints, error: Affine, noise: str = "") -> Affine:
        """C' (x' + rho) + r - C x = C dx + (C' - C) x' + C' rho + r, where ``error`` is dx."""
        op, fmt, own = self._operators[name], self._design.formats, noise or stack
        bits, exact = fmt.bits(f"operand.{stack}"), self._exact[name]
        rounded = row(op, exact, vector, bits, fmt.rounding)
        rho = filled(vector, 1, bits).reshape(len(vector), -1)
        form = Affine.noise(f"{name} {own}", rounded) + matrix(op) @ Affine.noise(f"operand {own}", rho)
        return exact @ error + form if error.terms else form

    def _combined(self, noise: str, scalar: Ints, by: Affine, vector: Ints, error: Affine) -> Affine:
        """s' (x' + rho) + r - s x; ``by`` is the error of the scalar, ``error`` that of the vector."""
        design, count = self._design, len(vector)
        bits, value = design.formats.bits("operand.combine"), scalar[:, None] / 2.0 ** scalar_fraction(design)
        _, shift = products(design, scalar, vector)
        rho = Affine.noise(f"operand {noise}", filled(vector, 1, bits).reshape(count, -1))
        result = np.tile(shifted(shift), self._design.quads) * (vector != 0).reshape(count, -1)
        flat = vector.reshape(count, -1).astype(np.float64)
        return product(f"{noise} both", by, value, error, flat) + rho.times(value) + Affine.noise(noise, result)

    def _weights(self, trace: Trace) -> Forms:
        """n = max(0, -w): 1-Lipschitz, so dn = theta dw with 0 <= theta <= 1, known where |w'| > |dw|."""
        nothing = Affine({})
        w = self._product("c33_inv", "contact", trace.b, nothing)
        sums = self._product("sums_b", "contact", trace.b, nothing)
        quarter = Affine.noise("quarter", np.full((len(trace.b), 4 * self._design.quads), 0.5))
        taxels = -self._fold / 4 @ w + quarter
        solution = self._design.stacks["contact"].split(trace.contact)["c33_inv"]
        word = -round_shift(butterfly(solution), 2).reshape(len(trace.b), -1)
        radius = taxels.radius
        theta = np.where(word > radius, 1.0, np.where(word < -radius, 0.0, 0.5))
        clip = Affine.noise("clip", np.where(theta == 0.5, radius / 2, 0.0))
        return {"n": self._fold @ (taxels.times(theta) + clip), "sums_b": GATHER_B @ sums}

    def _residual(self, trace: Trace, forms: Forms) -> Forms:
        found = {name: self._product(name, "residual", trace.n, forms["n"]) for name in ("sums_n", "c33", "c31", "c32")}
        return found | {"sums": forms["sums_b"] + GATHER_N @ found["sums_n"]}

    def _dependent(self, trace: Trace, sums: Affine) -> Forms:
        """alpha and beta: products of sums and direction, filled words, a quotient rounded to half a unit."""
        design, affine, direction = self._design, trace.affine, trace.direction
        by_b, by_n = design.stacks["contact"].split(trace.contact), design.stacks["residual"].split(trace.residual)
        exact = gather_sums(by_b["sums_b"], by_n["sums_n"])
        bits, count = design.formats.bits("sums"), len(exact)
        unit = 2.0 ** (affine.significant - (bits - 1))
        sums = sums + Affine.noise("sums words", filled(exact, (1, 2), bits).reshape(count, 9))
        words = (affine.sums * unit[:, None, None]).astype(np.float64)
        kappa = direction_slack(design, trace)
        rotate = np.zeros((count, 3, 9))
        rotate[:, :, :3] = direction.sin[:, None, None] * np.eye(3)
        rotate[:, :, 3:6] = -direction.cos[:, None, None] * np.eye(3)
        by_direction = np.stack([-words[:, 1], words[:, 0]], axis=2) @ Affine.noise("direction", kappa)
        radius = sums.radius
        both = radius[:, :3] * kappa[:, 1:] + radius[:, 3:6] * kappa[:, :1]
        turned = rotate @ sums + by_direction + Affine.noise("direction both", both)
        swept_y = np.array([[-1, 0, 0], [0, 0, -1], [0, 1, 0]]), np.array([[1, 0, 0], [0, 1, 0], [0, 0, -1]])
        select = np.where(direction.sweep_y[:, None, None], *swept_y)
        parts = quotients(affine.sums, direction)
        length = significant_bits(parts, axis=1)[:, None]
        filled_parts = filled(parts, 1, design.widths.division) * unit[:, None]
        parts_form = select @ turned + Affine.noise("quotient", filled_parts)
        shift = length - (design.widths.division - 1)
        value = block_normalize(parts, length, design.widths.division) * 2.0**shift * unit[:, None]
        usable = ~affine.vanishing[:, None]
        divisor = np.where(usable, value[:, 2:], 1.0)
        word = np.full((count, 1), 0.5**scalar_fraction(design) / 2)
        found = {}
        for i, name in enumerate(("alpha", "beta")):
            pick = np.eye(3)[[i, 2]]
            over, under = pick[:1] @ parts_form, pick[1:] @ parts_form
            form = quotient(f"{name} quotient", over, value[:, i : i + 1] / divisor, under, divisor)
            found[name] = masked(form + Affine.noise(f"{name} word", word), usable)
        return found

    def _residuals(self, trace: Trace, forms: Forms) -> Forms:
        """e0 = b + g + alpha d_dep and e1 = d_ind + beta d_dep."""
        by_n, swap = self._design.stacks["residual"].split(trace.residual), trace.direction.sweep_y[:, None]
        d_dep = np.where(swap[:, :, None], by_n["c31"], by_n["c32"])
        c31, c32 = forms["c31"], forms["c32"]
        ind, dep = c32.times(swap * 1.0) + c31.times(~swap * 1.0), c31.times(swap * 1.0) + c32.times(~swap * 1.0)
        alpha, beta = trace.affine.alpha, trace.affine.beta
        return {
            "e0": forms["c33"] + self._combined("alpha d", alpha, forms["alpha"], d_dep, dep),
            "e1": ind + self._combined("beta d", beta, forms["beta"], d_dep, dep),
        }

    def _normal(self, trace: Trace, forms: Forms) -> Forms:
        normal0 = self._product("normal", "normal", trace.e0, forms["e0"], "e0")
        normal1 = self._product("normal", "normal", trace.e1, forms["e1"], "e1")
        minus_g = -np.eye(len(self._fold)) @ forms["c33"]
        return {"p": self._taxels @ (normal0 + minus_g), "q": self._taxels @ normal1}

    def _winner(self, trace: Trace, forms: Forms) -> Forms:
        """d = e0 + mu_ind e1 of the candidate that was chosen; mu_ind and mu_dep are rounded to half a unit."""
        chosen, swap, word = trace.chosen, trace.direction.sweep_y[:, None], 0.5 ** scalar_fraction(self._design)
        half = np.full((len(trace.d), 1), word / 2)
        ind, mu_ind, beta = Affine.noise("mu_ind", half), chosen.mu_ind[:, None] * word, trace.affine.beta[:, None] * word
        dep = forms["alpha"] + product("mu_dep both", forms["beta"], beta, ind, mu_ind) + Affine.noise("mu_dep", half)
        return {
            "d": forms["e0"] + self._combined("mu e1", chosen.mu_ind, ind, trace.e1, forms["e1"]),
            "mu_x": ind.times(~swap * 1.0) + dep.times(swap * 1.0),
            "mu_y": ind.times(swap * 1.0) + dep.times(~swap * 1.0),
        }

    def _planes(self, trace: Trace, forms: Forms) -> Floats:
        """Bounds ``(n, 3 m)`` of f = w + A-dagger d, whose lowest bits are rounded away."""
        drop, fixed = np.array(force_drop(self._design)), Affine.noise("-1", np.zeros((len(trace.d), 1)))
        bounds = []
        for i, by in enumerate((forms["mu_x"], forms["mu_y"], fixed)):
            scalar = scalars(self._design, trace.chosen)[i]
            product_ = self._product(f"pinv{i + 1}", "force", trace.d, forms["d"])
            plane = product_ + self._combined(f"n {i}", scalar, by, trace.n, forms["n"])
            bounds.append((self._taxels / 4 @ plane).radius + shifted(drop) * 2.0**drop / 4)
        return np.concatenate(bounds, axis=1)


def masked(form: Affine, keep: Floats) -> Affine:
    """``form`` of the frames ``keep (n, 1)``; the others have no error."""
    return Affine({name: (matrix, np.where(keep, bound, 0.0)) for name, (matrix, bound) in form.terms.items()})


def exact_operators(design: TfraDesign) -> dict[str, Floats]:
    """Unquantised operators ``(rows, 4 Q)`` of folded vectors: the answers of the reference to unit vectors."""
    inside, size = TfraInstrument(design), 4 * design.quads
    one = next(design.model.traces(np.zeros((size, design.sensor.taxels), dtype=np.int64)))
    lsb = inside.last_bits(one)
    inputs = {name: word * lsb.get(name, 1) for name, word in inside.words(one).items()}
    unit = np.eye(size).reshape(size, design.quads, 4)
    stress = to_taxels(design, butterfly(unit)) / (4 << design.formats.vector_fraction)
    inputs |= {"codes": one.codes, "stress": stress, "n": unit, "e0": unit, "d": unit}
    with np.errstate(invalid="ignore"):  # stages that follow the operators have nothing to divide
        found = inside.reference.from_inputs(inputs, inside.decisions(one))
    names = ("c33_inv", "c33", "c31", "c32", "normal0", "pinv1", "pinv2", "pinv3")
    exact = {name.rstrip("0"): found[name].reshape(size, size).T for name in names}
    sums_b = np.zeros((size, 3, 3))
    sums_b[:, :, 0] = found["sums_b"]
    exact["sums_b"] = GATHER_B.T @ sums_b.reshape(size, 9).T
    exact["sums_n"] = GATHER_N.T @ found["sums_n"].reshape(size, 9).T
    return exact
