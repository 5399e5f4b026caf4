"""Line 9: proven bounds on the errors of fixed point, against the errors of frames, some of which look for the worst."""

from collections import defaultdict
from collections.abc import Iterator
from statistics import median
from typing import Any

import numpy as np

from bench.parts.axi_cost import PRESETS
from bench.publish import ROOT
from bench.scorecard.line import Line, Measured, progress
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

MOST = 8.0
"""What the largest bound may be, over the largest error."""

MORE, ROUNDS, CHILDREN = 100, 40, 8
"""Further contacts, and as many frames of noise; steps of the search, and changed frames of each worst one a step."""
QUICK_COUNT, QUICK_ROUNDS = 4, 10

Key = tuple[str, str]
"""A part of an estimator and a signal."""


def configurations(quick: bool) -> Iterator[tuple[str, Configuration]]:
    """Those that line 1 draws, and the presets; of presets that compute the same words, the first."""
    for configuration in drawn(QUICK_COUNT if quick else COUNT, SEED):
        yield configuration.name, configuration
    kinds: dict[Any, list[str]] = defaultdict(list)
    designs: dict[Any, Design] = {}
    for name in () if quick else PRESETS:
        design = load(ROOT / "examples" / f"{name}.toml").design
        kind = design.sensor, design.adc, design.search, design.formats, design.result_fields, *design.float_settings
        designs.setdefault(str(kind), design)
        kinds[str(kind)].append(name)
    for kind, design in designs.items():
        yield ", ".join(kinds[kind]), Configuration(kinds[kind][0], design)


class Search:
    """The frame with the largest error of every signal so far."""

    def __init__(self, bounds: ErrorBounds[Any]) -> None:
        self._bounds = bounds
        self.best: dict[Key, tuple[float, Ints]] = {}

    def look(self, codes: Ints) -> None:
        """Keep those of ``codes (n, m)`` with larger errors than before."""
        for trace in self._bounds.traces(codes):
            errors, _ = self._bounds.errors(trace)
            for part, signal in errors_of(errors) if len(trace.codes) else ():
                largest = errors[part][signal].max(axis=1)
                frame = int(largest.argmax())
                if largest[frame] > self.best.get((part, signal), (-1.0,))[0]:
                    self.best[part, signal] = float(largest[frame]), trace.codes[frame]

    def climb(self, rounds: int, rng: np.random.Generator) -> Ints:
        """The worst frames ``(signals, m)`` after ``rounds`` of changes."""
        for _ in range(rounds):
            frames = np.array([frame for _, frame in self.best.values()])
            self.look(changed(self._bounds.design, np.repeat(frames, CHILDREN, axis=0), rng))
        return np.array([frame for _, frame in self.best.values()])


def errors_of(signals: dict[str, dict[str, Floats]]) -> Iterator[Key]:
    """Every part and signal."""
    return ((part, signal) for part, values in signals.items() for signal in values)


def changed(design: Design, codes: Ints, rng: np.random.Generator) -> Ints:
    """``codes (n, m)`` with one to three changes: a taxel at any code, or four mirror taxels at full scale, by a parity.

    Rows of operators work on one parity, so the signs of these are those of a row's terms.  Half of the frames also
    have other low bits, which are rounded.
    """
    top, quads = 1 << (design.adc.bits - 1), taxel_index(design)
    for frame in codes:
        for _ in range(rng.integers(1, 4)):
            if rng.integers(2):
                frame[rng.integers(len(frame))] = rng.choice([-top, 0, top - 1, rng.integers(-top, top)])
            else:
                frame[quads[rng.integers(len(quads))]] = HADAMARD[rng.integers(4)] * rng.choice([-top, top])
        frame += rng.integers(2) * rng.integers(-4, 5, len(frame))
    return np.clip(codes, -top, top - 1)


def judged(configuration: Configuration, rounds: int) -> dict[str, Any]:
    """The record of a configuration: errors that exceed their bound, and by signal the largest of both."""
    design = configuration.design
    bounds, rng = error_bounds(design), np.random.default_rng(SEED)
    codes = np.concatenate([
        directed(configuration), contact_codes(design, MORE, rng), wild_codes(design, MORE, rng),
    ]).reshape(-1, design.sensor.taxels)  # fmt: skip
    search = Search(bounds)
    search.look(codes)
    codes = np.concatenate([codes, search.climb(rounds, rng)])
    exceeded, compared, frames, unbounded = 0, 0, 0, 0
    largest: dict[Key, list[float]] = defaultdict(lambda: [0.0, 0.0])
    for start in range(0, len(codes), CHUNK):
        for trace in bounds.traces(codes[start : start + CHUNK]):
            limits, (errors, exact) = bounds.bounds(trace), bounds.errors(trace)
            frames += len(trace.codes)
            endless = np.zeros(len(trace.codes), dtype=np.bool_)
            for part, signal in errors_of(errors):
                limit, error = limits[part][signal], errors[part][signal]
                known = np.isfinite(limit).all(axis=1)
                endless |= ~known
                exceeded += violations(limit[known], error[known], exact[part][signal][known])
                compared += error[known].size
                pair = limit[known].max(initial=0.0), error[known].max(initial=0.0)
                largest[part, signal] = [max(both) for both in zip(largest[part, signal], pair, strict=True)]
            unbounded += int(endless.sum())
    ratios = {f"{part}: {signal}": round(limit / error, 2) for (part, signal), (limit, error) in largest.items()}
    return {
        "estimator": design.estimator,
        "array": f"{design.sensor.rows}×{design.sensor.columns}",
        "formats": str(design.formats),
        "frames": frames,
        "unbounded_frames": unbounded,
        "errors": compared,
        "exceeded": exceeded,
        "bound_over_error": ratios,
        "largest_bound": {f"{part}: {signal}": float(f"{limit:.4g}") for (part, signal), (limit, _) in largest.items()},
    }


CHUNK = 64
"""Frames at once: a form of a large array has a matrix for every frame."""


def measure(quick: bool) -> Measured:
    """All configurations, or some of them with a shorter search."""
    records = {}
    for name, configuration in configurations(quick):
        record = records[name] = judged(configuration, QUICK_ROUNDS if quick else ROUNDS)
        worst = max(record["bound_over_error"].items(), key=lambda item: item[1])
        progress(f"{name}: {record['frames']} frames, {record['exceeded']} exceed, at most {worst[1]} ({worst[0]})")
    ratios = [(ratio, f"{signal}, {name}") for name, r in records.items() for signal, ratio in r["bound_over_error"].items()]
    total = {key: sum(record[key] for record in records.values()) for key in ("frames", "unbounded_frames", "errors", "exceeded")}
    worst, where = max(ratios)
    parts = defaultdict(list)
    for ratio, where_ in ratios:
        parts[where_.split(":")[0]].append(ratio)
    by_part = {part: {"median": median(values), "worst": max(values)} for part, values in parts.items()}
    figure = (
        f"{total['exceeded']} of {total['errors']:,} errors of {len(records)} designs exceed their bound; the largest bound over the"
        f" largest error is {median(ratio for ratio, _ in ratios):.1f} (median), {worst:.1f} at most ({where});"
        f" {total['unbounded_frames']} of {total['frames']:,} frames have no bound"
    )
    passed = total["exceeded"] == 0 and worst <= MOST and total["errors"] > 0
    return Measured(figure, passed, {"seed": SEED, **total, "bound_over_error": by_part, "designs": records})
