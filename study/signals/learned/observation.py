"""Every word of the bit-accurate model for some frames, its rounding, and the format that it has to fit."""

import numpy as np

from tfra.model.arrays import Ints
from tfra.model.fixed.butterfly import butterfly
from tfra.model.fixed.combine import products
from tfra.model.fixed.learned.bounds import bounds, total_bits
from tfra.model.fixed.learned.design import LearnedDesign
from tfra.model.fixed.learned.field import bounded
from tfra.model.fixed.learned.operators import outputs
from tfra.model.fixed.learned.pipeline import Field, Stage, Trace
from tfra.model.fixed.learned.share import even_word
from tfra.model.fixed.matvec import accumulate, operand
from tfra.model.learned.network import MIRRORS
from tfra.study.signals.learned.signals import stage_of
from tfra.study.signals.measures import Observed, Word, cast, filled

OPERANDS = {"first": "b", "second": "h1", "read": "h2", "field": "p0"}
"""The vector that each product multiplies."""

_RESULTS = {
    "first": "h1", "inverse": "p0", "second": "h2", "direct": "outputs", "read1": "outputs", "read2": "outputs",
    "shear_x": "sheared", "shear_y": "sheared",
}  # fmt: skip
"""The quantity whose bound holds for the results of each operator, too."""


def catalogue(design: LearnedDesign) -> dict[str, Word]:
    """The word of every signal, in the order of the stages."""
    w, most, lane = design.widths, bounds(design, design.stacks), (1 << (design.adc.bits - 1))
    found = {"stress": ("stress", w.stress, float(lane))}
    folded = {name: MIRRORS * most[name] for name in OPERANDS.values() if name in most}
    results = {name: most[_RESULTS[name]] for name in design.kinds}
    vectors = folded | results | {"outputs": most["outputs"]}
    found |= {name: ("vector", w.vector, bound) for name, bound in vectors.items()}
    for stack in design.stacks.values():
        bits = design.formats.bits(f"operand.{stack.name}")
        for op in stack.operators:
            found[f"{op.name}.accumulator"] = ("accumulator", w.accumulator, float(op.row_sum << (bits - 1)))
    if design.taxel_forces:
        found["p"] = ("force", w.force, most["p"])
    words = {name: Word(stage_of(name), field, bits, True, bound) for name, (field, bits, bound) in found.items()}
    if design.taxel_forces:
        bits, bound = total_bits(design, w), design.sensor.taxels * max(most["p"], even_word(design))
        words["total"] = Word(stage_of("total"), "force", bits, False, bound)
    return _ordered(words | _formats(design))


def _formats(design: LearnedDesign) -> dict[str, Word]:
    """Words that are shifted to fill their format, or limited to it."""
    bits = design.formats.bits
    lengths = {f"{product}.operand": f"operand.{product}" for product in design.products}
    lengths |= {"force.division": "division"}
    if design.taxel_forces:
        lengths |= {"shear_x.operand": "operand.combine", "shear_y.operand": "operand.combine", "share": "scalar"}
    words = {signal: Word.full(stage_of(signal), name, bits(name)) for signal, name in lengths.items()}
    for field in design.layout:
        if (stage := stage_of(field.name)) is not Stage.MATVEC:  # those of the frame itself are no signals
            words[field.name] = Word.full(stage, "result", field.bits, signed=field.signed)
    return words


def _ordered(words: dict[str, Word]) -> dict[str, Word]:
    order = list(Stage)
    return dict(sorted(words.items(), key=lambda item: order.index(Stage(item[1].stage))))


def observe(design: LearnedDesign, trace: Trace) -> dict[str, Observed]:
    """Every signal of :func:`catalogue` in ``trace``."""
    found = _network(design, trace) | _results(design, trace)
    return found if trace.field is None else found | _forces(design, trace, trace.field)


def _network(design: LearnedDesign, trace: Trace) -> dict[str, Observed]:
    b = butterfly(trace.stress) << design.formats.vector_fraction
    found = {"stress": Observed(trace.frame.stress), "b": Observed(b)}
    found |= {name: Observed(getattr(trace, name)) for name in ("h1", "h2")}
    for product, vector in (("first", b), ("second", trace.h1), ("read", trace.h2)):
        found |= _product(design, product, vector)
    return found | {"outputs": Observed(outputs(trace.total))}


def _product(design: LearnedDesign, stack: str, vector: Ints) -> dict[str, Observed]:
    """Operand, exact sums and results of a product."""
    bits = design.formats.bits(f"operand.{stack}")
    words, significant = operand(vector, bits)
    found = {f"{stack}.operand": filled(vector, 1, bits)}
    for op in design.stacks[stack].operators:
        sums, shift = accumulate(op, words, bits, significant)
        found |= {f"{op.name}.accumulator": Observed(sums), op.name: cast(sums, shift[:, None])}
    return found


def _results(design: LearnedDesign, trace: Trace) -> dict[str, Observed]:
    exact, bits = outputs(trace.total), design.widths.output
    shift = design.formats.vector_fraction - design.formats.force_fraction
    friction = trace.friction
    top = (1 << (design.formats.bits("scalar") - 1)) - 1
    ratios = {
        name: Observed(values, None, int((friction.overflow & (np.abs(values) == top)).sum()))
        for name, values in (("mu", friction.mu), ("mu_x", friction.mu_x), ("mu_y", friction.mu_y))
    }
    return {
        "force.division": filled(exact[:, :3], 1, design.widths.division),
        "resultant": cast(exact[:, :3], shift, bits),
        "uncertainty": cast(np.maximum(exact[:, 3], 0), shift, bits),
        "phi": Observed(trace.turned.phi, None),
        **ratios,
    }


def _forces(design: LearnedDesign, trace: Trace, field: Field) -> dict[str, Observed]:
    found = _product(design, "field", field.p0) | {"p0": Observed(field.p0)}
    by_axis, rounded = design.stacks["field"].split(field.sheared), 0
    for name, scalar in (("shear_x", trace.friction.mu_x), ("shear_y", trace.friction.mu_y)):
        found[f"{name}.operand"] = filled(by_axis[name], 1, design.formats.bits("operand.combine"))
        exact, shift = products(design, bounded(design, scalar), by_axis[name])
        rounded += cast(exact, shift[:, None]).rounded or 0
    part, even = field.share, field.share.even[:, None]
    spread = np.where(even, even_word(design), field.p)
    wide = spread[:, None] * part.mantissa[:, :, None]
    return found | {
        "p": Observed(field.p, rounded),
        "total": Observed(spread.sum(axis=1)),
        "share": Observed(part.mantissa, None),
        "forces": cast(wide, part.shift[:, None, None], design.widths.output),
    }
