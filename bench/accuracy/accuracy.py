"""How accurate every estimator is on identical frames, for any friction, under noise, and on what none expects.

``python -m bench.accuracy.accuracy`` writes ``bench/results/accuracy.json``, the figure beside it and the tables of
docs/accuracy.md, and the shortest in README.md.
"""

import argparse
import hashlib
from collections.abc import Sequence
from typing import Any

from bench.accuracy import measure
from bench.accuracy.cases import SEED, Case, cases
from bench.accuracy.figure import plot
from bench.accuracy.tables import tables
from bench.publish import insert, store
from tfra.codegen.config.write import millimetres
from tfra.model.learned.network import NAMES, Network

PAGE = "docs/accuracy.md"
SHORT = "accuracy short"
"""The table that README.md has, too."""
COUNT = 1000
"""Contacts a sensor."""


def record(every: Sequence[Case], count: int) -> dict[str, Any]:
    """All that is measured, in plain JSON types."""
    observed = {case.name: measure.observe(case, count) for case in every}
    together = measure.pooled(observed.values())
    sensors = {
        case.name: {
            **described(case),
            "scenes": measure.percentiles(observed[case.name]),
            "fixed": measure.agreement(case, count),
            "paper": measure.paper(case) if case.name in measure.PAPER else None,
        }
        for case in every
    }
    pooled, curves = measure.percentiles(together), measure.curves(together)
    return {"seed": SEED, "contacts": count, "sensors": sensors, "pooled": pooled, "curves": curves}


def described(case: Case) -> dict[str, Any]:
    """What the page says of a sensor and its network."""
    sensor, weights = case.design.sensor, case.design.weights
    return {
        "taxels": [sensor.rows, sensor.columns],
        "pitch_mm": [millimetres(sensor.pitch_x), millimetres(sensor.pitch_y)],
        "thickness_mm": millimetres(sensor.thickness),
        "pitch_over_thickness": round(case.coarseness, 3),
        "units": list(weights.counts),
        "products": Network(sensor, weights).products,
        "weights_sha256": hashlib.sha256(b"".join(getattr(weights, name).tobytes() for name in NAMES)).hexdigest(),
    }


def main() -> None:
    """Measure and write everything."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--contacts", type=int, default=COUNT, help="random contacts of each sensor")
    found = record(cases(), parser.parse_args().contacts)
    store("accuracy", found)
    plot(found["curves"])
    for name, table in tables(found).items():
        insert(name, table, PAGE)
        if name == SHORT:
            insert(name, table)


if __name__ == "__main__":
    main()
