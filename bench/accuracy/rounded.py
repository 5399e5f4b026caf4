"""What the learned estimator's word lengths cost in accuracy, with and without a training that knows them.

``python -m bench.accuracy.rounded`` measures the bit-accurate model of the example's network in many word lengths,
trains it on for some of them, and writes ``bench/results/rounded.json``, the figure beside it and the table of
docs/training.md.
"""

import argparse
from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import cache
from itertools import product
from typing import Any
from unittest.mock import patch

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from bench.publish import ROOT, publish
from tfra.codegen.config.read import load
from tfra.model.fixed.learned import operators
from tfra.model.fixed.learned.design import LearnedDesign
from tfra.model.fixed.words import decode
from tfra.model.learned.network import NAMES, Weights, fold
from tfra.model.metrics import errors
from tfra.model.sensor import SensorArray
from tfra.model.tfra import Result
from tfra.train.heldout import PERCENTILES, QUIET, SEED, TABLE, Resultants, Series
from tfra.train.loop import Trainer
from tfra.train.pool import Pool
from tfra.train.rounding import Rounding

CONFIG = "examples/learned_resultant.toml"
CONTACTS, STEPS = 4000, 30_000

READ = 10
"""Bits of the coefficients of the outputs, which are few."""

ROUNDED = tuple(
    (*layers, *operands) for *layers, operands in product(range(6, 12), range(6, 11), ((9, 8), (10, 9), (11, 10)))
)
"""Bits of the coefficients of both layers, and of the operands of both, that are rounded to without a training."""

TRAINED = ((8, 7, 10, 9), (9, 8, 10, 9))
"""Those of the trainings."""

SAME, FORCE = 5.0, ("force_percent_50", "force_percent_95")
"""Largest excess of errors that counts as none, in percent, and their keys."""

SERIES = {
    "range": "rounded, units of one range",
    "words": "rounded, units that fill their words",
    "trained": "trained with rounding",
}

Bits = tuple[int, ...]


class Bench:
    """The contacts that every design sees, as codes of the converter, and their resultants."""

    def __init__(self, design: LearnedDesign) -> None:
        series = Series.of(design.sensor, CONTACTS, SEED)
        self._design, self._truth = design, Resultants(series.force)
        codes = np.rint((series.exact + QUIET * series.noise) / series.step).astype(np.int64)
        self._codes = codes.reshape(-1, design.sensor.rows, design.sensor.columns)
        self._newtons = series.step / (design.adc.lsb * design.sensor.taxel_area)

    def floating(self) -> dict[str, float]:
        """Errors in double precision."""
        return self._errors(self._design.float_model(self._codes * self._design.adc.lsb))

    def point(self, bits: Bits, weights: Weights) -> dict[str, Any]:
        """Errors and price of a core with ``weights``."""
        design = designed(self._design, bits, weights)
        found = self._errors(decode(design, design.model.words(self._codes)))
        return {"bits": list(bits), "price": price(design), "kbit": design.coefficient_bits / 1000, **found}

    def _errors(self, result: Result) -> dict[str, float]:
        every = errors(self._truth, Resultants(result.resultant * self._newtons))
        names = product(TABLE.items(), PERCENTILES)
        return {f"{key}_{share}": float(np.percentile(every[name], share)) for (key, name), share in names}


def designed(design: LearnedDesign, bits: Bits, weights: Weights) -> LearnedDesign:
    """A core of those ``bits``: of two layers' coefficients, and of their operands."""
    first, second, by_first, by_second = bits
    signals = {
        "coefficient.first": first,
        "coefficient.second": second,
        "operand.first": by_first,
        "operand.second": by_second,
        "operand.read": by_second,
    }
    formats = replace(design.formats, name="custom", coefficient=READ, signals=tuple(signals.items()))
    return replace(design, formats=formats, weights=weights)


def price(design: LearnedDesign) -> float:
    """Sum over all products of the bits of both factors' product, in thousands."""
    stack = {name: stack for stack, names in operators.OPERATORS.items() for name in names}
    parts = zip(NAMES, fold(design, design.weights), strict=True)
    bits = design.formats.bits
    return sum(part.size * bits(f"coefficient.{name}") * bits(f"operand.{stack[name]}") for name, part in parts) / 1000


@cache
def _loads(sensor: SensorArray, chunks: int, seed: tuple[int, ...]) -> Pool:
    """The same loads for all trainings."""
    return Pool.simulate(sensor, chunks, seed, lambda pieces: None)


