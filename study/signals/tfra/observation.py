"""Every word of the bit-accurate model for some frames, its rounding, and the format that it has to fit."""

import numpy as np

from tfra.model.arrays import Ints
from tfra.model.fixed.butterfly import butterfly
from tfra.model.fixed.combine import products
from tfra.model.fixed.design import Design
from tfra.model.fixed.matvec import accumulate, operand
from tfra.model.fixed.tfra.bounds import bounds
from tfra.model.fixed.tfra.centroids import moments, offset, pitch_ratio
from tfra.model.fixed.tfra.dependent import gather_sums, quotients
from tfra.model.fixed.tfra.forces import friction_forces, scalars
from tfra.model.fixed.tfra.pipeline import Stage, Trace, ordered
from tfra.model.fixed.tfra.resultant import exact_resultant
from tfra.model.fixed.widths import force_drop, scalar_fraction
from tfra.model.tfra import COEFFICIENT_LIMIT
from tfra.study.signals.measures import Observed, Word, cast, filled
from tfra.study.signals.tfra.signals import stage_of

OPERANDS = {"contact": "b", "residual": "n", "normal0": "e0", "normal1": "e1", "force": "d"}
"""The vector that each product multiplies."""

UNSIGNED = ("moment", "b_z", "b_xy", "magnitude")


def catalogue(design: Design) -> dict[str, Word]:
    """The word of every signal, in the order of the stages."""
    words = {}
    for field, quantities in bounds(design, design.stacks).items():
        for name, bound in quantities.items():
            signal = f"{name}.accumulator" if field == "accumulator" else name
            bits = getattr(design.widths, field)
            words[signal] = Word(stage_of(signal), field, bits, field not in UNSIGNED, bound)
    formats, division, fraction = design.formats, design.widths.division, scalar_fraction(design)
    operands = {name: f"operand.{name.rstrip('01')}" for name in OPERANDS}
    for signal, name in (operands | {"d_dep": "operand.combine", "sums": "sums", "direction": "direction"}).items():
        words[f"{signal}.operand"] = Word.full(stage_of(f"{signal}.operand"), name, formats.bits(name))
    for signal in ("direction.division", "quotient.division", "f_star.division"):
        words[signal] = Word.full(stage_of(signal), "division", division)
    for signal, limit in (("alpha", COEFFICIENT_LIMIT), ("beta", COEFFICIENT_LIMIT), ("mu_ind", 1.0)):
        words[signal] = Word(stage_of(signal), "scalar", formats.bits("scalar"), True, limit * 2**fraction)
    words["mu_dep"] = Word.full(Stage.FRICTION, "scalar", formats.bits("scalar"))
    words["gain"] = Word.full(Stage.GAIN, "scalar", formats.bits("scalar"), signed=False)
    layout = {f.name: f for f in design.layout}
    for signal in ("mu", "phi", "resultant", "forces"):
        field_of = layout[signal]
        words[signal] = Word.full(stage_of(signal), "result", field_of.bits, signed=field_of.signed)
    order = list(Stage)
    return dict(sorted(words.items(), key=lambda item: order.index(Stage(item[1].stage))))


def observe(design: Design, trace: Trace) -> dict[str, Observed]:
    """Every signal of :func:`catalogue` in ``trace``."""
    parts = _front, _products, _dependent, _updates, _sweep, _results
    return {signal: observed for part in parts for signal, observed in part(design, trace).items()}


def _front(design: Design, trace: Trace) -> dict[str, Observed]:
    sums, first = moments(design, trace.codes)
    exact = offset(sums, first)
    length = filled(exact, 1, design.widths.division)
    return {
        "stress": Observed(trace.frame.stress),
        "magnitude": Observed(trace.frame.magnitude),
        "b": Observed(trace.b),
        "moment": Observed(first),
        "direction": Observed(exact),
        "direction.division": length,
        "direction.operand": filled(length.values * np.array(pitch_ratio(design)), 1, design.formats.bits("direction")),
    }


def _products(design: Design, trace: Trace) -> dict[str, Observed]:
    """Operands, exact sums and results of the five products."""
    observed, normal = {}, []
    for product, vector in OPERANDS.items():
        source, stack = getattr(trace, vector), product.rstrip("01")
        bits = design.formats.bits(f"operand.{stack}")
        words, significant = operand(source, bits)
        observed[f"{product}.operand"] = filled(source, 1, bits)
        for op in design.stacks[stack].operators:
            sums, shift = accumulate(op, words, bits, significant)
            observed[product if op.name == "normal" else op.name] = cast(sums, shift[:, None])
            if op.name == "normal":
                normal.append(sums)
            else:
                observed[f"{op.name}.accumulator"] = Observed(sums)
    observed["n"] = Observed(trace.n, cast(butterfly(observed["c33_inv"].values), 2).rounded)
    observed["normal.accumulator"] = Observed(np.hstack(normal))
    return observed


