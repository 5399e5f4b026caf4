"""What the wrapper costs: cycles from frame to frame beside those of the core alone, latency, and size.

``python -m bench.parts.axi_cost`` sends frames back to back through the presets behind AXI, in Verilator, synthesises
the wrapper without its core, and writes ``bench/results/axi_cost.json`` and the table in docs/ip.md.
"""

import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from bench.exactness.axi import differences, run, traffic, verilog
from bench.publish import ROOT, publish
from tfra.codegen.config.read import load
from tfra.codegen.verilog.emit import plain_verilog, to_rtlil
from tfra.codegen.verilog.wrapper import wrapper
from tfra.families import find
from tfra.hdl.cores import microarchitecture
from tfra.hdl.front_end.unit import FrontEnd
from tfra.hdl.ip.wrapper import cut_through, latencies
from tfra.model.fixed.design import Design
from tfra.synth.flow import synthesise

PRESETS = ("fast", "balanced", "small", "learned_fast", "learned_resultant", "learned_small")
TARGET = "ecp5-25-6"


def interval(design: Design) -> dict[str, Any]:
    """Cycles from frame to frame of the core alone, as it states them, and behind AXI, as measured."""
    core = microarchitecture(design)
    frames = traffic(design, core.enough + 2, 1, malformed=0)
    outcome = run(design, frames, "verilator", verilog(design), pauses=False)
    if found := differences(frames, outcome):
        raise AssertionError(found)
    ends = np.array([cycle for _, _, cycle in outcome["back"]])
    measured = float(np.diff(ends)[core.settled].mean())
    first, _, most, _ = latencies(core)
    cut, _ = cut_through(core)
    return {"alone": core.initiation_interval, "behind_axi": measured, "latency": [core.latency, first, cut, most]}


def size(component: Any) -> dict[str, int]:
    """Cells of a component on the target."""
    with tempfile.TemporaryDirectory() as folder:
        text = plain_verilog(to_rtlil(component, "part"), "part")
        return dict(synthesise({"part.v": text}, find(TARGET), Path(folder)).resources)


def table(record: dict[str, Any]) -> str:
    """Markdown: a row for each preset, and one for the front end, which all wrappers have."""
    lines = [
        "| preset | interval | behind AXI | latency | behind AXI | cut through | at most | LUT | FF | DSP | BRAM |",
        "|---|" + "---:|" * 10,
    ]
    for name, cells in record["sizes"].items():
        cycles = "the front end in it | | | | | | |"
        if name in record["intervals"]:
            found = record["intervals"][name]
            more = found["behind_axi"] / found["alone"] - 1
            cycles = f"{name} | {found['alone']:,} | {found['behind_axi']:,.1f} ({more:+.1%}) "
            cycles += " ".join(f"| {latency:,}" for latency in found["latency"]) + " |"
        lines.append(f"| {cycles} " + " | ".join(f"{cells.get(k, 0):,}" for k in ("LUT", "FF", "DSP", "BRAM")) + " |")
    return "\n".join(lines)


def main() -> None:
    """Measure, store, publish."""
    record: dict[str, Any] = {"intervals": {}, "sizes": {}}
    for name in PRESETS:
        design = replace(load(ROOT / "examples" / f"{name}.toml").design, target="portable")
        found = record["intervals"][name] = interval(design)
        record["sizes"][name] = size(wrapper(design))
        print(name, found, record["sizes"][name], flush=True)
    record["sizes"]["front end"] = size(FrontEnd(design))
    publish("axi_cost", record, table(record), "docs/ip.md")


if __name__ == "__main__":
    main()
