"""Line 9: proven bounds on the errors of fixed point, against errors that were observed, and searched for."""

from collections import defaultdict
from collections.abc import Iterator
from statistics import median
from typing import Any

import numpy as np

from bench.parts.axi_cost import PRESETS
from bench.publish import ROOT
from bench.scorecard.line import GATEWARE, Line, Measured, progress
from bench.scorecard.words.drawn import drawn
from bench.scorecard.words.harness import Configuration
from bench.scorecard.words.measure import COUNT, SEED, directed
from tfra.codegen.config.read import load
from tfra.model.arrays import Floats, Ints
from tfra.model.cover.scenes import contact_codes, wild_codes
from tfra.model.fixed.butterfly import HADAMARD, taxel_index
from tfra.model.fixed.design import Design
from tfra.study.bounds.bounds import ErrorBounds, violations
from tfra.study.bounds.estimators import error_bounds
from tfra.study.signals.instrument import only

MOST = 8.0
"""What the largest bound may be, over the largest error."""

MORE, ROUNDS, CHILDREN = 100, 40, 6
"""Further contacts, and as many frames of noise; steps of the search, and changes of each worst frame a step."""
QUICK_COUNT, QUICK_MORE, QUICK_ROUNDS = 4, 20, 30

CHUNK = 64
"""Frames at once: forms have matrices for every frame."""

FEW = 3
"""Frames of a signal whose bounds a step of the search asks for."""

Key = tuple[str, str]
"""A part of an estimator and a signal."""


def configurations(quick: bool) -> Iterator[Configuration]:
    """Those that line 1 draws, and the presets, a single one of those that compute the same words."""
    yield from drawn(QUICK_COUNT if quick else COUNT, SEED)
    kinds: dict[str, tuple[Design, list[str]]] = {}
    for name in () if quick else PRESETS:
        design = load(ROOT / "examples" / f"{name}.toml").design
        kind = design.sensor, design.adc, design.search, design.formats, design.result_fields, design.float_settings
        kinds.setdefault(str(kind), (design, []))[1].append(name)
    for design, names in kinds.values():
        yield Configuration(" = ".join(names), design)


class Search:
    """The frames with the largest error, and with the largest bound, of every signal so far; all have a bound of it."""

    def __init__(self, bounds: ErrorBounds[Any]) -> None:
        self._bounds = bounds
        self._best: dict[Key, tuple[float, Ints]] = {}
        self._widest: dict[Key, tuple[float, Ints]] = {}

    def look(self, codes: Ints) -> None:
        """Keep those of ``codes (n, m)`` with larger errors than before."""
        for trace in self._bounds.traces(codes):
            errors = {key: error.max(axis=1) for key, (error, _) in self._bounds.errors(trace).items()}
            better = {key: self._better(key, error) for key, error in errors.items()}
            frames = np.unique(np.concatenate([*better.values()])) if self._best else np.arange(len(trace.codes))
            limits = (
                self._bounds.bounds(only(trace, np.isin(np.arange(len(trace.codes)), frames))) if len(frames) else {}
            )
            for key, limit in limits.items():
                known = frames[np.isfinite(limit).all(axis=1)]
                best = next((frame for frame in better[key] if frame in known), None)
                if best is not None:
                    self._best[key] = float(errors[key][best]), trace.codes[best]
                widths = np.where(np.isfinite(limit), limit, 0.0).max(axis=1)
                if widths.max() > self._widest.get(key, (0.0,))[0]:
                    self._widest[key] = float(widths.max()), trace.codes[frames[widths.argmax()]]

    def _better(self, key: Key, error: Floats) -> Ints:
        """A few frames with a larger ``error (n,)`` than the best, the largest first."""
        order = np.argsort(-error)[:FEW]
        return order[error[order] > self._best.get(key, (-1.0,))[0]]

    @property
    def frames(self) -> Ints:
        """The frames ``(2 signals, m)``."""
        return np.array([frame for found in (self._best, self._widest) for _, frame in found.values()])


def changed(design: Design, codes: Ints, rng: np.random.Generator) -> Ints:
    """``codes (n, m)`` with one to three changes each: a taxel at any code, or mirror taxels at full scale.

    The signs of the latter are those of a parity, on which a row of an operator works.  Half of the frames also get
    other low bits, which are rounded.
    """
    top, quads = 1 << (design.adc.bits - 1), taxel_index(design)
    for frame in codes:
        for _ in range(rng.integers(1, 4)):
            if rng.integers(2):
                frame[rng.integers(len(frame))] = (-top, 0, top - 1, rng.integers(-top, top))[rng.integers(4)]
            else:
                frame[quads[rng.integers(len(quads))]] = HADAMARD[rng.integers(4)] * rng.choice([-top, top])
        frame += rng.integers(2) * rng.integers(-4, 5, len(frame))
    return np.clip(codes, -top, top - 1)