def _dependent(design: Design, trace: Trace) -> dict[str, Observed]:
    affine, fraction = trace.affine, scalar_fraction(design)
    by_b, by_n = design.stacks["contact"].split(trace.contact), design.stacks["residual"].split(trace.residual)
    exact = gather_sums(by_b["sums_b"], by_n["sums_n"])
    quotient = filled(quotients(affine.sums, trace.direction), 1, design.widths.division)
    divided = np.abs(quotient.values[trace.frame.regular & ~affine.vanishing])
    inexact = [int(np.count_nonzero((divided[:, i] << fraction) % divided[:, 2])) for i in (0, 1)]
    return {
        "sums": Observed(exact),
        "sums.operand": filled(exact, (1, 2), design.formats.bits("sums")),
        "quotient.division": quotient,
        "alpha": Observed(affine.alpha, inexact[0]),
        "beta": Observed(affine.beta, inexact[1]),
    }


def _updates(design: Design, trace: Trace) -> dict[str, Observed]:
    by_n, affine, chosen = design.stacks["residual"].split(trace.residual), trace.affine, trace.chosen
    _, d_dep = ordered(trace.direction, by_n["c31"], by_n["c32"])

    def added(values: Ints, *terms: tuple[Ints, Ints]) -> Observed:
        """``values``, to which rounded products of a scalar and a vector were added."""
        rounded = 0
        for scalar, vector in terms:
            exact, shift = products(design, scalar, vector)
            rounded += cast(exact, shift[:, None]).rounded or 0
        return Observed(values, rounded)

    folded = friction_forces(design, trace.force, chosen, trace.n)
    unscaled = butterfly(folded)
    return {
        "d0": Observed(trace.b + by_n["c33"]),
        "d_dep.operand": filled(d_dep, 1, design.formats.bits("operand.combine")),
        "e0": added(trace.e0, (affine.alpha, d_dep)),
        "e1": added(trace.e1, (affine.beta, d_dep)),
        "d": added(trace.d, (chosen.mu_ind, trace.e1)),
        "unscaled": added(unscaled, *((scalar, trace.n) for scalar in scalars(design, chosen))),
        "force": cast(unscaled, force_drop(design)),
    }


def _sweep(design: Design, trace: Trace) -> dict[str, Observed]:
    """The first and the last candidate are the extremes of all, as each taxel's is affine in mu."""
    steps = design.search.steps
    first = steps * (trace.p - np.where(trace.direction.negative[:, None], trace.q, 0))
    return {
        "p": Observed(trace.p),
        "q": Observed(trace.q),
        "candidate": Observed(np.stack([first, first + steps * trace.q], axis=1)),
        "b_z": Observed(trace.swept.b_z),
        "b_xy": Observed(trace.swept.b_xy),
    }


def _results(design: Design, trace: Trace) -> dict[str, Observed]:
    frame, chosen, factor, fraction = trace.frame, trace.chosen, trace.factor, scalar_fraction(design)
    mu_dep = cast(trace.affine.beta * chosen.mu_ind, fraction)
    limited = np.abs(trace.affine.alpha + mu_dep.values) >= 4 << fraction
    grid = frame.regular & ((chosen.index << fraction) % design.search.steps != 0)
    total = exact_resultant(design, trace.affine, chosen, frame.regular)
    keep = np.stack([frame.regular, frame.regular, frame.contact], axis=1)
    bits, mantissa = design.widths.output, factor.mantissa[:, None]
    resultant = cast(trace.total.words * mantissa * keep, factor.resultant_shift[:, None], bits)
    planes = trace.planes * mantissa[:, :, None] * keep[:, :, None]
    top = factor.mu == (1 << (next(f.bits for f in design.layout if f.name == "mu") - 1)) - 1
    dependent = np.where(trace.direction.sweep_y, chosen.mu_x, chosen.mu_y)
    return {
        "mu_ind": Observed(chosen.mu_ind, int(grid.sum())),
        "mu_dep": Observed(dependent, mu_dep.rounded, int(limited.sum())),
        "f_star.division": filled(total, 1, design.widths.division),
        "gain": Observed(factor.mantissa, None, int((factor.overflow & ~top).sum())),
        "mu": Observed(factor.mu, None, int((factor.overflow & top).sum())),
        "phi": Observed(trace.phi, None),
        "resultant": resultant,
        "forces": cast(planes, factor.force_shift[:, None, None], bits),
    }
