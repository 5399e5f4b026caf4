"""A core's Verilog and its netlist, proven equal in steps."""

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from bench.scorecard.netlists.points import Points, Side
from tfra.codegen.verilog.emit import run_yosys

_PACKED = "sb_mac16.v"
_PRODUCT = """\
(* blackbox *)
module product #(parameter A_SIGNED = 0, B_SIGNED = 0) (input [15:0] A, B, output [31:0] Y);
endmodule
"""
"""The abstract product in a multiplier of the iCE40, which :data:`_PACKED` takes out of what is packed around it."""

_PRODUCTS = (
    "wreduce t:$mul; techmap -map +/mul2dsp.v{more} -D DSP_A_MAXWIDTH={width} -D DSP_B_MAXWIDTH={width}"
    " -D DSP_A_MINWIDTH=2 -D DSP_B_MINWIDTH=2 {least} -D DSP_NAME=$__MUL{width}X{width}"
)


@dataclass(frozen=True)
class Flow:
    """How a family's cells are read: yosys' commands.

    ``products`` makes multipliers of products as its synthesis does, ``unpack`` frees them of registers and adders,
    ``cells`` are those with a model of their logic.
    """

    library: str
    products: str
    unpack: str
    cells: str
    models: str
    unwrap: str


FLOWS = {
    "ecp5": Flow(
        "read_verilog -lib +/ecp5/cells_sim.v +/ecp5/cells_bb.v",
        _PRODUCTS.format(more="", width=18, least="") + "; techmap -map +/lattice/dsp_map_18x18.v",
        "",
        "t:LUT4 t:CCU2C t:PFUMX t:L6MUX21 t:TRELLIS_FF",
        "+/ecp5/cells_sim.v",
        "",
    ),
    "ice40": Flow(
        "read_verilog -lib +/ice40/cells_sim.v product.v",
        "opt_expr; opt_clean; opt -nodffe -nosdff; "
        + _PRODUCTS.format(more=" -map +/ice40/dsp_map.v", width=16, least="-D DSP_Y_MINWIDTH=11")
        + "; setattr -unset mul2dsp a:mul2dsp; opt_expr -fine; wreduce; chtype -set $mul t:$__soft_mul",
        f"techmap -autoproc -map {_PACKED} t:SB_MAC16;",
        "t:SB_LUT4 t:SB_CARRY t:SB_DFF*",
        "+/ice40/cells_sim.v",
        "ice40_wrapcarry -unwrap;",
    ),
}

_LOGIC = "techmap; techmap; simplemap; dffunmap; opt_expr; aigmap; opt_clean"
"""Down to ands, inverters and registers."""

_STEPS = {
    "rtl": "{unpack} memory_nordff; {logic}",
    "words": "{unpack} memory_nordff; {logic}",
    # What is read behind the last of several blocks is undefined; synthesis takes the word of another block then.
    "mapped": "memory_map; simplemap; opt_expr -mux_undef; {logic}",
    "registers": "{unwrap} techmap -wb -D EQUIV -autoproc -map {models} {cells}; {logic}",
    "gates": "techmap -wb -D EQUIV -autoproc -map {models} {cells}; {logic}",
}


_REGISTERS = ("SB_DFF", "TRELLIS_FF")
"""Cells that keep their names where their nets do not."""


@dataclass
class Verdict:
    """What became of the points: how many there are, the names of those not proven, and what was abstracted."""

    points: int = 0
    unproven: list[str] = field(default_factory=list)
    abstract: dict[str, int] = field(default_factory=dict)
    alone: list[str] = field(default_factory=list)
    unlinked: int = 0


def snapshots(verilog: str, top: str, family: str, synthesis: str, folder: Path) -> dict[str, dict[str, Any]]:
    """yosys' JSON of the module ``top``: its Verilog ``rtl``, ``words`` before memories are mapped, ``mapped`` behind
    that, ``registers`` once those are cells, and ``gates``; ``synthesis`` is yosys' script, with options.

    Raises :class:`ToolError` when yosys fails.
    """
    flow = FLOWS[family]
    (folder / "core.v").write_text(verilog)
    (folder / "product.v").write_text(_PRODUCT)
    (folder / _PACKED).write_text(Path(__file__).with_name(_PACKED).read_text())
    run_yosys(
        f"read_verilog core.v; {flow.library}; hierarchy -top {top}; proc; flatten; opt_clean; {flow.products};"
        f" memory -nomap; opt_clean; select {top}; write_json -selected rtl.json",
        folder,
    )
    script, begin = "read_verilog core.v", "begin"
    for end, name in (
        ("map_ram", "words"),
        ("map_ffram", "mapped"),
        ("map_luts", "registers"),
        ("check", "gates"),
    ):
        script += f"; {synthesis} -run {begin}:{end}; select {top}; write_json -selected {name}.json; select -clear"
        begin = end
    run_yosys(script, folder)
    return {name: json.loads((folder / f"{name}.json").read_text()) for name in _STEPS}


def verdict(netlists: Mapping[str, dict[str, Any]], top: str, family: str, folder: Path) -> Verdict:
    """All steps of the proof, together: up to the mapping of memories, from there to registers, and on to gates."""
    found = Verdict()
    sides = {name: _lowered(netlist, name, top, FLOWS[family], folder) for name, netlist in netlists.items()}
    for gold, gate in (("rtl", "words"), ("mapped", "registers"), ("registers", "gates")):
        # yosys' own names say nothing where both sides have made them.
        names = {name for name in sides[gold]["netnames"].keys() & sides[gate]["netnames"] if not name.startswith("$")}
        points = Points(Side(sides[gold]), Side(sides[gate]), names)
        proven = points.graph.false(list(points.differ.values()), folder)
        found.points += len(proven)
        found.unproven += [f"{gold}: {name}" for name, fine in zip(points.differ, proven, strict=True) if not fine]
        found.alone += [f"{gold}: {name}" for name in points.alone]
        found.abstract |= points.abstract
        found.unlinked += points.unlinked
    return found


def _lowered(netlist: dict[str, Any], name: str, top: str, flow: Flow, folder: Path) -> dict[str, Any]:
    """The module ``top`` of ands, inverters, registers and foreign cells."""
    module = netlist["modules"][top]
    nets, held = module["netnames"], set[Any]()
    for place, cell in module["cells"].items():
        if cell["type"].startswith(_REGISTERS):
            nets[f"register:{place}"] = {"hide_name": 0, "bits": cell["connections"]["Q"], "attributes": {}}
        held |= {*cell["connections"].get("Q", [])}
        if cell["type"] == "$mem_v2":  # a word that is read while it is written is the old one on both sides
            parameters = cell["parameters"]
            parameters["RD_COLLISION_X_MASK"] = "0" * len(parameters["RD_COLLISION_X_MASK"])
    if name not in ("rtl", "words"):  # whose names of yosys' own are of different runs
        kept = [net for net, wire in nets.items() if net.startswith("$") and held.issuperset(wire["bits"])]
        nets |= {f"net:{net}": {"hide_name": 0, "bits": nets[net]["bits"], "attributes": {}} for net in kept}
    (folder / "in.json").write_text(json.dumps(netlist))
    step = _STEPS[name].format(logic=_LOGIC, **asdict(flow))
    # The library, since yosys asks it for the directions of pins.
    run_yosys(f"{flow.library}; read_json in.json; select {top}; {step}; write_json -selected out.json", folder)
    lowered: dict[str, Any] = json.loads((folder / "out.json").read_text())["modules"][top]
    return lowered