def judged(configuration: Configuration, more: int, rounds: int) -> dict[str, Any]:
    """The record of a configuration: errors that exceed their bound, and by signal the largest bound over the largest
    error, with ``more`` frames than line 1 sends first, and those of a search of so many ``rounds``."""
    design = configuration.design
    bounds, rng = error_bounds(design), np.random.default_rng(SEED)
    scenes = directed(configuration), contact_codes(design, more, rng), wild_codes(design, more, rng)
    codes = np.concatenate(scenes).reshape(-1, design.sensor.taxels)
    search = Search(bounds)
    for start in range(0, len(codes), CHUNK):
        search.look(codes[start : start + CHUNK])
    for _ in range(rounds):
        search.look(changed(design, np.repeat(search.frames, CHILDREN, axis=0), rng))
    record, largest = compared(bounds, np.concatenate([codes, search.frames]))
    return {
        "array": f"{design.sensor.rows}×{design.sensor.columns}",
        "estimator": design.estimator,
        "formats": str(design.formats),
        **record,
        "largest_bound": {": ".join(key): float(f"{bound:.4g}") for key, (bound, _) in largest.items()},
        "without_any_bound": [": ".join(key) for key, (most, _) in largest.items() if not most],
        "over_largest_error": {
            ": ".join(key): round(float(most / error), 2) for key, (most, error) in largest.items() if error > 0
        },
    }


def compared(bounds: ErrorBounds[Any], codes: Ints) -> tuple[dict[str, int], dict[Key, tuple[float, float]]]:
    """Counts, and the largest bound and the largest error of every signal, of frames that have a bound of it.

    Counted are ``frames``, those ``without_bound`` of a signal, ``errors``, and those ``exceeding`` their bound.
    """
    record: dict[str, int] = defaultdict(int)
    largest: dict[Key, tuple[float, float]] = defaultdict(lambda: (0.0, 0.0))
    for start in range(0, len(codes), CHUNK):
        for trace in bounds.traces(codes[start : start + CHUNK]):
            limits, endless = bounds.bounds(trace), np.zeros(len(trace.codes), dtype=np.bool_)
            for key, (error, exact) in bounds.errors(trace).items():
                known = np.isfinite(limits[key]).all(axis=1)
                endless |= ~known
                limit, error = limits[key][known], error[known]
                record["errors"] += error.size
                record["exceeding"] += violations(limit, error, exact[known])
                bound, worst = largest[key]
                largest[key] = max(bound, limit.max(initial=0.0)), max(worst, error.max(initial=0.0))
            record["frames"] += len(trace.codes)
            record["without_bound"] += int(endless.sum())
    return dict(record), largest


def measure(quick: bool) -> Measured:
    """All configurations, or some of them with fewer frames."""
    records = {}
    for configuration in configurations(quick):
        record = judged(configuration, *((QUICK_MORE, QUICK_ROUNDS) if quick else (MORE, ROUNDS)))
        records[configuration.name] = record
        worst, where = max((ratio, signal) for signal, ratio in record["over_largest_error"].items())
        progress(f"{configuration.name}: {record['frames']} frames, {record['exceeding']} exceed, {worst} at {where}")
    total = {key: sum(r[key] for r in records.values()) for key in ("errors", "exceeding", "frames", "without_bound")}
    ratios = [(ratio, key, name) for name, r in records.items() for key, ratio in r["over_largest_error"].items()]
    worst, where, name = max(ratios)
    by_part: dict[str, list[float]] = defaultdict(list)
    for ratio, key, _ in ratios:
        by_part[key.partition(":")[0]].append(ratio)
    parts = {part: {"median": median(values), "worst": max(values)} for part, values in by_part.items()}
    figure = (
        f"{total['exceeding']} of {total['errors']:,} errors of {len(records)} designs exceed their bound;"
        f" the largest bound is {median(ratio for ratio, *_ in ratios):.1f} times the largest error (median),"
        f" at most {MOST:.0f} times in {sum(ratio <= MOST for ratio, *_ in ratios)} of {len(ratios)} signals,"
        f" {worst:.1f} times at most ({where}, {name});"
        f" {total['without_bound']:,} of {total['frames']:,} frames have none"
    )
    facts = {"seed": SEED, **total, "over_largest_error": parts, "designs": records}
    bounded = not any(record["without_any_bound"] for record in records.values())
    good = bounded and total["errors"] > 0 and total["exceeding"] == 0 and worst <= MOST
    return Measured(figure, bool(good), facts)


LINE = Line(
    9,
    "errors of fixed point by proof: phi, all before the decision, scaling, results",
    f"bounds proven, none exceeded, at most {MOST:.0f} times the largest error",
    "bounds are proven on paper (docs/numerics.md), and computed in float64 from the words of a frame, with the core's"
    " decisions: that float decides otherwise is no error here. The largest bound and the largest error of a signal are"
    " those of the frames that line 1 sends first, of others, and of a search for large errors. A frame in which a"
    " divisor may be off by half of itself has no bound of what comes after.",
    (*GATEWARE, "study/bounds", "study/signals", "bench/scorecard/bounds.py", "bench/scorecard/words"),
    measure,
)
