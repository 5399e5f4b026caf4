"""Bounds on the errors of the learned estimator's signals, from the codes on."""

from collections.abc import Mapping

import numpy as np

from tfra.model.arrays import Floats, Ints
from tfra.model.fixed.butterfly import EE, butterfly, to_taxels
from tfra.model.fixed.coefficients import Folding
from tfra.model.fixed.combine import combine
from tfra.model.fixed.learned.design import LearnedDesign
from tfra.model.fixed.learned.field import bounded
from tfra.model.fixed.learned.operators import PLACES, field_matrices, network_rows, outputs
from tfra.model.fixed.learned.pipeline import Trace
from tfra.model.learned.field import MOST_FRICTION
from tfra.study.bounds.affine import Affine, product, quotient
from tfra.study.bounds.blocks import Blocks, clipped, flat, unfolded
from tfra.study.bounds.bounds import ErrorBounds, Signals
from tfra.study.bounds.friction import friction, ratio
from tfra.study.bounds.rotation import Rotation
from tfra.study.bounds.slack import cut, filled, matrix, shifted
from tfra.study.signals.learned.instrument import LearnedInstrument
from tfra.study.signals.measures import Values

UNITS = ("h1", "h2", "outputs")
RESULTS = ("resultant", "uncertainty", "mu_x", "mu_y", "mu")


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
        rounded = filled(outputs(trace.total)[:, :3], 1, self.design.widths.division)
        forms["force"] = forms["outputs"].through(np.eye(3, 4)) + Affine.noise("force words", rounded)
        forms |= self._quotients(trace, forms["force"])
        shift = self.design.formats.vector_fraction - self.design.formats.force_fraction
        results = forms["outputs"].radius * 2.0**-shift + shifted(shift)
        units = {name: forms[name].radius for name in UNITS}
        mus = {name: forms[name].radius / self.scalar for name in ("mu_x", "mu_y")}
        mus["mu"] = self._mu(trace, forms["force"].radius)
        found = {
            "phi": {"phi": self._phi(trace, forms["force"])},
            "units": units,
            "results": {"resultant": results[:, :3], "uncertainty": results[:, 3:], **mus},
            "field": {} if trace.field is None else self._field(trace, b, forms),
        }
        return {(part, name): found[part][name] for part, names in self.parts.items() for name in names}

    def _network(self, trace: Trace, b: Ints) -> dict[str, Affine]:
        """h = max(0, C h), twice, and the outputs of both and of b."""
        make = self._blocks.product
        first = self.design.stacks["first"].split(trace.first)["first"]
        second = self.design.stacks["second"].split(trace.second)["second"]
        h1 = activated("h1", first, make("first", "first", b, None))
        h2 = activated("h2", second, make("second", "second", trace.h1, h1))
        quads = make("direct", "first", b, None) + make("read1", "second", trace.h1, h1)
        quads += make("read2", "read", trace.h2, h2)
        place = np.eye(8)[[4 * quad + parity for quad, parity in PLACES]]
        return {"h1": h1, "h2": h2, "outputs": quads.through(place)}

    def _phi(self, trace: Trace, force: Affine) -> Floats:
        """Of phi: the force's errors across its direction, and along it, decide the angle."""
        words = flat(trace.force.words[:, :2])
        length = np.hypot(words[:, 0], words[:, 1])
        x, y = (words / length[:, None]).T
        turn = np.stack([np.stack([x, y, 0 * x], axis=1), np.stack([-y, x, 0 * x], axis=1)], axis=1)
        along, across = force.through(turn).radius.T * 2.0**trace.force.exponent
        left = np.maximum(length - along, length / 2)  # without a bound where along is more than half
        off = np.where(2 * along <= length, length * np.sin(np.arctan2(across, left)), np.inf)
        return Rotation.of(self.design).angle(length, length, off)[:, None]

    def _mu(self, trace: Trace, off: Floats) -> Floats:
        """Of mu in last bits, from a force that is ``off``: a modulus changes no more than its vector."""
        value = np.abs(trace.force.words * 2.0 ** -trace.force.exponent[:, None])
        both = np.hypot(value[:, 0], value[:, 1]), np.hypot(off[:, 0], off[:, 1])
        error = friction(self.design, trace.force.words) + ratio(*both, value[:, 2], off[:, 2])
        return (error / self.scalar + limited(trace.friction.mu, self.design.formats.bits("scalar")))[:, None]

    def _quotients(self, trace: Trace, force: Affine) -> dict[str, Affine]:
        """mu_x = F_x / |F_z| and mu_y, rounded."""
        words, found = trace.force.words.astype(np.float64), {}
        value, sign = words * 2.0 ** -trace.force.exponent[:, None], np.sign(words[:, 2:])
        under, normal = force.through(np.eye(3)[2:]).times(sign), np.abs(value[:, 2:])
        for axis, name in enumerate(("mu_x", "mu_y")):
            over, x = force.through(np.eye(3)[axis : axis + 1]), value[:, axis : axis + 1]
            rounded = limited(getattr(trace.friction, name), self.design.formats.bits("scalar"))[:, None]
            found[name] = quotient(f"{name} quotient", over, x / normal, under, normal)
            found[name] += Affine.noise(name, rounded * self.scalar)
        return found

    def _field(self, trace: Trace, b: Ints, forms: dict[str, Affine]) -> dict[str, Floats]:
        """Of p = max(0, -K b + mu_x s_x + mu_y s_y) on the vector grid, and of the forces F p / sum of p."""
        design, at_taxels = self.design, trace.field
        assert at_taxels is not None
        still = design.stacks["first"].split(trace.first)["inverse"]
        form = self._blocks.product("inverse", "first", b, None)
        p0, quads = activated("p0", still, form), still
        for axis in ("x", "y"):
            sheared = design.stacks["field"].split(at_taxels.sheared)[f"shear_{axis}"]
            word, by = getattr(trace.friction, f"mu_{axis}"), forms[f"mu_{axis}"]
            mu, near = bounded(design, word), np.abs(word[:, None] * self.scalar) + by.radius <= MOST_FRICTION
            # Where one of both may be limited, the error is not what it was, but no more.
            by = by.times(near * 1.0) + Affine.noise(f"mu_{axis} limited", np.where(near, 0.0, by.radius))
            error = self._blocks.product(f"shear_{axis}", "field", at_taxels.p0, p0)
            form += self._blocks.combined(f"mu_{axis} s", mu, by, sheared, error)
            quads = combine(design, quads, mu, sheared)
        p = clipped("p", to_taxels(design, butterfly(quads)), form.through(self._taxels))
        return {"p": p.radius, "forces": self._forces(trace, forms["force"], p)}

    def _forces(self, trace: Trace, total: Affine, p: Affine) -> Floats:
        """A quotient of words, of which the sum of p is cut off, times p; rounded twice."""
        design, at_taxels, bits = self.design, trace.field, self.design.widths.division
        assert at_taxels is not None
        part, words = at_taxels.share, flat(at_taxels.p)
        whole = words.sum(axis=1)[:, None]
        force = trace.force.words * 2.0 ** -trace.force.exponent[:, None]
        size, rounded = np.abs(part.mantissa), limited(part.mantissa, design.formats.bits("scalar"))
        own = (size + rounded) * (cut(at_taxels.p.sum(axis=1), bits)[:, None] / whole) + rounded
        scale = 2.0 ** (design.formats.force_fraction - design.formats.vector_fraction)
        everywhere, found = p.through(np.ones((1, design.sensor.taxels))), []
        for axis in range(3):
            share = force[:, axis : axis + 1] / whole
            over = total.through(np.eye(3)[axis : axis + 1])
            by = quotient(f"share {axis}", over, share, everywhere, whole)
            error = product(f"force {axis}", by, share, p, words).radius * scale
            shift = part.shift[:, None]
            found.append(error + words * own[:, axis : axis + 1] * 2.0**-shift + shifted(shift))
        return np.concatenate(found, axis=1)


def limited(words: Ints, bits: int) -> Floats:
    """Of quotients as ``words`` of ``bits``, rounded half up: a half, and one that is limited less than a unit."""
    return np.where(np.abs(words) == (1 << (bits - 1)) - 1, 1.0, 0.5)


def activated(noise: str, words: Ints, error: Affine) -> Affine:
    """Error of units: a butterfly, max(0, x), a butterfly; ``words (n, units, 4)`` enter them."""
    fold = unfolded(words.shape[1])
    return clipped(noise, flat(butterfly(words)), error.through(fold)).through(fold)
