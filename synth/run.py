"""``tfra synth``: a directory with the report, the logs and, where the tools can make one, the bitstream."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from tfra.codegen.files import output_directory
from tfra.codegen.verilog import Top, to_rtlil, with_free_collisions
from tfra.model.fixed.design import Design
from tfra.synth.estimate import estimate, misfits
from tfra.synth.flow import NETLIST, pack, route, synthesise
from tfra.synth.pins import Pins
from tfra.synth.report import median_route, render, report
from tfra.synth.targets import Target
from tfra.synth.tools import programs, require

SIDECAR = "report.json"


def run(
    design: Design,
    target: Target,
    directory: Path,
    seeds: int,
    clock_mhz: float,
    say: Callable[[str], None],
    inputs: Sequence[Path] = (),
) -> dict[str, Any]:
    """Synthesise ``design`` for ``target``, place and route it with seeds 1 to ``seeds``, and return the report.

    Writes ``report.json``, ``report.txt``, a log of every tool and the bitstream of the median seed into
    ``directory``, all or nothing; ``say`` is told what goes on, and ``inputs`` are files that the design comes from.
    Raises ``InputError`` for a missing tool or a directory that can't be written, ``ValueError`` for a design that does
    not fit or is made of another family's cells, :class:`ToolError`.
    """
    if design.target not in ("portable", target.family.name):
        raise ValueError(f"target.name: {target.name} has no cells of {design.target}")
    require(programs(target.family))
    with output_directory(directory, "synth", inputs) as fresh:
        found = _implement(design, target, fresh, seeds, clock_mhz, say)
        (fresh / "report.txt").write_text(render(found))
        (fresh / SIDECAR).write_text(json.dumps(found, indent=1) + "\n")
    return found


def _implement(
    design: Design, target: Target, fresh: Path, seeds: int, clock_mhz: float, say: Callable[[str], None]
) -> dict[str, Any]:
    """Let the tools work in the directory ``fresh``, and return the report."""
    say("estimating")
    estimated = estimate(design, target.family).total
    if lacks := misfits(estimated, target, design.architecture.kind):
        raise ValueError(lacks[0])
    say("synthesis")
    synthesis = synthesise(netlist(design, target), design.name, target, fresh)
    routes = []
    for seed in range(1, (seeds if target.family.program else 0) + 1):
        say(f"place and route, seed {seed} of {seeds}")
        routes.append(route(target, fresh, seed, clock_mhz))
    if routes:
        say("bitstream")
        pack(target, fresh, median_route(routes).seed, design.name)
    for leftover in [fresh / NETLIST, *fresh.glob("*.layout")]:
        leftover.unlink()
    return report(design, target, synthesis, routes, estimated)


def netlist(design: Design, target: Target) -> str:
    """RTLIL of the core for synthesis, behind registers where it is placed: paths to pins are not the core's."""
    top = Pins(Top(design)) if target.family.program else Top(design)
    return with_free_collisions(to_rtlil(top, design.name))
