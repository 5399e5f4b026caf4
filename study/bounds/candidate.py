"""What TFRA computes before it decides, and the forces of a candidate: errors from the codes on, as affine forms.

Of a frame they take magnitudes of words, never what was rounded off them; of a coefficient how far it is off, never
which way.  Decisions are the model's.
"""

from fractions import Fraction

import numpy as np

from tfra.model.arrays import Bools, Floats, Ints
from tfra.model.fixed.butterfly import butterfly, to_taxels
from tfra.model.fixed.numbers import block_normalize, round_shift, significant_bits
from tfra.model.fixed.tfra.centroids import moments, offset, pitch_ratio
from tfra.model.fixed.tfra.dependent import gather_sums, quotients
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.fixed.tfra.forces import scalars
from tfra.model.fixed.tfra.pipeline import Trace, ordered
from tfra.model.fixed.widths import force_drop
from tfra.study.bounds.affine import Affine, product, quotient
from tfra.study.bounds.blocks import Blocks, clipped, flat, unfolded
from tfra.study.bounds.slack import filled, shifted
from tfra.study.signals.measures import Values
from tfra.study.signals.tfra.instrument import TfraInstrument

Forms = dict[str, Affine]
_UNIT_B, _UNIT_N = np.eye(4, dtype=np.int64).reshape(4, 1, 4), np.eye(12, dtype=np.int64).reshape(12, 3, 4)
GATHER_B = flat(gather_sums(_UNIT_B, np.zeros_like(_UNIT_N[:4]))).T
GATHER_N = flat(gather_sums(np.zeros((12, 1, 4), dtype=np.int64), _UNIT_N)).T
"""Rows of the sums' operators as the nine A_pq."""


