"""What offsets and dead taxels cost, without the front end and with it.

``python -m bench.accuracy.front_end`` writes ``bench/results/front_end.json`` and the table of docs/front_end.md.
Sensors with a tilted offset, a plane over the array from -0.5 % to +0.5 % of full scale, and with 5 % dead taxels,
which read zero; each sensor has a direction of the plane and dead taxels of its own.  A tare of frames at rest, each
with noise, gives the offsets; the dead taxels are known.
"""

import argparse
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from bench.accuracy.loads import Cover, peak
from bench.accuracy.measure import MEASURES, PERCENTILES, compared
from bench.accuracy.scenes import LEVELS, SEED, scaled
from bench.accuracy.tables import DIGITS, SYMBOLS, UNITS, markdown
from bench.publish import ROOT, publish
from tfra.codegen.config.read import load
from tfra.model.arrays import Bools, Floats, Ints
from tfra.model.converter import convert
from tfra.model.cover.scenes import any_contacts
from tfra.model.fixed.dead_taxels import repairs
from tfra.model.fixed.design import Design
from tfra.model.fixed.front_end import FrontEnd, Settings, Tables
from tfra.model.fixed.words import decode
from tfra.train.heldout import Resultants

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
    drawn = []
    for few in np.array_split(np.arange(count), SENSORS):
        dead = np.zeros(sensor.taxels, dtype=bool)
        dead[rng.choice(sensor.taxels, round(DEAD * sensor.taxels), replace=False)] = True
        rest = NOISE * full * rng.standard_normal((1 << LOG2_TARE, *shape))
        offset = TILT * full * plane(rng, shape)
        one = {"stress": noisy[few], "force": exact.force[few], "rest": rest}
        drawn.append(one | {"offset": offset, "dead": dead.reshape(shape)})
    return drawn


def observe(design: Design, one: Mapping[str, Any]) -> dict[str, Ints]:
    """By scene: codes of one sensor."""
    offsets, dead, still = one["offset"], one["dead"], np.zeros_like(one["dead"])
    faults = {"offsets": (offsets, still), "dead taxels": (0.0, dead), "both": (offsets, dead)}
    codes = {"no faults": convert(design, one["stress"])}
    for name, (offset, dead) in faults.items():
        codes[f"{name}, no front end"] = _raw(design, one["stress"] + offset, dead)
    for name, (offset, dead) in faults.items():
        codes[f"{name}, front end"] = calibrated(design, {**one, "offset": offset}, dead)
    return codes


def _raw(design: Design, stress: Floats, dead: Bools) -> Ints:
    return np.where(dead, 0, convert(design, stress))


def calibrated(design: Design, one: Mapping[str, Any], dead: Bools) -> Ints:
    """Codes from the front end, after a tare of the frames at rest."""
    power_up = Tables.of(design.sensor.taxels)
    gains = np.where(dead.ravel(), 0, power_up.gains)
    tables = replace(power_up, gains=gains, repairs=repairs(design.sensor, dead))
    unit = FrontEnd(design, Settings(design.adc.bits, log2_tare=LOG2_TARE), tables)
    unit.tare()
    unit(_raw(design, one["rest"] + one["offset"], dead) & 0xFFFF)
    return unit(_raw(design, one["stress"] + one["offset"], dead) & 0xFFFF).codes


def measure(count: int) -> dict[str, Any]:
    """By estimator, scene and measure: ``PERCENTILES``."""
    record: dict[str, Any] = {"seed": SEED, "contacts": count, "sensors": SENSORS}
    for who, preset in DESIGNS.items():
        design = load(ROOT / "examples" / f"{preset}.toml").design
        every = sensors(design, count, np.random.default_rng([SEED, 1]))
        seen = [observe(design, one) for one in every]
        truth = Resultants(np.concatenate([one["force"] for one in every]))
        record[who] = {}
        for scene in seen[0]:
            codes = np.concatenate([one[scene] for one in seen])
            found = compared(truth, decode(design, design.model(codes).words))
            record[who][scene] = {key: np.percentile(found[key], PERCENTILES).round(5).tolist() for key in MEASURES}
        print(who, flush=True)
    return record


def errors(record: Mapping[str, Any]) -> str:
    """Rows: scenes; columns: median and 95th percentile of the errors of each estimator."""
    names = [f"{SYMBOLS[key]}{UNITS[key] and f', {UNITS[key].strip()}'}" for key in SYMBOLS]
    heads = ["sensor", *(f"{who}: {name}" for who in DESIGNS for name in names)]
    scenes = record[next(iter(DESIGNS))]
    rows = (
        [scene, *(both(record[who][scene][key], DIGITS[key]) for who in DESIGNS for key in SYMBOLS)] for scene in scenes
    )
    return markdown(heads, rows)


def both(values: Sequence[float], digits: int) -> str:
    """Median and 95th percentile."""
    return " / ".join(f"{value:.{digits}f}" for value in values)


def main() -> None:
    """Measure, store, publish."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--contacts", type=int, default=COUNT)
    record = measure(parser.parse_args().contacts)
    publish("front_end", record, errors(record), PAGE)


if __name__ == "__main__":
    main()
