"""The verification campaign: generated Verilog against the model over many designs, in both simulators.

``python -m bench.exactness.campaign [--estimator learned] [--scale S]`` verifies every design of an estimator in Icarus
and in Verilator, with contacts, random and directed frames, a third of them each without stalls, with random and with
bursty stalls on both ports.  It prints what was compared, writes ``bench/results/campaign.json`` and the table in
docs/measured.md, or ``campaign_learned.json`` and the table in docs/learned.md, and exits with 1 if a bit differs.
"""

import argparse
import sys
import time
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from bench.publish import ROOT, publish
from tfra.codegen.config.read import load
from tfra.model.choices import FORMATS, SERIAL, Adc, Architecture, Search
from tfra.model.fixed.design import Design
from tfra.model.fixed.learned.design import LearnedDesign
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.learned.network import Weights
from tfra.model.sensor import SensorArray
from tfra.sim.verify import verify


def design(rows: int, columns: int, pitch: tuple[float, float], height: float, lanes: int, **more: Any) -> Design:
    """Lengths in mm; ``lanes``: MAC lanes."""
    sensor = SensorArray(rows, columns, pitch[0] / 1e3, pitch[1] / 1e3, height / 1e3)
    name = f"c{rows}x{columns}_{lanes}_{pitch[0]}x{pitch[1]}".replace(".", "p")
    return TfraDesign(sensor, name, architecture=Architecture(lanes), **more)


SIMULATORS = ("icarus", "verilator")

TFRA = (
    (design(10, 10, (4, 2), 3, 16), 120),
    (design(10, 10, (4, 4), 3, 64), 120),
    (design(10, 10, (4, 2), 3, 100, formats=FORMATS["wide"]), 60),
    (design(8, 8, (2, 2), 3, 4, search=Search(20)), 40),
    (design(5, 7, (3, 3), 2, 48), 400),
    (design(5, 7, (3, 3), 2, 4, search=Search(40, 1.5)), 200),
    (design(4, 6, (5, 3), 2, 12, adc=Adc(12)), 500),
    (design(4, 6, (5, 3), 2, 4, search=Search(10), adc=Adc(16)), 200),
    (design(16, 16, (1, 1), 1.5, 64), 20),
)
"""Designs of TFRA, and the number of random frames of each, in addition to 60 contacts and the directed frames."""


def learned() -> tuple[tuple[Design, int], ...]:
    """Designs of the learned estimator: the presets with their weights, and others with random ones."""
    fast, resultant, small = (
        load(ROOT / "examples" / f"learned_{name}.toml").design for name in ("fast", "resultant", "small")
    )
    return (
        (fast, 40),
        (resultant, 40),
        (small, 20),
        (untrained(7, 12, (24, 12), architecture=Architecture(28, 1), images="load"), 100),
        (untrained(5, 6, (6, 4), architecture=Architecture(12, 2), formats=FORMATS["wide"]), 900),
        (untrained(3, 5, (5, 7), architecture=SERIAL, adc=Adc(12)), 900),
    )


def untrained(rows: int, columns: int, counts: tuple[int, int], **choices: Any) -> LearnedDesign:
    """A design with random weights; the sum of the stress is in F_z, so that most frames press."""
    (c1, c2), rng, m = counts, np.random.default_rng(rows), rows * columns
    weights = Weights(*(rng.normal(size=shape) / m for shape in ((c1, m), (4, c2, c1), (4, c2), (4, c1), (4, m))))
    weights.direct[2] += 0.25
    sensor, name = SensorArray(rows, columns, 2.5e-3, 3e-3, 2.5e-3), f"learned_{rows}x{columns}"
    return LearnedDesign(sensor, name, weights=weights, threshold=0.25, **choices)


def core(of: Design) -> str:
    """The core in a few words."""
    if of.architecture.kind == "serial":
        return "serial"
    forces = "" if "forces" in of.result_fields else ", no forces at the taxels"
    words = of.architecture.vector_words
    return f"{of.architecture.mac_lanes} lanes, {words} word{'s' * (words > 1)} a cycle{forces}"


def row(of: Design, reports: Sequence[Mapping[str, Any]]) -> str:
    """Markdown of a design, from its reports by all simulators."""
    compared, differ = (sum(report[key] for report in reports) for key in ("compared", "mismatches"))
    sensor = f"{of.sensor.rows}×{of.sensor.columns}"
    return f"| {sensor} | `{of.formats.name}` | {core(of)} | {reports[0]['frames']} | {compared:,} | {differ} |"


def main() -> int:
    """Run, print, publish."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scale", type=float, default=1.0, help="share of the random frames, for a shorter run")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--estimator", choices=("tfra", "learned"), default="tfra")
    options = parser.parse_args()
    rows, record, passed = [], [], True
    for one, count in learned() if options.estimator == "learned" else TFRA:
        both = []
        for simulator in SIMULATORS:
            start = time.perf_counter()
            report = verify(one, None, simulator, options.seed, int(count * options.scale))
            passed &= report.passed
            both.append({**report.as_dict(), "seconds": time.perf_counter() - start})
            if not report.passed:
                print(report.first, report.violations, report.timing, flush=True)
        record += both
        rows.append(row(one, both))
        print(rows[-1], flush=True)
    head = [
        "| array | formats | core | frames in each simulator | words compared | words that differ |",
        "|---|---|---|---:|---:|---:|",
    ]
    total = f"{sum(report['compared'] for report in record):,} words compared in {' and '.join(SIMULATORS)}"
    table = "\n".join([f"{total}, seed {options.seed}.", "", *head, *rows])
    other = options.estimator == "learned"
    name, page = ("campaign_learned", "docs/learned.md") if other else ("campaign", "docs/measured.md")
    publish(name, {"seed": options.seed, "passed": passed, "reports": record}, table, page)
    return 0 if passed else 1


if __name__ == "__main__":
    sys.exit(main())
