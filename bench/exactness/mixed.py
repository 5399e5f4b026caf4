"""Cores with random word lengths of their signals: generated Verilog against the model.

``python -m bench.exactness.mixed [--cores N] [--frames N]`` verifies them in Verilator, without stalls and with random
and bursty ones, every third with loaded coefficients.  It writes ``bench/results/mixed.json`` and the table in
docs/numerics.md, and exits with 1 if a bit differs.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from bench.cycles.streamed import mixed_design
from bench.publish import insert, store
from tfra.hdl.parallel.matvec.images import tail
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.fixed.tfra.operators import OPERATORS
from tfra.sim.verify import verify

PAGE = "docs/numerics.md"
HEAD = [
    "| array | MAC lanes | coefficients, bits | operands | scalars | tail | frames | words compared | that differ |",
    "|---|---:|---:|---:|---:|---:|---:|---:|---:|",
]


def design(seed: int) -> TfraDesign:
    """A core of this seed."""
    images = "load" if seed % 3 == 0 else "inline"
    return replace(mixed_design(seed), name=f"mixed_{seed}", images=images)


def lengths(subject: TfraDesign) -> dict[str, list[int]]:
    """Word lengths by kind of signal."""
    bits = subject.formats.bits
    return {
        "coefficients": [bits(f"coefficient.{name}") for names in OPERATORS.values() for name in names],
        "operands": [bits(f"operand.{name}") for name in (*OPERATORS, "combine")],
        "scalars": [bits(name) for name in ("scalar", "direction", "sums", "cordic", "division")],
    }


def row(subject: TfraDesign, facts: Mapping[str, Any]) -> str:
    """A line of the table."""
    found, sensor = lengths(subject), subject.sensor
    spans = " | ".join(f"{min(each)} to {max(each)}" for each in found.values())
    return (
        f"| {sensor.rows}×{sensor.columns} | {subject.architecture.mac_lanes} | {spans} | {tail(subject).bits} "
        f"| {facts['frames']} | {facts['compared']:,} | {facts['mismatches']} |"
    )


def main() -> int:
    """Verify and publish."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cores", type=int, default=12)
    parser.add_argument("--frames", type=int, default=150, help="random ones, beside contacts and corners")
    options = parser.parse_args()
    rows, record, passed = [], [], True
    for seed in range(options.cores):
        subject = design(seed)
        report = verify(subject, None, "verilator", seed, options.frames)
        facts = {"frames": report.frames, "compared": report.compared, "mismatches": report.mismatches}
        passed &= report.passed
        rows.append(row(subject, facts))
        record.append({"seed": seed, "passed": report.passed, **lengths(subject), **facts})
        print(rows[-1], "" if report.passed else f"FAILED {report.first}", flush=True)
    store("mixed", {"passed": passed, "cores": record})
    insert("mixed", "\n".join([*HEAD, *rows]), PAGE)
    return 0 if passed else 1


if __name__ == "__main__":
    sys.exit(main())