def trained(design: LearnedDesign, bits: Bits, steps: int) -> Weights:
    """The weights of ``design``, trained on for a core of those ``bits``."""
    rounding = Rounding(designed(design, bits, design.weights))

    def simulate(sensor: SensorArray, chunks: int, seed: tuple[int, ...], advance: Callable[[int], None]) -> Pool:
        return _loads(sensor, chunks, seed)

    trainer = Trainer(design.sensor, design.weights.counts, 1, lambda pieces: None, simulate, rounding=rounding)
    state = trainer.first()
    trainer.run(steps, state, lambda state: None)
    return trainer.shape.weights(state.best)


def front(points: Iterable[dict[str, Any]]) -> list[dict[str, Any]]:
    """Points with a smaller error than all cheaper ones."""
    kept: list[dict[str, Any]] = []
    for point in sorted(points, key=lambda point: (point["price"], point["force_percent_95"])):
        if all(point["force_percent_95"] < other["force_percent_95"] for other in kept):
            kept.append(point)
    return kept


def record(steps: int) -> dict[str, Any]:
    """All that is measured, in plain JSON types."""
    design = load(ROOT / CONFIG).design
    assert isinstance(design, LearnedDesign)
    bench, weights = Bench(design), design.weights
    with patch.object(operators, "LONG", 0):
        units = [bench.point(bits, weights) for bits in ROUNDED]
    return {
        "contacts": CONTACTS,
        "seed": SEED,
        "steps": steps,
        "standard": price(design),
        "float": bench.floating(),
        "points": {
            "range": units,
            "words": [bench.point(bits, weights) for bits in ROUNDED],
            "trained": [bench.point(bits, trained(design, bits, steps)) for bits in TRAINED],
        },
    }


def table(found: dict[str, Any]) -> str:
    """Markdown: the cheapest core of each series with the errors of double precision, and each training."""
    exact, points = found["float"], found["points"]
    lines = [
        "| core | coefficients | operands | thousand products × bits | \\|ΔF\\|/\\|F\\|, % | μ error | φ error, ° |",
        "|---|---|---|---:|---|---|---|",
        _row("double precision", exact),
    ]
    limit = {key: (1 + SAME / 100) * exact[key] for key in FORCE}
    lines += [
        _row(f"within {SAME:g} %: {SERIES[name]}", point) for name in SERIES for point in _best(points[name], limit)
    ]
    for point in points["trained"]:
        same = next(each for each in points["words"] if each["bits"] == point["bits"])
        lines += [_row("**trained**", point), _row("the same words, not trained", same)]
        untrained = [(SERIES[name], other) for name in ("words", "range") for other in _best(points[name], point)]
        lines += [_row(f"as accurate: {title}", other) for title, other in untrained]
    return "\n".join(lines)


def _best(points: list[dict[str, Any]], limit: dict[str, Any]) -> list[dict[str, Any]]:
    """The cheapest of ``points`` whose errors of the force are within the ``limit`` of both, if there is one."""
    good = [point for point in points if all(point[key] <= limit[key] for key in FORCE)]
    return sorted(good, key=lambda point: point["price"])[:1]


def _row(title: str, point: dict[str, Any]) -> str:
    force, mu, phi = (
        " / ".join(f"{point[f'{key}_{share}']:.{digits}f}" for share in PERCENTILES)
        for key, digits in (("force_percent", 2), ("mu", 3), ("phi_deg", 1))
    )
    words = "| | |"
    if "bits" in point:
        first, second, by_first, by_second = point["bits"]
        words = f"| {first}, {second} | {by_first}, {by_second} | {point['price']:.0f}"
    return f"| {title} {words} | {force} | {mu} | {phi} |"


def plot(found: dict[str, Any]) -> None:
    """Write ``bench/results/rounded.svg``: the fronts of all series."""
    mpl.rcParams.update({"font.size": 10, "axes.grid": True, "grid.alpha": 0.3, "svg.hashsalt": "tfra"})
    figure = Figure(figsize=(7.5, 4.5), layout="constrained")
    axes = figure.subplots()
    for (name, title), colour in zip(SERIES.items(), ("#CC79A7", "#0072B2", "#D55E00"), strict=True):
        points = front(found["points"][name])
        axes.plot(
            [p["price"] for p in points], [p["force_percent_95"] for p in points], "o-", color=colour, label=title
        )
    axes.axhline(found["float"]["force_percent_95"], color="k", ls="--", lw=1, label="double precision")
    axes.set(xlabel="thousand products × bits of both factors", ylabel="|ΔF|/|F|, 95th percentile, %", ylim=(7, 20))
    axes.legend()
    figure.savefig(ROOT / "bench" / "results" / "rounded.svg", metadata={"Date": None})


def main() -> None:
    """Measure and write everything."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--steps", type=int, default=STEPS, help="of each training")
    found = record(parser.parse_args().steps)
    plot(found)
    publish("rounded", found, table(found), "docs/training.md")


if __name__ == "__main__":
    main()