class Candidate:
    """The chain of ``design``."""

    def __init__(self, design: TfraDesign) -> None:
        self._design, self._blocks = design, Blocks(design, exact_operators(design))
        self._fold = unfolded(design.quads)
        self._taxels = to_taxels(design, butterfly(np.eye(4 * design.quads).reshape(-1, design.quads, 4))).T

    def __call__(self, trace: Trace) -> Forms:
        """Errors of signals by name; units are those of :class:`tfra.study.signals.tfra.reference.Reference`.

        Bounds of noise are infinite, or not a number, where alpha's denominator may vanish.
        """
        forms = self._weights(trace)
        forms |= self._residual(trace, forms)
        forms |= self._dependent(trace, forms)
        forms |= self._residuals(trace, forms)
        forms |= self._normal(trace, forms)
        forms |= self._winner(trace, forms)
        return forms | self._planes(trace, forms)

    def _weights(self, trace: Trace) -> Forms:
        """n = max(0, -w), of which a quarter is rounded."""
        w = self._blocks.product("c33_inv", "contact", trace.b, None)
        sums = self._blocks.product("sums_b", "contact", trace.b, None)
        quarter = Affine.noise("quarter", np.full((len(trace.b), len(self._fold)), 0.5))
        solution = self._design.stacks["contact"].split(trace.contact)["c33_inv"]
        word = -round_shift(butterfly(solution), 2).reshape(len(trace.b), -1)
        n = clipped("clip", word, w.through(-self._fold / 4) + quarter)
        return {"n": n.through(self._fold), "sums_b": sums.through(GATHER_B)}

    def _residual(self, trace: Trace, forms: Forms) -> Forms:
        names = ("sums_n", "c33", "c31", "c32")
        found = {name: self._blocks.product(name, "residual", trace.n, forms["n"]) for name in names}
        exact, _, _ = sums_of(self._design, trace)
        rounded = Affine.noise("sums words", flat(filled(exact, (1, 2), self._design.formats.bits("sums"))))
        return found | {"sums": forms["sums_b"] + found["sums_n"].through(GATHER_N) + rounded}

    def _dependent(self, trace: Trace, forms: Forms) -> Forms:
        """alpha and beta: products of sums and direction, words of a division, a quotient rounded to half a unit."""
        _, words, unit = sums_of(self._design, trace)
        direction, bits = trace.direction, self._design.widths.division
        sums, radius, kappa = forms["sums"], forms["sums"].radius, direction_slack(self._design, trace)
        turn = np.stack([direction.sin, -direction.cos, 0 * direction.cos], axis=1)
        turned = sums.through(np.asarray(np.kron(turn[:, None], np.eye(3)), dtype=np.float64))  # u0, ux and -uy
        turned += Affine.noise("direction", kappa).through(np.stack([-words[:, 1], words[:, 0]], axis=2))
        both = Affine.noise("direction both", radius[:, :3] * kappa[:, 1:] + radius[:, 3:6] * kappa[:, :1])
        parts = quotients(trace.affine.sums, direction)
        significant = significant_bits(parts, axis=1)[:, None]
        scale = 2.0 ** (significant - (bits - 1)) * unit[:, None]
        value = block_normalize(parts, significant, bits) * scale
        select = np.where(direction.sweep_y[:, None, None], *SELECTED)
        errors = (turned + both).through(select)
        errors += Affine.noise("quotient", filled(parts, 1, bits) * unit[:, None])
        usable = ~trace.affine.vanishing[:, None]  # elsewhere both are zero by decision
        errors, divisor = errors.times(usable.astype(np.float64)), np.where(usable, value[:, 2:], 1.0)
        under, word, found = errors.through(np.eye(3)[2:]), np.where(usable, self._blocks.scalar / 2, 0.0), {}
        for i, name in enumerate(("alpha", "beta")):
            over = errors.through(np.eye(3)[i : i + 1])
            form = quotient(f"{name} quotient", over, value[:, i : i + 1] / divisor, under, divisor)
            found[name] = form + Affine.noise(name, word)
        return found

    def _residuals(self, trace: Trace, forms: Forms) -> Forms:
        """e0 = b + g + alpha d_dep and e1 = d_ind + beta d_dep."""
        by_n, swap = self._design.stacks["residual"].split(trace.residual), trace.direction.sweep_y
        _, d_dep = ordered(trace.direction, by_n["c31"], by_n["c32"])
        ind, dep = swapped(swap, forms["c31"], forms["c32"])
        alpha, beta = trace.affine.alpha, trace.affine.beta
        return {
            "e0": forms["c33"] + self._blocks.combined("alpha d", alpha, forms["alpha"], d_dep, dep),
            "e1": ind + self._blocks.combined("beta d", beta, forms["beta"], d_dep, dep),
        }

    def _normal(self, trace: Trace, forms: Forms) -> Forms:
        """p = C33 A3-dagger e0 - g and q = C33 A3-dagger e1, four times those of taxels."""
        normal0 = self._blocks.product("normal", "normal", trace.e0, forms["e0"], "e0")
        normal1 = self._blocks.product("normal", "normal", trace.e1, forms["e1"], "e1")
        p = normal0.through(self._taxels) + forms["c33"].through(-self._taxels)
        return {"p": p, "q": normal1.through(self._taxels)}

    def _winner(self, trace: Trace, forms: Forms) -> Forms:
        """d = e0 + mu_ind e1 of the candidate that was chosen; mu_ind and mu_dep are rounded to half a unit."""
        chosen, half = trace.chosen, np.full((len(trace.d), 1), self._blocks.scalar / 2)
        mu_ind, beta = (flat(words) * self._blocks.scalar for words in (chosen.mu_ind, trace.affine.beta))
        ind = Affine.noise("mu_ind", half)
        dep = forms["alpha"] + product("mu_dep both", forms["beta"], beta, ind, mu_ind) + Affine.noise("mu_dep", half)
        mu_x, mu_y = swapped(trace.direction.sweep_y, ind, dep)
        d = forms["e0"] + self._blocks.combined("mu e1", chosen.mu_ind, ind, trace.e1, forms["e1"])
        return {"d": d, "mu_x": mu_x, "mu_y": mu_y}

    def _planes(self, trace: Trace, forms: Forms) -> Forms:
        """f = w + A-dagger d, whose lowest bits are rounded away, of each axis."""
        drop, fixed = force_drop(self._design), Affine.noise("-1", np.zeros((len(trace.d), 1)))
        rounded = np.full((len(trace.d), self._design.sensor.taxels), shifted(drop) * 2.0**drop / 4)
        found = {}
        for i, by in enumerate((forms["mu_x"], forms["mu_y"], fixed)):
            scalar = scalars(self._design, trace.chosen)[i]
            plane = self._blocks.product(f"pinv{i + 1}", "force", trace.d, forms["d"])
            plane += self._blocks.combined(f"n {i}", scalar, by, trace.n, forms["n"])
            found[f"plane {i}"] = plane.through(self._taxels / 4) + Affine.noise(f"plane {i}", rounded)
        return found


