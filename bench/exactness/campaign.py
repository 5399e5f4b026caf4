"""The verification campaign: generated Verilog against the model over many designs, in both simulators.

``python -m bench.exactness.campaign [--scale S]`` verifies every design below in Icarus and in Verilator, with
contacts, random and directed frames, a third of them each without stalls, with random and with bursty stalls on both
ports.  It prints what was compared, writes ``bench/results/campaign.json`` and the table in README.md, and exits with 1
if a bit differs.
"""

from __future__ import annotations

import argparse
import sys
import time
from typing import Any

from bench.publish import publish
from tfra.model.choices import FORMATS, Adc, Architecture, Search
from tfra.model.fixed.design import Design
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.sensor import SensorArray
from tfra.sim.verify import verify


def design(
    rows: int, columns: int, pitch: tuple[float, float], height: float, lanes: int, **more: Any
) -> Design:
    """Lengths in mm; ``lanes``: MAC lanes."""
    sensor = SensorArray(rows, columns, pitch[0] / 1e3, pitch[1] / 1e3, height / 1e3)
    name = f"c{rows}x{columns}_{lanes}_{pitch[0]}x{pitch[1]}".replace(".", "p")
    return TfraDesign(sensor, name, architecture=Architecture(lanes), **more)


DESIGNS = (
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
"""Designs, and the number of random frames of each, in addition to 60 contacts and the directed frames."""


def main() -> int:
    """Run, print, publish."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scale", type=float, default=1.0, help="share of the random frames, for a shorter run")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    rows, record, passed = [], [], True
    for one, count in DESIGNS:
        for simulator in ("icarus", "verilator"):
            start = time.perf_counter()
            report = verify(one, None, simulator, options.seed, int(count * options.scale))
            passed &= report.passed
            facts = report.as_dict()
            record.append({**facts, "seconds": time.perf_counter() - start})
            a, s = one.architecture, one.sensor
            rows.append(
                f"| {s.rows}×{s.columns} | `{one.formats.name}` | {a.mac_lanes} | {simulator} "
                f"| {report.frames} | {report.compared:,} | {report.mismatches} |"
            )
            print(f"{rows[-1]} {record[-1]['seconds']:.0f} s {'' if report.passed else 'FAILED'}", flush=True)
            if not report.passed:
                print(report.first, report.violations, report.timing, flush=True)
    frames = {name: sum(r["frames"] for r in record if r["simulator"] == name) for name in ("icarus", "verilator")}
    words = sum(r["compared"] for r in record)
    head = [
        "| array | formats | MAC lanes | simulator | frames | words compared | words that differ |",
        "|---|---|---:|---|---:|---:|---:|",
    ]
    total = " and ".join(f"{count:,} frames in {name}" for name, count in frames.items())
    table = "\n".join([f"{total}; {words:,} words compared, seed {options.seed}.", "", *head, *rows])
    publish("campaign", {"seed": options.seed, "passed": passed, "reports": record}, table)
    return 0 if passed else 1


if __name__ == "__main__":
    sys.exit(main())
