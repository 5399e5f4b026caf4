"""What offsets and dead taxels cost, without the front end and with it.

``python -m bench.accuracy.front_end`` writes ``bench/results/front_end.json`` and the tables of docs/front_end.md.
Sensors with a tilted offset, a plane over the array from -0.5 % to +0.5 % of full scale, and with 5 % dead taxels,
which read zero; each sensor has a direction of the plane and dead taxels of its own.  A tare of frames at rest, each
with noise, gives the offsets; the dead taxels are known.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from bench.accuracy.cases import SEED
from bench.accuracy.loads import Cover, peak
from bench.accuracy.measure import MEASURES, PERCENTILES, Values, compared
from bench.accuracy.scenes import LEVELS, scaled
from bench.accuracy.tables import DIGITS, SYMBOLS, UNITS, both, markdown
from bench.publish import ROOT, insert, store
from tfra.codegen.config.read import load
from tfra.model.arrays import Bools, Floats, Ints
from tfra.model.converter import convert
from tfra.model.cover.scenes import any_contacts
from tfra.model.fixed.design import Design
from tfra.model.fixed.front_end import FrontEnd, Settings, Tables
from tfra.model.fixed.repair import table, thin_plate
from tfra.model.fixed.words import decode
from tfra.train.errors import Resultants

PAGE = "docs/front_end.md"
DESIGNS = {"TFRA": "fast", "learned": "learned_fast"}
"""By estimator: a preset in `examples/`; both have the same sensor and converter."""
COUNT = 1000
"""Contacts."""
SENSORS = 40
"""Sensors that they are shared between."""
TILT = 5e-3
"""Largest offset, of full scale."""
DEAD = 0.05
"""Share of the taxels."""
LOG2_TARE = 4
NOISE = 1e-3
"""Standard deviation, of a frame's peak; at rest, of full scale."""
FITTED = 3000
"""Contacts that weights are fitted on."""
LIMIT = 10.0
"""Per cent that the faults may cost with the front end."""

Weights = Callable[[Bools], Floats]
"""Function of the dead taxels ``(rows, columns)``: weights ``(dead taxels, taxels)``."""


def nearest(dead: Bools, count: int) -> list[Ints]:
    """Of each dead taxel, the ``count`` nearest others that live."""
    row, column = np.indices(dead.shape).reshape(2, -1)
    live = np.flatnonzero(~dead)
    far = [(row[live] - row[t]) ** 2 + (column[live] - column[t]) ** 2 for t in np.flatnonzero(dead)]
    return [live[np.argsort(each, kind="stable")[:count]] for each in far]


def neighbours(dead: Bools) -> Floats:
    """The mean of the four nearest taxels."""
    return _weights(dead, nearest(dead, 4), lambda taxel, near: np.full(len(near), 1 / len(near)))


def fitted(stress: Floats) -> Weights:
    """Least squares from the twelve nearest taxels, on frames ``stress (n, rows, columns)``."""
    flat = stress.reshape(len(stress), -1)
    moment = flat.T @ flat / len(flat) + NOISE**2 * np.eye(flat.shape[1])

    def weights(dead: Bools) -> Floats:
        def solved(taxel: int, near: Ints) -> Floats:
            return np.asarray(np.linalg.solve(moment[np.ix_(near, near)], moment[near, taxel]))

        return _weights(dead, nearest(dead, 12), solved)

    return weights


def _weights(dead: Bools, near: list[Ints], solve: Callable[[int, Ints], Floats]) -> Floats:
    weights = np.zeros((len(near), dead.size))
    for row, taxel, sources in zip(weights, np.flatnonzero(dead), near, strict=True):
        row[sources] = solve(int(taxel), sources)
    return weights


def plane(rng: np.random.Generator, shape: tuple[int, int]) -> Floats:
    """A tilted plane ``(rows, columns)`` from -1 to 1, in any direction."""
    angle = rng.uniform(0, 2 * np.pi)
    y, x = (np.linspace(-1, 1, count) for count in shape)
    tilted = np.cos(angle) * x + np.sin(angle) * y[:, None]
    return np.asarray(tilted / np.abs(tilted).max())


def sensors(design: Design, count: int, rng: np.random.Generator) -> list[dict[str, Any]]:
    """``SENSORS`` sensors: frames in Pa with noise and their true forces, frames at rest, offsets, dead taxels."""
    sensor, full = design.sensor, design.adc.full_scale
    contacts = any_contacts(sensor, count, rng)
    exact = scaled(Cover()(sensor, contacts, rng), rng.uniform(*LEVELS, count) * full)
    noisy = exact.stress + NOISE * peak(exact.stress) * rng.standard_normal(exact.stress.shape)
    shape = (sensor.rows, sensor.columns)
    made = []
    for few in np.array_split(np.arange(count), SENSORS):
        dead = np.zeros(sensor.taxels, dtype=bool)
        dead[rng.choice(sensor.taxels, round(DEAD * sensor.taxels), replace=False)] = True
        rest = NOISE * full * rng.standard_normal((1 << LOG2_TARE, *shape))
        offset = TILT * full * plane(rng, shape)
        one = {"stress": noisy[few], "force": exact.force[few], "rest": rest}
        made.append(one | {"offset": offset, "dead": dead.reshape(shape)})
    return made


