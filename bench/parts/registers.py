"""The table of the registers, and what they take on parts.

``python -m bench.parts.registers`` puts the map of ``codegen/registers/tfra.rdl`` into docs/registers.md, synthesises
registers and bus for ``examples/fast.toml``, places and routes them alone, and writes ``bench/results/registers.json``
and the table of sizes.
"""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

from bench.parts import blocks
from bench.publish import ROOT, insert, publish
from tfra.codegen.config.read import load
from tfra.codegen.registers.source import register_map
from tfra.codegen.registers.table import table
from tfra.codegen.registers.values import parameters
from tfra.codegen.verilog.emit import to_rtlil
from tfra.hdl.bus.map import RegisterMap
from tfra.hdl.bus.registers import Registers
from tfra.synth.flow import synthesise
from tfra.synth.targets import find

PAGE = "docs/registers.md"
TARGETS = ("ecp5-25-6", "ice40up5k", "xc7")


def measure(registers: RegisterMap, target: str) -> dict[str, int]:
    """Lookup tables and flip-flops of ``registers`` and their bus on ``target``, from yosys."""
    with tempfile.TemporaryDirectory() as folder:
        found = synthesise(to_rtlil(Registers(registers), "registers"), "registers", find(target), Path(folder))
    return {"LUT": found.resources["LUT"], "FF": found.resources["FF"]}


def main() -> None:
    """Measure, store, publish."""
    registers = register_map(parameters(load(ROOT / "examples" / "fast.toml").design))
    record: dict[str, Any] = {target: measure(registers, target) for target in TARGETS}
    record["mhz"] = blocks.measure("registers", Registers(registers))["mhz"]
    lines = ["| target | LUT | FF |", "|---|---:|---:|"]
    lines += [f"| `{target}` | {record[target]['LUT']:,} | {record[target]['FF']:,} |" for target in TARGETS]
    lines += ["", f"Alone on `{blocks.TARGET}`, placed and routed for {blocks.AIM:.0f} MHz: {record['mhz']} MHz."]
    publish("registers", record, "\n".join(lines), PAGE)
    insert("map", table(register_map({})), PAGE)


if __name__ == "__main__":
    main()
