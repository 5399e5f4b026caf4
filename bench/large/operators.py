"""What to store: A-dagger, or (A A^T)^-1 and A; memory, products, words, exactness and time of either.

``python -m bench.large.operators [--contacts N]`` writes ``bench/results/operators.json`` and the table in
docs/studies/memory.md.  Three forms: ``pinv`` and ``gram`` of :mod:`tfra.model.fixed.coefficients`, and ``chain``,
which is ``gram`` without C33 A3-dagger: p and q come from C33 C33^T G e.  Random contacts as in
:mod:`bench.exactness.formats`.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from typing import Any

import numpy as np

from bench.publish import publish
from tfra.codegen.memory import BLOCK
from tfra.hdl.parallel.matvec.drain import drain_latency
from tfra.hdl.parallel.matvec.images import depth, passes
from tfra.hdl.parallel.matvec.unit import CAPTURE, CHOICE, FULL
from tfra.hdl.parallel.tfra.timing import Timing
from tfra.model.cover.scenes import SENSORS, contact_codes
from tfra.model.design import Architecture, Design
from tfra.model.fixed.coefficients import coefficient_bits, products, split, stacks
from tfra.model.fixed.matvec import matvec
from tfra.model.fixed.numbers import Ints
from tfra.model.fixed.tfra.pipeline import FixedTfra
from tfra.model.fixed.widths import widths
from tfra.model.fixed.words import decode
from tfra.model.sensor import SensorArray
from tfra.model.tfra import Result, Tfra

SEED = 2024
LANES = 20
"""Multiply-accumulate lanes of 10x10 cores and larger; smaller arrays take eight."""
FORMS = ("pinv", "gram", "chain")


class Chain(FixedTfra):
    """``gram`` with C33 A3-dagger e as three products instead of a stored one."""

    def _normal(self, e: Ints) -> Ints:
        design = self.design
        forces = split(design, "force", matvec(design, "force", matvec(design, "gram", e)))
        return split(design, "residual", matvec(design, "residual", forces["c33_transposed"]))["c33"]


def budget(design: Design, form: str) -> dict[str, int]:
    """Bits and blocks of coefficients, products a frame, and cycles in which the lanes are busy with them."""
    q, order = design.quads, products(design)
    single = -(-4 * q // design.architecture.mac_lanes) * q  # one Q x Q operator
    count = 4 * q * sum(stacks(design)[name].quads for name in order)
    busy = q * sum(passes(design, name) for name in order)
    words, bits = depth(design), coefficient_bits(design)
    if form == "chain":  # G e, C33 y, C33 z instead of one product; y = G d is then a sum of two that are there
        count, busy = count + (2 * 2 - 1) * 4 * q * q, busy + (2 * 2 - 1) * single
        words, bits = words - single, bits - 4 * q * q * design.formats.coefficient
    lanes = design.architecture.mac_lanes
    return {"bits": bits, "depth": words, "blocks": lanes * -(-words // BLOCK), "products": count, "busy": busy}


def added_latency(design: Design, form: str) -> int:
    """Cycles until the last force that ``form`` adds to ``pinv``, the lanes being idle; no gateware says so yet."""
    if form == "pinv":
        return 0
    # The last operand quad is there, then come all passes, then the last of them is drained.
    quads_a_pass = max(1, design.architecture.mac_lanes // 4)
    leaving = (design.quads - 1) % quads_a_pass
    single = FULL + CHOICE + design.quads * passes(design, "gram") + CAPTURE + drain_latency(design) + leaving
    # chain: two more products in front of p and two in front of q, as if nothing overlapped: an upper bound.
    return single if form == "gram" else 2 * 2 * single


def agreement(design: Design, found: Result, exact: Result) -> dict[str, Any]:
    """Winners equal to the float model's, and the worst taxel force over |F| where they are."""
    swept = exact.status == 0
    step = np.abs(found.sweep_index - exact.sweep_index)
    same = swept & (step == 0)
    modulus = np.linalg.norm(exact.resultant, axis=1)[same]
    error = np.abs(found.forces - exact.forces)[same].max(axis=(1, 2, 3)) / modulus
    return {
        "swept": int(swept.sum()),
        "equal": int(same.sum()),
        "largest_step": int(step[swept].max()),
        "force": float(error.max()),
        "force_median": float(np.median(error)),
    }


def measure(sensor: SensorArray, contacts: int) -> dict[str, dict[str, Any]]:
    """All forms on the same frames."""
    lanes = Architecture(LANES if sensor.taxels >= 100 else 8)
    plain = Design(sensor, architecture=lanes)
    codes = contact_codes(plain, contacts, SEED)
    exact = Tfra(sensor)(codes * plain.adc.lsb)
    rows = {}
    for form in FORMS:
        design = replace(plain, operators="pinv" if form == "pinv" else "gram")
        model = (Chain if form == "chain" else FixedTfra)(design)
        w = widths(design)
        rows[form] = {
            "lanes": lanes.mac_lanes,
            **budget(design, form),
            "vector": w.vector,
            "accumulator": w.accumulator,
            "latency": Timing(plain).frame_latency + added_latency(design, form),
            **agreement(design, decode(design, model(codes).words), exact),
        }
    return rows


def table(results: dict[str, dict[str, dict[str, Any]]]) -> str:
    """Markdown: one row for each sensor and form."""
    lines = [
        "| sensor | form | coefficients, kbit | MAC lanes | words a lane | 18-kbit blocks | products | busy cycles "
        "| last word after, cycles | vector, accumulator | index equal (most off) | taxel force: median, worst |",
        "|---|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|",
    ]
    for sensor, forms in results.items():
        for form, row in forms.items():
            lines.append(
                f"| {sensor} | `{form}` | {row['bits'] / 1000:,.0f} | {row['lanes']} | {row['depth']:,} "
                f"| {row['blocks']} | {row['products']:,} | {row['busy']:,} | {row['latency']:,} "
                f"| {row['vector']}, {row['accumulator']} "
                f"| {row['equal'] / row['swept']:.2%} ({row['largest_step']}) "
                f"| {row['force_median']:.1e}, {row['force']:.1e} |"
            )
    return "\n".join(lines)


def main() -> None:
    """Measure, write the JSON and the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--contacts", type=int, default=2000, help="contacts per sensor")
    contacts = parser.parse_args().contacts
    results = {name: measure(sensor, contacts) for name, sensor in SENSORS.items()}
    record = {"contacts": contacts, "seed": SEED, "results": results}
    publish("operators", record, table(results), "docs/studies/memory.md")


if __name__ == "__main__":
    main()