def observe(design: Design, one: Mapping[str, Any], weights: Mapping[str, Weights]) -> dict[str, Ints]:
    """By scene: codes of one sensor."""
    dead, still = one["dead"], np.zeros_like(one["dead"])
    seen = {"no faults": convert(design, one["stress"])}
    seen["offsets, no front end"] = _raw(design, one["stress"] + one["offset"], still)
    seen["dead taxels, no front end"] = _raw(design, one["stress"], dead)
    seen["both, no front end"] = _raw(design, one["stress"] + one["offset"], dead)
    seen["offsets, front end"] = calibrated(design, one, still, thin_plate)
    for name, solve in weights.items():
        seen[f"dead taxels, {name}"] = calibrated(design, one | {"offset": 0.0}, dead, solve)
    for name, solve in weights.items():
        seen[f"both, {name}"] = calibrated(design, one, dead, solve)
    return seen


def _raw(design: Design, stress: Floats, dead: Bools) -> Ints:
    return np.where(dead, 0, convert(design, stress))


def calibrated(design: Design, one: Mapping[str, Any], dead: Bools, weights: Weights) -> Ints:
    """Codes from the front end, after a tare of the frames at rest."""
    power_up = Tables.of(design.sensor.taxels)
    tables = replace(power_up, gains=np.where(dead.ravel(), 0, power_up.gains), repairs=table(dead, weights(dead)))
    unit = FrontEnd(design, Settings(design.adc.bits, log2_tare=LOG2_TARE), tables)
    unit.tare()
    unit(_raw(design, one["rest"] + one["offset"], dead) & 0xFFFF)
    return unit(_raw(design, one["stress"] + one["offset"], dead) & 0xFFFF).codes


def measure(count: int) -> dict[str, Any]:
    """By estimator, scene and measure: ``PERCENTILES`` and the cost of the faults."""
    record: dict[str, Any] = {"seed": SEED, "contacts": count, "sensors": SENSORS}
    for who, preset in DESIGNS.items():
        design = load(ROOT / "examples" / f"{preset}.toml").design
        rng = np.random.default_rng([SEED, 1])
        other = any_contacts(design.sensor, FITTED, rng)
        stress = Cover()(design.sensor, other, rng).stress
        weights = {"four neighbours": neighbours, "thin plate": thin_plate, "fitted": fitted(stress / peak(stress))}
        every = sensors(design, count, rng)
        seen = [observe(design, one, weights) for one in every]
        truth = Resultants(np.concatenate([one["force"] for one in every]))
        codes = {scene: np.concatenate([one[scene] for one in seen]) for scene in seen[0]}
        found = {scene: compared(truth, decode(design, design.model.words(each))) for scene, each in codes.items()}
        record[who] = {scene: summary(values, found["no faults"]) for scene, values in found.items()}
        print(who, flush=True)
    return record


WHOLE = {"mu": 1.0, "phi_deg": 180.0, "force_percent": 100.0}
"""An error that leaves no accuracy."""


def summary(values: Values, clean: Values) -> dict[str, Any]:
    """Percentiles; growth of the median in per cent of itself; what the accuracy, 1 - error, loses in per cent."""
    found = {}
    for key in MEASURES:
        median, before = float(np.median(values[key])), float(np.median(clean[key]))
        found[key] = {
            "percentiles": np.percentile(values[key], PERCENTILES).round(5).tolist(),
            "growth": round(100 * (median / before - 1), 1),
            "loss": round(100 * (median - before) / (WHOLE[key] - before), 2),
        }
    return found


def errors(record: Mapping[str, Any]) -> str:
    """Rows: estimators and scenes; columns: median and 95th percentile of the errors."""
    heads = ["estimator", "sensor", *(f"{SYMBOLS[key]}{UNITS[key] and f', {UNITS[key].strip()}'}" for key in SYMBOLS)]
    rows = [
        [who, scene, *(both(one[key]["percentiles"], DIGITS[key]) for key in SYMBOLS)]
        for who in DESIGNS
        for scene, one in record[who].items()
    ]
    return markdown(heads, rows, words=2)


def costs(record: Mapping[str, Any]) -> str:
    """Rows: estimators and scenes with the front end; columns: growth of the median error, loss of accuracy."""
    heads = ["estimator", "sensor", *(f"{SYMBOLS[key]}: error, accuracy" for key in SYMBOLS)]
    rows = [
        [who, scene, *(cost(one[key]) for key in SYMBOLS)]
        for who in DESIGNS
        for scene, one in record[who].items()
        if scene != "no faults"
    ]
    return markdown(heads, rows, words=2)


def cost(one: Mapping[str, float]) -> str:
    """Growth of the error and change of the accuracy, each with a tick if it costs less than the limit."""
    parts = ((one["growth"], f"{one['growth']:+.0f} %"), (one["loss"], f"{-one['loss']:+.1f} %"))
    return ", ".join(text + (" ✓" if value < LIMIT else "") for value, text in parts)


def main() -> None:
    """Measure, store, publish."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--contacts", type=int, default=COUNT)
    record = measure(parser.parse_args().contacts)
    store("front_end", record)
    insert("front_end errors", errors(record), PAGE)
    insert("front_end costs", costs(record), PAGE)


if __name__ == "__main__":
    main()
