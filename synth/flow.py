"""Synthesis, place and route, bitstream: runs each tool once, in one directory, and reads its results."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tfra.codegen.verilog.emit import STRICT
from tfra.families import Family, Target
from tfra.families.hierarchy import block_of
from tfra.runtime.processes import ToolError
from tfra.synth.estimate import tally
from tfra.synth.nextpnr import is_constant, place
from tfra.synth.nextpnr import route as route_placed
from tfra.synth.tools import YOSYS, has, run

NETLIST = "netlist.json"
_CELLS = "cells.json"
_READ = {".v": "read_verilog", ".il": "read_rtlil"}
_CONSTRAINTS = "pins.lpf"
_YOSYS_LOG, _YOSYS_ERRORS = "yosys.log", "yosys.err"


@dataclass(frozen=True)
class Synthesis:
    """Results of yosys: resources by name, cells by type, and the mapper that made the lookup tables."""

    resources: Mapping[str, int]
    cells: Mapping[str, int]
    mapper: str


@dataclass(frozen=True)
class CriticalPath:
    """The longest path between two registers, in ns; ``begin`` and ``end`` are blocks of the core."""

    begin: str
    end: str
    begin_cell: str
    end_cell: str
    logic_ns: float
    routing_ns: float


@dataclass(frozen=True)
class Route:
    """One seed of place and route, and the frequency reached."""

    seed: int
    mhz: float
    resources: Mapping[str, int]
    path: CriticalPath


def synthesise(modules: Mapping[str, str], target: Target, directory: Path) -> Synthesis:
    """Map ``modules`` to ``target``'s cells; leaves ``NETLIST`` and a log.  Raises :class:`ToolError`.

    ``modules``: texts of Verilog files (``.v``) or RTLIL (``.il``), and of files that these read, by their names; the
    last one is that of the top module.
    yosys' ABC9 aborts without a word on some netlists (YoWASP/yosys issue 29); those are mapped by ABC.
    """
    for name, text in modules.items():
        (directory / name).write_text(text)
    *_, top = (Path(name).stem for name in modules)
    read = "; ".join(f"{_READ[suffix]} {name}" for name in modules if (suffix := Path(name).suffix) in _READ)
    mapper, family = "default", target.family
    try:
        _yosys(f"{read}; {family.synthesis.format(top=top)}", directory)
    except ToolError:
        end = (directory / _YOSYS_LOG).read_text(errors="replace")[-1000:]
        if not family.fallback or "Executing ABC9" not in end:
            raise
        mapper = "abc"
        _yosys(f"{read}; {family.fallback.format(top=top)}", directory)
    cells: dict[str, int] = json.loads((directory / _CELLS).read_text())["design"]["num_cells_by_type"]
    if family.prepare:
        netlist = json.loads((directory / NETLIST).read_text())
        for kind, added in family.prepare(netlist, top, target.floor).items():
            cells[kind] = cells.get(kind, 0) + added
        (directory / NETLIST).write_text(json.dumps(netlist))
    for leftover in (*modules, _CELLS, _YOSYS_ERRORS):
        (directory / leftover).unlink()
    resources = {name: round(number) for name, number in tally(cells, family).items()}
    return Synthesis(resources, cells, mapper)


def _yosys(commands: str, directory: Path) -> None:
    script = f"{commands}; write_json {NETLIST}; tee -q -o {_CELLS} stat -json"
    # Of what yosys prints, only errors are sure to be complete when it fails.
    run(YOSYS, [*STRICT, "-q", "-l", _YOSYS_LOG, "-p", script], directory, _YOSYS_ERRORS)


def route(target: Target, directory: Path, seed: int, clock_mhz: float) -> Route:
    """Place and route ``NETLIST`` with ``seed``; leaves logs, a report and a layout.  Raises :class:`ToolError`."""
    name, tool = f"seed{seed}", target.family.place_and_route
    assert tool
    words = [*target.device, *target.speed, *options(target.family), "--timing-allow-fail"]
    if tool.constraints:
        (directory / _CONSTRAINTS).write_text(tool.constraints)
        words += [word.format(file=_CONSTRAINTS) for word in tool.constrained]
    layout = [word.format(file=f"{name}.layout") for word in tool.layout]
    written = [*layout, "--report", f"{name}.json", "--seed", str(seed)]

    def nextpnr(arguments: Sequence[str], log: str) -> None:
        run(tool.program, arguments, directory, log)

    if not tool.stages:
        nextpnr([*words, *written, "--json", NETLIST, "--freq", str(clock_mhz)], f"{name}.log")
    else:
        refined = options(target.family) != list(tool.routing)  # by slack, which ends well or badly by chance
        placed = place(nextpnr, words, NETLIST, directory, seed, clock_mhz, free=tool.free, several=refined)
        route_placed(nextpnr, [*words, *written, "--json", placed], f"{name}.log", clock_mhz)
        (directory / placed).unlink()
    return read_route(json.loads((directory / f"{name}.json").read_text()), target, seed)


def options(family: Family) -> list[str]:
    """Options of ``family``'s place and route that its program supports; none where only yosys runs."""
    if not (tool := family.place_and_route):
        return []
    return [*tool.routing, *(tool.threaded if tool.threaded and has(tool.program, tool.threaded[0]) else ())]


def read_route(report: Mapping[str, Any], target: Target, seed: int) -> Route:
    """Read nextpnr's JSON ``report``; raises ``ValueError`` unless the design has one clock."""
    clocks = sorted(name for name in report["fmax"] if not is_constant(name))
    if len(clocks) != 1:
        raise ValueError(f"nextpnr: one clock is expected, got {clocks}")
    (clock,) = clocks
    edge = f"posedge {clock}"
    inner = [path["path"] for path in report["critical_paths"] if path["from"] == path["to"] == edge]
    if len(inner) != 1:
        raise ValueError(f"nextpnr: one critical path of {clock} is expected, got {len(inner)}")
    assert target.family.place_and_route
    bels = target.family.place_and_route.bels
    resources = {name: _used(row, report["utilization"]) for name, row in bels.items()}
    return Route(seed, report["fmax"][clock]["achieved"], resources, read_path(inner[0]))


def _used(bels: Mapping[str, int], utilization: Mapping[str, Any]) -> int:
    """Bels as ``bels`` weighs them; only the first is in every report, since nextpnr makes the others of it."""
    first, *made = bels
    return sum(bels[bel] * utilization[bel]["used"] for bel in [first, *(bel for bel in made if bel in utilization)])


def read_path(steps: list[Mapping[str, Any]]) -> CriticalPath:
    """The longest path, from the steps of nextpnr's report."""
    routing = sum(step["delay"] for step in steps if step["type"] == "routing")
    begin, end = steps[0]["from"]["cell"], steps[-1]["to"]["cell"]
    logic = sum(step["delay"] for step in steps) - routing
    return CriticalPath(block_of(begin), block_of(end), begin, end, round(logic, 3), round(routing, 3))


def pack(target: Target, directory: Path, seed: int, name: str) -> str:
    """Make the bitstream of ``seed``'s layout and return its file's name.  Raises :class:`ToolError`."""
    tool = target.family.place_and_route
    assert tool
    file = name + tool.bitstream
    run(tool.packer, [f"seed{seed}.layout", file], directory, "pack.log")
    return file
