"""Bounds on the errors of the learned estimator's signals, from the codes on."""

from collections.abc import Mapping

import numpy as np

from tfra.model.arrays import Floats, Ints
from tfra.model.fixed.butterfly import EE, butterfly, to_quads, to_taxels
from tfra.model.fixed.coefficients import Folding
from tfra.model.fixed.combine import combine
from tfra.model.fixed.learned.design import LearnedDesign
from tfra.model.fixed.learned.field import bounded
from tfra.model.fixed.learned.operators import PLACES, field_matrices, network_rows, outputs
from tfra.model.fixed.learned.pipeline import Trace
from tfra.study.bounds.affine import Affine, product, quotient
from tfra.study.bounds.blocks import Blocks, clipped, flat, unfolded
from tfra.study.bounds.bounds import ErrorBounds, Signals
from tfra.study.bounds.friction import friction, ratio
from tfra.study.bounds.rotation import Rotation
from tfra.study.bounds.slack import cut, filled, matrix, shifted
from tfra.study.signals.learned.instrument import LearnedInstrument
from tfra.study.signals.measures import Values

UNITS = ("h1", "h2", "outputs")
RESULTS = ("resultant", "uncertainty", "mu", "mu_x", "mu_y")


class LearnedBounds(ErrorBounds[LearnedDesign]):
    """Of the units, of the results, and of the forces at the taxels, if there are any."""

    def __init__(self, design: LearnedDesign) -> None:
        super().__init__(design, LearnedInstrument(design))
        rows = {name: (each, EE) for name, each in network_rows(design, design.weights).items()}
        self.parts = {"phi": ("phi",), "units": UNITS, "results": RESULTS}
        if design.taxel_forces:
            folding = Folding(design)
            matrices = field_matrices(design.sensor)
            rows |= {name: (folding.rows(each, flip), flip) for name, (each, flip) in matrices.items()}
            self.parts["field"] = ("p", "forces")
        self._blocks = Blocks(design, {name: matrix(*each) for name, each in rows.items()})
        self._taxels = to_taxels(design, butterfly(np.eye(4 * design.quads).reshape(-1, design.quads, 4))).T

    def exact(self, trace: Trace) -> Mapping[str, Values]:
        values = self.inside.reference.from_codes(trace.codes, self.inside.decisions(trace))
        return dict.fromkeys(self.parts, values)

    def bounds(self, trace: Trace) -> Signals:
        """Infinite where what is divided by, or the tangential force, may vanish."""
        b = butterfly(trace.stress) << self.design.formats.vector_fraction
        forms = self._network(trace, b)
        found: Signals = {"units": {name: forms[name].radius for name in UNITS}}
        words, value, bits = trace.force.words, outputs(trace.total)[:, :3], self.design.widths.division
        off = forms["outputs"].radius[:, :3] + filled(value, 1, bits)
        length = np.hypot(words[:, 0], words[:, 1])
        turned = Rotation.of(self.design).angle(length, length * 2.0**-trace.force.exponent, np.hypot(off[:, 0], off[:, 1]))
        found["phi"] = {"phi": turned[:, None]}
        shift = self.design.formats.vector_fraction - self.design.formats.force_fraction
        results = forms["outputs"].radius * 2.0**-shift + shifted(shift)
        found["results"] = {"resultant": results[:, :3], "uncertainty": results[:, 3:], **self._friction(trace, off)}
        if trace.field is not None:
            found["field"] = self._field(trace, b, forms["outputs"], found["results"])
        return found

    def _network(self, trace: Trace, b: Ints) -> dict[str, Affine]:
        """h = max(0, C h), twice, and the outputs of both and of b."""
        make, contact = self._blocks.product, trace.frame.contact
        first = self.design.stacks["first"].split(trace.first)["first"]
        second = self.design.stacks["second"].split(trace.second)["second"]
        h1 = activated("h1", first, make("first", "first", b, None))
        h2 = activated("h2", second, make("second", "second", trace.h1, h1))
        quads = make("direct", "first", b, None) + make("read1", "second", trace.h1, h1)
        quads += make("read2", "read", trace.h2, h2)
        assert contact.all()
        place = np.eye(8)[[4 * quad + parity for quad, parity in PLACES]]
        return {"h1": h1, "h2": h2, "outputs": place @ quads}

    def _friction(self, trace: Trace, off: Floats) -> dict[str, Floats]:
        """Of mu, mu_x and mu_y in last bits, for a resultant that is ``off (n, 3)`` on the vector grid."""
        value = np.abs(trace.force.words * 2.0 ** -trace.force.exponent[:, None])
        top = (1 << (self.design.formats.bits("scalar") - 1)) - 1
        both = np.hypot(value[:, 0], value[:, 1]), np.hypot(off[:, 0], off[:, 1])
        given = friction(self.design, trace.force.words)
        errors = {
            "mu": given + ratio(*both, value[:, 2], off[:, 2]),
            "mu_x": ratio(value[:, 0], off[:, 0], value[:, 2], off[:, 2]),
            "mu_y": ratio(value[:, 1], off[:, 1], value[:, 2], off[:, 2]),
        }
        rounded = {name: np.where(np.abs(getattr(trace.friction, name)) == top, 1.0, 0.5) for name in errors}
        return {name: (error / self.scalar + rounded[name])[:, None] for name, error in errors.items()}

    def _field(self, trace: Trace, b: Ints, total: Affine, results: dict[str, Floats]) -> dict[str, Floats]:
        """Of p = max(0, -K b + mu_x s_x + mu_y s_y) on the vector grid, and of the forces F p / sum of p."""
        design, at_taxels = self.design, trace.field
        assert at_taxels is not None
        still = design.stacks["first"].split(trace.first)["inverse"]
        form = self._blocks.product("inverse", "first", b, None)
        p0, quads = activated("p0", still, form), still
        for axis in ("x", "y"):
            sheared = design.stacks["field"].split(at_taxels.sheared)[f"shear_{axis}"]
            mu = bounded(design, getattr(trace.friction, f"mu_{axis}"))  # limiting adds nothing to an error
            by = Affine.noise(f"mu_{axis}", results[f"mu_{axis}"] * self.scalar)
            error = self._blocks.product(f"shear_{axis}", "field", at_taxels.p0, p0)
            form += self._blocks.combined(f"mu_{axis} s", mu, by, sheared, error)
            quads = combine(design, quads, mu, sheared)
        p = clipped("p", to_taxels(design, butterfly(quads)), self._taxels @ form)
        return {"p": p.radius, "forces": self._forces(trace, total, p)}

    def _forces(self, trace: Trace, total: Affine, p: Affine) -> Floats:
        """A quotient of words, of which the sum of p is cut off, times p; rounded twice."""
        design, at_taxels, bits = self.design, trace.field, self.design.widths.division
        assert at_taxels is not None
        part, words = at_taxels.share, flat(at_taxels.p)
        whole = words.sum(axis=1)[:, None]
        force = trace.force.words * 2.0 ** -trace.force.exponent[:, None]
        total = np.eye(3, 4) @ total + Affine.noise("force words", filled(outputs(trace.total)[:, :3], 1, bits))
        top = (1 << (design.formats.bits("scalar") - 1)) - 1
        size = np.abs(part.mantissa)
        rounded = np.where(size == top, 1.0, 0.5)
        own = (size + rounded) * (cut(at_taxels.p.sum(axis=1), bits)[:, None] / whole) + rounded
        scale = 2.0 ** (design.formats.force_fraction - design.formats.vector_fraction)
        everywhere, found = np.ones((1, design.sensor.taxels)) @ p, []
        for axis in range(3):
            share = force[:, axis : axis + 1] / whole
            over = np.eye(3)[axis : axis + 1] @ total
            by = quotient(f"share {axis}", over, share, everywhere, whole)
            error = product(f"force {axis}", by, share, p, words).radius * scale
            shift = part.shift[:, None]
            found.append(error + words * own[:, axis : axis + 1] * 2.0**-shift + shifted(shift))
        return np.concatenate(found, axis=1)


def activated(noise: str, words: Ints, error: Affine) -> Affine:
    """Error of units: a butterfly, max(0, x), a butterfly; ``words (n, units, 4)`` enter them."""
    fold = unfolded(words.shape[1])
    return fold @ clipped(noise, flat(butterfly(words)), fold @ error)
