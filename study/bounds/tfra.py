"""Bounds on the errors of TFRA's signals."""

from collections.abc import Mapping

import numpy as np

from tfra.model.arrays import Floats
from tfra.model.fixed.cordic import cordic
from tfra.model.fixed.gain import gain_constants
from tfra.model.fixed.numbers import round_shift
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.fixed.tfra.pipeline import Trace
from tfra.model.fixed.tfra.resultant import exact_resultant
from tfra.model.rounding import Rounding
from tfra.study.bounds.affine import Affine, product
from tfra.study.bounds.blocks import flat
from tfra.study.bounds.bounds import ErrorBounds, Signals
from tfra.study.bounds.candidate import Candidate, direction_slack, sums_of
from tfra.study.bounds.friction import friction, gained, ratio
from tfra.study.bounds.rotation import Rotation
from tfra.study.bounds.slack import cut, filled, shifted
from tfra.study.signals.measures import Values
from tfra.study.signals.tfra.instrument import TfraInstrument

BEFORE = ("n", "alpha", "beta", "e0", "e1", "p", "q", "d", "planes")
SCALED = ("gain", "mu", "resultant", "forces")


class TfraBounds(ErrorBounds[TfraDesign]):
    """From the codes on, with the model's decisions; and of the scaling alone, given what it scales."""

    def __init__(self, design: TfraDesign) -> None:
        super().__init__(design, TfraInstrument(design))
        self.parts = {"phi": ("phi",), "before the decision": BEFORE, "scaling": SCALED, "results": SCALED}
        self._candidate, self._rotation = Candidate(design), Rotation.of(design)

    def bounds(self, trace: Trace) -> Signals:
        """Infinite where the denominator of alpha and beta, or the resultant that is scaled, may vanish."""
        lsb, forms = self.inside.last_bits(trace), self._candidate(trace)
        found = {name: forms[name].radius for name in BEFORE if name != "planes"}
        found["planes"] = np.concatenate([forms[f"plane {axis}"].radius for axis in range(3)], axis=1)
        found = {name: bound / flat_lsb(lsb, name) for name, bound in found.items()}
        scaling = self._scaling(trace)
        results = self._results(trace, forms, scaling)
        by_part = dict(zip(self.parts, ({"phi": self._phi(trace)}, found, scaling, results), strict=True))
        return {(part, name): by_part[part][name] for part, names in self.parts.items() for name in names}

    def exact(self, trace: Trace) -> dict[str, Values]:
        words, lsb, decided = self.inside.words(trace), self.inside.last_bits(trace), self.inside.decisions(trace)
        reference = self.inside.reference
        given: Values = {name: word * lsb.get(name, 1) for name, word in words.items()}
        for step in reference.steps[-3:]:  # gain, angle, scaling
            given |= step(given, decided)
        from_codes = reference.from_codes(trace.codes, decided)
        return {part: given if part == "scaling" else from_codes for part in self.parts}

    def _phi(self, trace: Trace) -> Floats:
        words = np.hypot(trace.direction.cos, trace.direction.sin)
        off = np.hypot(*direction_slack(self.design, trace).T)
        guard = self.design.formats.bits("division") - self.design.formats.bits("direction")
        return self._rotation.angle(words * 2.0**guard, words, off)[:, None]

    def _scaling(self, trace: Trace) -> dict[str, Floats]:
        """Of the gain, K^2 M / (K^2 |F|), mu, K |F_xy| / (K |F_z|), and what is multiplied by the gain."""
        design, factor, words, n = self.design, trace.factor, trace.total.words, self._rotation.bits
        (first, second), k = gain_constants(design), self._rotation.gain
        length = np.sqrt(np.square(words.astype(np.float64)).sum(axis=1))
        tangential, _ = cordic(design, np.abs(words[:, 0]), np.abs(words[:, 1]))
        normal = round_shift(np.abs(words[:, 2]) * first, n - 2, Rounding.TRUNCATE)
        # The second run gives K^2 |F|: a modulus changes no more than its vector.
        modulus, _ = cordic(design, tangential, normal)
        numerator, bits = trace.frame.magnitude * second, design.widths.division
        off = self._rotation.modulus(np.hypot(tangential, normal)) + cut(modulus, bits)
        off += k * np.hypot(*gained(design, words))
        over = abs(second / (k**2 * 2.0 ** (n - 3)) - 1) + cut(numerator, bits) / numerator
        under = off / (k**2 * length)
        relative = (over + under) / (1 - under)  # (1 + a) / (1 + b) - 1
        rounded = np.where(factor.mantissa == (1 << design.formats.bits("scalar")) - 1, 1.0, 0.5)
        gain = (factor.mantissa + rounded) * relative / (1 - relative) + rounded
        top = (1 << (design.formats.bits("scalar") - 1)) - 1
        mu = friction(design, words) / self.scalar + np.where(factor.mu == top, 1.0, 0.5)
        multiplied = (words, factor.resultant_shift), (flat(trace.planes), factor.force_shift)
        resultant, forces = (
            np.abs(values) * (gain * 2.0**-shift)[:, None] + shifted(shift)[:, None] for values, shift in multiplied
        )
        return {"gain": gain[:, None], "mu": mu[:, None], "resultant": resultant, "forces": forces}

    def _resultant(self, trace: Trace, forms: dict[str, Affine]) -> Floats:
        """Bounds ``(n, 3)`` of F* = A_p0 + mu_x A_p1 + mu_y A_p2 in words of a division, on the vector grid."""
        chosen, (_, words, unit) = trace.chosen, sums_of(self.design, trace)
        place = np.eye(9).reshape(3, 3, 9)
        form = forms["sums"].through(place[:, 0])
        for q, (name, mu) in enumerate((("mu_x", chosen.mu_x), ("mu_y", chosen.mu_y)), 1):
            sums = forms["sums"].through(place[:, q])
            form += product(f"{name} both", sums, words[:, :, q], forms[name], flat(mu) * self.scalar)
        exact = exact_resultant(self.design, trace.affine, chosen, trace.frame.regular)
        return form.radius + filled(exact, 1, self.design.widths.division) * (unit * self.scalar)[:, None]

    def _results(self, trace: Trace, forms: dict[str, Affine], scaling: dict[str, Floats]) -> dict[str, Floats]:
        """The scaling's own errors, and those of F* and f in F_sens / |F*|: |F*| changes no more than F*."""
        lsb, off = self.inside.last_bits(trace), self._resultant(trace, forms)
        total = np.abs(trace.total.words * 2.0 ** -trace.total.exponent[:, None])
        size, any_off = np.linalg.norm(total, axis=1)[:, None], np.linalg.norm(off, axis=1)[:, None]
        flat_, flat_off = np.linalg.norm(total[:, :2], axis=1)[:, None], np.linalg.norm(off[:, :2], axis=1)[:, None]
        with np.errstate(divide="ignore", invalid="ignore"):
            relative = np.where(2 * any_off <= size, any_off / (size - any_off), np.inf)
            share = np.minimum(1, (total + off) / np.maximum(size - any_off, 0))
        gain = trace.frame.magnitude[:, None] / size
        planes = np.concatenate([forms[f"plane {axis}"].radius for axis in range(3)], axis=1)
        force = np.abs(flat(trace.planes * lsb["planes"])) + planes
        errors = {
            "gain": gain * relative,
            "mu": ratio(flat_, flat_off, total[:, 2:], off[:, 2:]),
            "resultant": gain * (off + share * any_off),
            "forces": gain * (planes + force * relative),
        }
        return {name: scaling[name] + error / flat_lsb(lsb, name) for name, error in errors.items()}


def flat_lsb(lsb: Mapping[str, Floats], name: str) -> Floats:
    """The weight of the last bit of ``name`` for values ``(n, k)``."""
    weight = np.asarray(lsb.get(name, 1.0))
    return weight.reshape(len(weight), 1) if weight.ndim else weight
