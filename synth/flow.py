"""Synthesis, place and route, bitstream: runs each tool once, in one directory, and reads its results."""

import json
import re
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tfra.codegen.verilog.emit import STRICT
from tfra.families import Family, Target
from tfra.families.hierarchy import block_of
from tfra.runtime.processes import ToolError
from tfra.synth.estimate import tally
from tfra.synth.placement import is_constant, place
from tfra.synth.tools import YOSYS, StoppedError, has, run

NETLIST = "netlist.json"
_RTLIL, _CELLS = "core.il", "cells.json"
_CONSTRAINTS = "pins.lpf"
_PATIENCE, _MARGIN, _LOWER, _AIMS = 100, 1.01, 0.985, 12
"""Rounds without progress after which nextpnr's router is stopped; its first aim as a share of what is asked for, since
the last analysis finds paths up to a per cent slower than the router did; the next aim as a share of the one before,
and how many there are."""
_ROUND = re.compile(r"iter=\d+ .*overused=(\d+) .*tmgfail=(\d+)")
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
    """One seed of place and route: its last aim, and the frequency reached."""

    seed: int
    aim: float
    mhz: float
    resources: Mapping[str, int]
    path: CriticalPath


def synthesise(rtlil: str, top: str, target: Target, directory: Path) -> Synthesis:
    """Map ``rtlil`` to ``target``'s cells; leaves ``NETLIST`` and a log.  Raises :class:`ToolError`.

    yosys' ABC9 aborts without a word on some netlists (YoWASP/yosys issue 29); those are mapped by ABC.
    """
    (directory / _RTLIL).write_text(rtlil)
    mapper, family = "default", target.family
    try:
        _yosys(family.synthesis.format(top=top), directory)
    except ToolError:
        end = (directory / _YOSYS_LOG).read_text(errors="replace")[-1000:]
        if not family.fallback or "Executing ABC9" not in end:
            raise
        mapper = "abc"
        _yosys(family.fallback.format(top=top), directory)
    cells: dict[str, int] = json.loads((directory / _CELLS).read_text())["design"]["num_cells_by_type"]
    if family.prepare:
        netlist = json.loads((directory / NETLIST).read_text())
        for kind, added in family.prepare(netlist, top, target.floor).items():
            cells[kind] = cells.get(kind, 0) + added
        (directory / NETLIST).write_text(json.dumps(netlist))
    for leftover in (_RTLIL, _CELLS, _YOSYS_ERRORS):
        (directory / leftover).unlink()
    resources = {name: round(number) for name, number in tally(cells, family).items()}
    return Synthesis(resources, cells, mapper)


def _yosys(commands: str, directory: Path) -> None:
    script = f"read_rtlil {_RTLIL}; {commands}; write_json {NETLIST}; tee -q -o {_CELLS} stat -json"
    # Of what yosys prints, only errors are sure to be complete when it fails.
    run(YOSYS, [*STRICT, "-q", "-l", _YOSYS_LOG, "-p", script], directory, _YOSYS_ERRORS)


def route(target: Target, directory: Path, seed: int, clock_mhz: float) -> Route:
    """Place and route ``NETLIST`` with ``seed``; leaves logs, a report and a layout.  Raises :class:`ToolError`.

    nextpnr routes slow paths again until none is slower than its aim, a little above ``clock_mhz``, without an end if
    that can't be: then its router starts again with a lower aim, on the same placement.
    """
    name, tool = f"seed{seed}", target.family.place_and_route
    assert tool
    words = [*target.device, *target.speed, *options(target.family), "--timing-allow-fail"]
    if tool.constraints:
        (directory / _CONSTRAINTS).write_text(tool.constraints)
        words += [word.format(file=_CONSTRAINTS) for word in tool.constrained]
    layout = [word.format(file=f"{name}.layout") for word in tool.layout]
    written = [*layout, "--report", f"{name}.json", "--seed", str(seed)]
    if not tool.stages:
        aim = clock_mhz
        run(tool.program, [*words, *written, "--json", NETLIST, "--freq", str(aim)], directory, f"{name}.log")
    else:
        refined = options(target.family) != list(tool.routing)  # by slack, which ends well or badly by chance
        placed = place(tool.program, words, NETLIST, directory, seed, clock_mhz, free=tool.free, several=refined)
        aim = _route(tool.program, [*words, *written, "--json", placed], directory, f"{name}.log", clock_mhz)
        (directory / placed).unlink()
    return read_route(json.loads((directory / f"{name}.json").read_text()), target, seed, aim)


def _route(program: str, words: Sequence[str], directory: Path, log: str, clock_mhz: float) -> float:
    """Route a placed netlist with nextpnr's options ``words``; returns the aim at which the router came to an end."""
    for left in reversed(range(_AIMS)):
        aim = clock_mhz * _MARGIN * _LOWER ** (_AIMS - 1 - left)
        try:
            run(program, [*words, "--no-pack", "--no-place", "--freq", str(aim)], directory, log, stall())
            break
        except StoppedError:
            if not left:
                raise
    return aim


def options(family: Family) -> list[str]:
    """Options of ``family``'s place and route that its program supports; none where only yosys runs."""
    if not (tool := family.place_and_route):
        return []
    return [*tool.routing, *(tool.threaded if tool.threaded and has(tool.program, tool.threaded[0]) else ())]


def stall() -> Callable[[str], bool]:
    """Asked about the lines of nextpnr's router one by one, tells whether it makes no more progress."""
    best, rounds = (sys.maxsize, sys.maxsize), 0

    def hopeless(line: str) -> bool:
        """Overused wires count first, then paths that are too slow."""
        nonlocal best, rounds
        if found := _ROUND.search(line):
            now = (int(found[1]), int(found[2]))
            rounds = 0 if now < best else rounds + 1
            best = min(now, best)
        return rounds >= _PATIENCE

    return hopeless


def read_route(report: Mapping[str, Any], target: Target, seed: int, aim: float) -> Route:
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
    return Route(seed, aim, report["fmax"][clock]["achieved"], resources, read_path(inner[0]))


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
