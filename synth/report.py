"""The report of ``tfra synth``: one JSON object, and the same as text."""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from importlib.metadata import version
from statistics import median_low
from typing import Any

from rich.console import Console
from rich.table import Column, Table

from tfra.families import Target
from tfra.hdl.cores import microarchitecture
from tfra.hdl.interface.microarchitecture import Microarchitecture
from tfra.model.fixed.design import Design
from tfra.synth.estimate import Estimate
from tfra.synth.flow import Route, Synthesis, options
from tfra.synth.tools import versions

WIDTH = 100  # columns of the text

TIMES = {
    "latency": "latency, last taxel to first word",
    "frame_latency": "frame latency, last taxel to last word",
    "interval": "initiation interval",
}
"""Times of a core, and their names in the report."""


def median_route(routes: Sequence[Route]) -> Route:
    """The seed of median speed, the slower of the two in the middle of an even number."""
    middle = median_low(route.mhz for route in routes)
    return next(route for route in routes if route.mhz == middle)


def report(
    design: Design, target: Target, synthesis: Synthesis, routes: Sequence[Route], estimated: Estimate, seeds: int
) -> dict[str, Any]:
    """All results, ready for JSON; complete when all ``seeds`` have been routed.

    Resources are those of place and route where it ran, else of synthesis; times are at the median frequency.
    """
    core = microarchitecture(design)
    used = {**synthesis.resources, **(median_route(routes).resources if routes else {})}
    return {
        "generator": f"tfra {version('tfra')}",
        "name": design.name,
        "complete": len(routes) == seeds,
        "seeds_wanted": seeds,
        "target": target.name,
        "architecture": asdict(design.architecture),
        "mac_lanes": core.lanes,
        "resources": resource_facts(target, used, estimated.total),
        "estimated_blocks": {
            block: {name: round(number) for name, number in row.items()} for block, row in estimated.blocks.items()
        },
        "mapper": synthesis.mapper,
        "cells": dict(sorted(synthesis.cells.items())),
        "clock": clock_facts(routes) if routes else None,
        "note": target.family.timing or None,
        "timing": timing(core, median_route(routes).mhz if routes else None),
        "tools": versions(target.family),
        "options": options(target.family),
    }


def resource_facts(
    target: Target, used: Mapping[str, int], estimated: Mapping[str, int] | None = None
) -> dict[str, dict[str, Any]]:
    """Every resource of ``target``: what is used, what the part has, its share, and the estimate."""
    facts = {}
    for name in target.resources:
        available = target.available.get(name)
        facts[name] = {
            "used": used[name],
            "available": available,
            "percent": round(100 * used[name] / available, 1) if available else None,
            "estimated": estimated[name] if estimated else None,
        }
    return facts


def clock_facts(routes: Sequence[Route]) -> dict[str, Any]:
    """Frequencies over the seeds, and the critical path of the median one."""
    speeds = [route.mhz for route in routes]
    return {
        "median_mhz": round(median_low(speeds), 2),
        "lowest_mhz": round(min(speeds), 2),
        "highest_mhz": round(max(speeds), 2),
        "seeds": [
            {"seed": route.seed, "aim_mhz": round(route.aim, 2), "mhz": round(route.mhz, 2)} for route in routes
        ],
        "critical_path": asdict(median_route(routes).path),
    }


def timing(core: Microarchitecture, mhz: float | None) -> dict[str, Any]:
    """Cycles of ``core`` and, at ``mhz``, times: latency to the first result word, frame latency to the last."""
    cycles = {
        "latency": core.latency,
        "frame_latency": core.frame_latency,
        "interval": core.initiation_interval,
    }
    products = core.design.multiplications
    times = {f"{name}_us": round(number / mhz, 3) for name, number in cycles.items()} if mhz else {}
    return {
        **{f"{name}_cycles": number for name, number in cycles.items()},
        **times,
        **({"frames_per_second": round(1e6 * mhz / core.initiation_interval, 1)} if mhz else {}),
        "multiplications_per_frame": products,
        "mac_utilisation": round(products / (core.lanes * core.initiation_interval), 4),
    }


def render(found: Mapping[str, Any]) -> str:
    """The report as text, lines of at most ``WIDTH`` characters."""
    console = Console(file=io.StringIO(), width=WIDTH, color_system=None)
    kind, lanes = found["architecture"]["kind"], found["mac_lanes"]
    console.print(f"{found['name']} on {found['target']}: {kind} core, {lanes} MAC lanes")
    if missing := unfinished(found):
        console.print(missing)
    console.print(_resources(found["resources"]))
    if found["mapper"] == "abc":
        console.print("ABC9 aborted on this netlist: ABC mapped it instead, without knowing delays.", soft_wrap=True)
    if found["note"]:
        console.print(f"Fmax: {found['note']}", soft_wrap=True)
    if found["clock"]:
        _render_clock(console, found["clock"])
    console.print(_timing(found["timing"]))
    console.print(", ".join(f"{name} {number}" for name, number in found["tools"].items()), soft_wrap=True)
    if found["options"]:
        console.print(f"place and route: {' '.join(found['options'])}", soft_wrap=True)
    assert isinstance(console.file, io.StringIO)
    return console.file.getvalue()


def _resources(rows: Mapping[str, Mapping[str, Any]]) -> Table:
    table = Table("resource", *_right("used", "available", "percent", "estimated"))
    for name, row in rows.items():
        table.add_row(name, *(cell(row[key]) for key in ("used", "available", "percent", "estimated")))
    return table


def _right(*titles: str) -> list[Column]:
    return [Column(title, justify="right") for title in titles]


def cell(value: float | None) -> str:
    """A number as text; a dash for None."""
    return "-" if value is None else f"{value:,}"


def fmax(clock: Mapping[str, Any]) -> str:
    """The frequency as text, with a range if there are several seeds."""
    median, seeds = clock["median_mhz"], clock["seeds"]
    if len(seeds) == 1:
        return f"{median} MHz (seed {seeds[0]['seed']} alone)"
    return f"{median} MHz (median of {len(seeds)} seeds, {clock['lowest_mhz']} to {clock['highest_mhz']})"


def unfinished(found: Mapping[str, Any]) -> str:
    """A line about missing seeds, or nothing."""
    done = len(found["clock"]["seeds"]) if found["clock"] else 0
    return "" if found["complete"] else f"not finished: yosys and {done} of {found['seeds_wanted']} seeds are done"


def _render_clock(console: Console, clock: Mapping[str, Any]) -> None:
    seeds = ", ".join(f"{row['mhz']} (seed {row['seed']}, aim {row['aim_mhz']:g})" for row in clock["seeds"])
    console.print(f"Fmax: {fmax(clock)}\n  {seeds}", soft_wrap=True)
    path = clock["critical_path"]
    console.print(
        f"critical path: {path['begin']} to {path['end']}, "
        f"{path['logic_ns']} ns logic, {path['routing_ns']} ns routing\n"
        f"  from {path['begin_cell']}\n  to   {path['end_cell']}",
        soft_wrap=True,
    )


def _timing(rows: Mapping[str, Any]) -> Table:
    table = Table("", *_right("cycles", "us"))
    for name, text in TIMES.items():
        table.add_row(text, cell(rows[f"{name}_cycles"]), cell(rows.get(f"{name}_us")))
    table.add_row("frames per second", "", cell(rows.get("frames_per_second")))
    table.add_row("multiplications per frame", cell(rows["multiplications_per_frame"]), "")
    table.add_row("MAC utilisation", f"{rows['mac_utilisation']:.1%}", "")
    return table
