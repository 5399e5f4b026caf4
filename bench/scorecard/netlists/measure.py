"""Line 2: gates of the presets against their Verilog, by proof, and against the model, by simulation."""

import tempfile
from collections import Counter
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from bench.parts.axi_cost import PRESETS
from bench.publish import ROOT
from bench.scorecard.line import GATEWARE, Line, Measured, progress
from bench.scorecard.netlists.proof import snapshots, verdict
from bench.scorecard.record import kept
from tfra.codegen.config.read import load
from tfra.codegen.verilog.emit import to_verilog
from tfra.families import FAMILIES
from tfra.families.hierarchy import block_of
from tfra.model.cover.scenes import contact_codes
from tfra.model.fixed.design import Design
from tfra.runtime.store import cache_directory
from tfra.sim.run import simulate
from tfra.synth.gates import synthesised

SEED, NAMES = 1, 100
"""Of frames and stalls; how many names of points that are not proven are kept."""
QUICK = ("learned_small",)
SIMULATED = (*GATEWARE, "sim", "synth")
"""Sources that decide what gates do."""


def proven(design: Design) -> dict[str, Any]:
    """The record of both steps of the proof."""
    family = FAMILIES[design.target]
    assert family.gates
    commands = family.gates.synthesis.format(top=design.name)
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        synthesis = commands.partition(";")[0].partition(" -run")[0]
        netlists = snapshots(to_verilog(design), design.name, design.target, synthesis, place)
        found = verdict(netlists, design.name, design.target, place)
    return {
        "points": found.points,
        "unproven": len(found.unproven),
        "blocks": dict(Counter(block_of(name.partition(": ")[2].partition("[")[0]) for name in found.unproven)),
        "names": found.unproven[:NAMES],
        "abstract": found.abstract,
        "alone": found.alone,
        "nameless": found.unlinked,
    }


def simulated(design: Design, frames: int) -> dict[str, int]:
    """Words of gates compared with those of the model."""
    codes = contact_codes(design, frames, SEED)
    core = synthesised(design, design.target, cache_directory())
    ran = simulate(design, codes, "icarus", SEED, "random", "bursts", expected=design.model(codes).words, core=core)
    return {"cycles": ran.cycles, "words": ran.compared, "differ": ran.mismatches}


def measure(quick: bool) -> Measured:
    """All presets, or the proof of one; what was judged is kept until a source of it changes."""
    line, records = replace(LINE, title="", target=""), {}
    proof, gates = line.key(quick), replace(line, sources=SIMULATED).key(quick)
    for name in QUICK if quick else PRESETS:
        design = load(ROOT / "examples" / f"{name}.toml").design
        ran = {"cycles": 0, "words": 0, "differ": 0}
        if not quick:
            ran = kept(f"gates-{name}", gates, partial(simulated, design, 1))
        records[name] = one = {**kept(f"netlist-{name}", proof, partial(proven, design)), **ran}
        progress("{0}: {unproven} of {points} points not proven, {differ} of {words} words".format(name, **one))
    points, unproven, words, differ = (
        sum(one[key] for one in records.values()) for key in ("points", "unproven", "words", "differ")
    )
    figure = f"{points - unproven:,} of {points:,} points of {len(records)} netlists proven"
    figure += f"; {words:,} words of gates, {differ:,} differ"
    return Measured(figure, not unproven and not differ, {"seed": SEED, "presets": records})


LINE = Line(
    2,
    "words of the netlist of each preset equal those of its Verilog: proven, and simulated",
    "every preset: all points proven, 0 words differ",
    "the proof abstracts multipliers and block memories as cells that answer alike. Not proven: how yosys maps memories"
    " and products to cells; what a word is that is read while it is written or behind the last of several blocks; that"
    " the register in a multiplier of the iCE40 is one behind its product; registers and copies that move after yosys"
    " (ECP5). Gates with all of this are simulated for a frame each.",
    (*SIMULATED, "bench/parts/axi_cost.py", "bench/scorecard/aig.py", "bench/scorecard/netlists"),
    measure,
)
