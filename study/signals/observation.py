"""Every word of the bit-accurate model for some frames, its rounding, and the format that it has to fit."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tfra.model.arrays import Ints
from tfra.model.fixed.butterfly import butterfly
from tfra.model.fixed.combine import products
from tfra.model.fixed.design import Design
from tfra.model.fixed.matvec import accumulate, operand
from tfra.model.fixed.numbers import round_shift, saturate, significant_bits
from tfra.model.fixed.scalars import scalar_fraction
from tfra.model.fixed.tfra.bounds import bounds
from tfra.model.fixed.tfra.centroids import moments, offset, pitch_ratio
from tfra.model.fixed.tfra.dependent import gather_sums, quotients
from tfra.model.fixed.tfra.forces import friction_forces, scalars
from tfra.model.fixed.tfra.pipeline import Trace, ordered
from tfra.model.fixed.tfra.resultant import exact_resultant
from tfra.model.fixed.tfra.stages import Stage
from tfra.model.fixed.widths import force_drop
from tfra.model.tfra import COEFFICIENT_LIMIT

OPERANDS = {"contact": "b", "residual": "n", "normal0": "e0", "normal1": "e1", "force": "d"}
"""The vector that each product multiplies."""

UNSIGNED = ("moment", "b_z", "b_xy", "magnitude")


@dataclass(frozen=True)
class Word:
    """A signal's word: the field of ``Widths``, or the format, that its length comes from.

    ``bound`` is the largest magnitude by proof; where ``proven`` is false, words are shifted to fill the format, or
    limited to it, and the bound is the format's.
    """

    stage: Stage
    name: str
    bits: int
    signed: bool
    bound: float
    proven: bool = True


@dataclass(frozen=True)
class Seen:
    """Words ``(n, …)``; how many were ``rounded`` to another value and how many ``saturated``.

    ``rounded`` is ``None`` after a CORDIC, which rounds in every rotation.
    """

    values: Ints
    rounded: int | None = 0
    saturated: int = 0


def catalogue(design: Design) -> dict[str, Word]:
    """The word of every signal, in the order of the data within each of its kinds."""
    found = {}
    for field, quantities in bounds(design, design.stacks).items():
        for name, bound in quantities.items():
            signal = f"{name}.accumulator" if field == "accumulator" else name
            bits = getattr(design.widths, field)
            found[signal] = Word(_stage(signal), field, bits, field not in UNSIGNED, bound)
    formats, division, fraction = design.formats, design.widths.division, scalar_fraction(design)
    operands = {name: f"operand.{name.rstrip('01')}" for name in OPERANDS}
    for signal, name in (operands | {"d_dep": "operand.combine", "sums": "sums", "direction": "direction"}).items():
        found[f"{signal}.operand"] = _full(_stage(f"{signal}.operand"), name, formats.bits(name))
    for signal in ("direction.division", "quotient.division", "f_star.division"):
        found[signal] = _full(_stage(signal), "division", division)
    for signal, limit in (("alpha", COEFFICIENT_LIMIT), ("beta", COEFFICIENT_LIMIT), ("mu_ind", 1.0)):
        found[signal] = Word(_stage(signal), "scalar", formats.bits("scalar"), True, limit * 2**fraction)
    found["mu_dep"] = _full(Stage.FRICTION, "scalar", formats.bits("scalar"))
    found["gain"] = _full(Stage.GAIN, "scalar", formats.bits("scalar"), signed=False)
    layout = {f.name: f for f in design.layout}
    for signal in ("mu", "phi", "resultant", "forces"):
        field_of = layout[signal]
        found[signal] = _full(_stage(signal), "result", field_of.bits, signed=field_of.signed)
    return found


def _full(stage: Stage, name: str, bits: int, signed: bool = True) -> Word:
    return Word(stage, name, bits, signed, float(2 ** (bits - 1) if signed else 2**bits - 1), proven=False)


_STAGES = {
    Stage.NORMALISER: ("stress", "b", "magnitude"),
    Stage.CENTROIDS: ("moment", "direction"),
    Stage.WEIGHTS: ("n",),
    Stage.DEPENDENT: ("sums", "quotient", "alpha", "beta"),
    Stage.COMBINE: ("d0", "d_dep", "e0", "e1", "d"),
    Stage.SWEEP: ("p", "q", "candidate", "b_z", "b_xy"),
    Stage.FRICTION: ("mu_ind", "mu_dep"),
    Stage.RESULTANT: ("f_star",),
    Stage.GAIN: ("gain", "mu"),
    Stage.FORCES: ("unscaled", "force"),
    Stage.ANGLE: ("phi",),
    Stage.SCALING: ("resultant", "forces"),
}


def _stage(signal: str) -> Stage:
    """The stage of ``signal``; all others are products and their operands."""
    quantity = signal.partition(".")[0]
    if signal == "force.operand":
        return Stage.MATVEC
    return next((stage for stage, names in _STAGES.items() if quantity in names), Stage.MATVEC)


def observe(design: Design, trace: Trace) -> dict[str, Seen]:
    """Every signal of :func:`catalogue` in ``trace``."""
    parts = _front, _products, _dependent, _updates, _sweep, _results
    return {signal: seen for part in parts for signal, seen in part(design, trace).items()}


def cast(exact: Ints, shift: npt.ArrayLike, bits: int | None = None) -> Seen:
    """``exact / 2^shift`` as words, limited to ``bits`` if given."""
    shift = np.asarray(shift, dtype=np.int64)
    lost = exact & ((np.int64(1) << np.clip(shift, 0, 62)) - 1)
    wide = round_shift(exact, shift)
    values = wide if bits is None else saturate(wide, bits)
    return Seen(values, int(np.count_nonzero(lost)), int(np.count_nonzero(values != wide)))


def filled(exact: Ints, axis: int | tuple[int, ...], bits: int) -> Seen:
    """``exact`` words, those along ``axis`` moved together to fill ``bits``."""
    significant = significant_bits(exact, axis)
    return cast(exact, np.expand_dims(significant, axis) - (bits - 1), bits)


def _front(design: Design, trace: Trace) -> dict[str, Seen]:
    sums, first = moments(design, trace.codes)
    exact = offset(sums, first)
    length = filled(exact, 1, design.widths.division)
    return {
        "stress": Seen(trace.frame.stress),
        "magnitude": Seen(trace.frame.magnitude),
        "b": Seen(trace.b),
        "moment": Seen(first),
        "direction": Seen(exact),
        "direction.division": length,
        "direction.operand": filled(length.values * np.array(pitch_ratio(design)), 1, design.formats.bits("direction")),
    }


def _products(design: Design, trace: Trace) -> dict[str, Seen]:
    """Operands, exact sums and results of the five products."""
    found, normal = {}, []
    for product, vector in OPERANDS.items():
        source, stack = getattr(trace, vector), product.rstrip("01")
        bits = design.formats.bits(f"operand.{stack}")
        words, significant = operand(source, bits)
        found[f"{product}.operand"] = filled(source, 1, bits)
        for op in design.stacks[stack].operators:
            sums, shift = accumulate(op, words, bits, significant)
            found[product if op.name == "normal" else op.name] = cast(sums, shift[:, None])
            if op.name == "normal":
                normal.append(sums)
            else:
                found[f"{op.name}.accumulator"] = Seen(sums)
    return found | {"n": _weights(trace, found["c33_inv"].values), "normal.accumulator": Seen(np.hstack(normal))}


def _weights(trace: Trace, solution: Ints) -> Seen:
    return Seen(trace.n, cast(butterfly(solution), 2).rounded)


def _dependent(design: Design, trace: Trace) -> dict[str, Seen]:
    affine, fraction = trace.affine, scalar_fraction(design)
    by_b, by_n = design.stacks["contact"].split(trace.contact), design.stacks["residual"].split(trace.residual)
    exact = gather_sums(by_b["sums_b"], by_n["sums_n"])
    quotient = filled(quotients(affine.sums, trace.direction), 1, design.widths.division)
    divided = np.abs(quotient.values[trace.frame.regular & ~affine.vanishing])
    inexact = [int(np.count_nonzero((divided[:, i] << fraction) % divided[:, 2])) for i in (0, 1)]
    return {
        "sums": Seen(exact),
        "sums.operand": filled(exact, (1, 2), design.formats.bits("sums")),
        "quotient.division": quotient,
        "alpha": Seen(affine.alpha, inexact[0]),
        "beta": Seen(affine.beta, inexact[1]),
    }


def _updates(design: Design, trace: Trace) -> dict[str, Seen]:
    by_n, affine, chosen = design.stacks["residual"].split(trace.residual), trace.affine, trace.chosen
    _, d_dep = ordered(trace.direction, by_n["c31"], by_n["c32"])

    def added(values: Ints, *terms: tuple[Ints, Ints]) -> Seen:
        """``values``, to which rounded products of a scalar and a vector were added."""
        rounded = 0
        for scalar, vector in terms:
            exact, shift = products(design, scalar, vector)
            rounded += cast(exact, shift[:, None]).rounded or 0
        return Seen(values, rounded)

    folded = friction_forces(design, trace.force, chosen, trace.n)
    unscaled = butterfly(folded)
    return {
        "d0": Seen(trace.b + by_n["c33"]),
        "d_dep.operand": filled(d_dep, 1, design.formats.bits("operand.combine")),
        "e0": added(trace.e0, (affine.alpha, d_dep)),
        "e1": added(trace.e1, (affine.beta, d_dep)),
        "d": added(trace.d, (chosen.mu_ind, trace.e1)),
        "unscaled": added(unscaled, *((scalar, trace.n) for scalar in scalars(design, chosen))),
        "force": cast(unscaled, force_drop(design)),
    }


def _sweep(design: Design, trace: Trace) -> dict[str, Seen]:
    """The first and the last candidate are the extremes of all, as each taxel's is affine in mu."""
    steps = design.search.steps
    first = steps * (trace.p - np.where(trace.direction.negative[:, None], trace.q, 0))
    return {
        "p": Seen(trace.p),
        "q": Seen(trace.q),
        "candidate": Seen(np.stack([first, first + steps * trace.q], axis=1)),
        "b_z": Seen(trace.found.b_z),
        "b_xy": Seen(trace.found.b_xy),
    }


def _results(design: Design, trace: Trace) -> dict[str, Seen]:
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
    return {
        "mu_ind": Seen(chosen.mu_ind, int(grid.sum())),
        "mu_dep": Seen(np.where(trace.direction.sweep_y, chosen.mu_x, chosen.mu_y), mu_dep.rounded, int(limited.sum())),
        "f_star.division": filled(total, 1, design.widths.division),
        "gain": Seen(factor.mantissa, None, int((factor.overflow & ~top).sum())),
        "mu": Seen(factor.mu, None, int((factor.overflow & top).sum())),
        "phi": Seen(trace.phi, None),
        "resultant": resultant,
        "forces": cast(planes, factor.force_shift[:, None, None], bits),
    }