SELECTED = np.array([[-1, 0, 0], [0, 0, -1], [0, 1, 0]]), np.array([[1, 0, 0], [0, 1, 0], [0, 0, -1]])
"""Numerators and denominator of alpha and beta from u0, ux and -uy: where mu_y is swept, and elsewhere."""


def swapped(swap: Bools, one: Affine, other: Affine) -> tuple[Affine, Affine]:
    """``one`` and ``other``, in frames ``swap (n,)`` the other way round."""
    yes, no = swap[:, None].astype(np.float64), (~swap[:, None]).astype(np.float64)
    return other.times(yes) + one.times(no), one.times(yes) + other.times(no)


def sums_of(design: TfraDesign, trace: Trace) -> tuple[Ints, Floats, Floats]:
    """A_pq ``(n, 3, 3)`` exact, as the value of their words, and the unit of these ``(n,)``, on the vector grid."""
    by_b, by_n = design.stacks["contact"].split(trace.contact), design.stacks["residual"].split(trace.residual)
    unit = np.exp2((trace.affine.significant - (design.formats.bits("sums") - 1)).astype(np.float64))
    return gather_sums(by_b["sums_b"], by_n["sums_n"]), np.asarray(trace.affine.sums * unit[:, None, None]), unit


def direction_slack(design: TfraDesign, trace: Trace) -> Floats:
    """How far ``cos`` and ``sin`` are from a multiple of the exact direction, in their last bits, ``(n, 2)``.

    The offset is exact; it is rounded to words of a division, multiplied by the pitch, whose ratio is not exact
    either, and rounded again.
    """
    exact, ratio = offset(*moments(design, trace.codes)), np.array(pitch_ratio(design))
    bits, word = design.widths.division, design.formats.bits("direction")
    significant = significant_bits(exact, axis=1)[:, None]
    length = block_normalize(exact, significant, bits) * ratio
    first = filled(exact, 1, bits) * 2.0 ** (bits - 1 - significant) * ratio
    slack = (first + filled(length, 1, word)) * 2.0 ** (word - 1 - significant_bits(length, axis=1)[:, None])
    x, y = design.sensor.pitch_x, design.sensor.pitch_y
    off = abs(float(Fraction(int(ratio[0]), int(ratio[1])) * Fraction(y) / Fraction(x) - 1))
    words = np.abs(np.stack([trace.direction.cos, trace.direction.sin], axis=1))
    slack += (words + slack) * off * np.array([x < y, x >= y])
    return np.where(trace.direction.vanishing[:, None], 0.0, slack)


def exact_operators(design: TfraDesign) -> dict[str, Floats]:
    """Unquantised operators ``(rows, 4 Q)`` of folded vectors: the answers of the reference to unit vectors."""
    inside, size = TfraInstrument(design), 4 * design.quads
    one = next(design.model.traces(np.zeros((size, design.sensor.taxels), dtype=np.int64)))
    lsb = inside.last_bits(one)
    inputs: Values = {name: word * lsb.get(name, 1) for name, word in inside.words(one).items()}
    unit = np.eye(size).reshape(size, design.quads, 4)
    stress = to_taxels(design, butterfly(unit)) / (4 << design.formats.vector_fraction)
    inputs |= {"codes": one.codes, "stress": stress, "n": unit, "e0": unit, "d": unit}
    with np.errstate(divide="ignore", invalid="ignore"):  # stages after the operators have nothing to divide
        found = inside.reference.from_inputs(inputs, inside.decisions(one))
    names = ("c33_inv", "c33", "c31", "c32", "normal0", "pinv1", "pinv2", "pinv3")
    exact = {name.rstrip("0"): flat(found[name]).T for name in names}
    sums_b = np.zeros((size, 3, 3))
    sums_b[:, :, 0] = found["sums_b"]
    return exact | {"sums_b": GATHER_B.T @ flat(sums_b).T, "sums_n": GATHER_N.T @ flat(found["sums_n"]).T}
