"""The report of ``tfra synth`` to read, as text and as a page: the same tables and sentences."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from tfra.report.html import Section, bars, paragraph
from tfra.report.html import page as document
from tfra.report.table import Table

_TIMES = {
    "latency": "latency, last taxel to first word",
    "frame_latency": "frame latency, last taxel to last word",
    "interval": "initiation interval",
}
_COLUMNS = ("used", "available", "percent", "estimated")


def render(found: Mapping[str, Any]) -> str:
    """The report as text; lines of at most ``report.table.WIDTH`` characters, but for names and lists of seeds."""
    clock, tables = found["clock"], _tables(found)
    lines = [_title(found), *_notes(found), tables["resources"].text()]
    if clock:
        seeds = ", ".join(f"{row['mhz']} (seed {row['seed']}, aim {row['aim_mhz']:g})" for row in clock["seeds"])
        path = clock["critical_path"]
        lines += [f"Fmax: {fmax(clock)}", f"  {seeds}", f"critical path: {_path(path)}"]
        lines += [f"  from {path['begin_cell']}", f"  to   {path['end_cell']}"]
    lines += [tables["timing"].text(), *_tools(found)]
    return "\n".join(line.rstrip("\n") for line in lines) + "\n"


def page(found: Mapping[str, Any]) -> str:
    """The report as a self-contained page."""
    tables, clock = {name: table.html() for name, table in _tables(found).items()}, found["clock"]
    tools = "; ".join([found["generator"], *_tools(found)])
    note = paragraph("Estimates from before synthesis, since yosys flattens the blocks.", "note")
    sections = [
        Section("resources", "Resources", [*_shares(found["resources"]), tables["resources"]]),
        *([Section("clock", "Clock", list(_clock(clock)))] if clock else []),
        Section("timing", "Timing", [tables["timing"]]),
        Section("blocks", "Blocks", [note, tables["blocks"]]),
        Section("cells", "Cells", [tables["cells"], paragraph(tools, "note")]),
    ]
    return document(_title(found), _answer(found), sections)


def _title(found: Mapping[str, Any]) -> str:
    kind = found["architecture"]["kind"]
    return f"{found['name']} on {found['target']}: {kind} core, {found['mac_lanes']} MAC lanes"


def _notes(found: Mapping[str, Any]) -> Iterator[str]:
    """What a reader must know of the numbers."""
    if not found["complete"]:
        done = len(found["clock"]["seeds"]) if found["clock"] else 0
        yield f"not finished: yosys and {done} of {found['seeds_wanted']} seeds are done"
    if found["mapper"] == "abc":
        yield "ABC9 aborted on this netlist: ABC mapped it instead, without knowing delays"
    if found["note"]:
        yield f"no Fmax: {found['note']}"


def _tables(found: Mapping[str, Any]) -> dict[str, Table]:
    """Resources, timing, blocks, the largest first, and cells."""
    resources, times, names = found["resources"], found["timing"], list(found["resources"])
    largest_first = sorted(found["estimated_blocks"].items(), key=lambda item: -item[1][names[0]])
    blocks = [[block, *(used[name] for name in names)] for block, used in largest_first]
    timing = [[title, times[f"{name}_cycles"], _exact(times.get(f"{name}_us"))] for name, title in _TIMES.items()]
    timing += [
        ["frames per second", "", _exact(times.get("frames_per_second"))],
        ["multiplications per frame", times["multiplications_per_frame"], ""],
        ["MAC utilisation", f"{times['mac_utilisation']:.1%}", ""],
    ]
    return {
        "resources": Table(
            "Resources",
            ("", *_COLUMNS),
            [[name, *(_exact(facts[column]) for column in _COLUMNS)] for name, facts in resources.items()],
        ),
        "timing": Table("Timing", ("", "cycles", "µs"), timing),
        "blocks": Table("Blocks", ("block", *names), blocks),
        "cells": Table("Cells", ("cell", "number"), list(found["cells"].items())),
    }


def _exact(value: float | None) -> str | None:
    """All digits of a number."""
    return None if value is None else f"{value:,}"


def fmax(clock: Mapping[str, Any]) -> str:
    """The frequency as text, with a range if there are several seeds."""
    median, seeds = clock["median_mhz"], clock["seeds"]
    if len(seeds) == 1:
        return f"{median} MHz (seed {seeds[0]['seed']} alone)"
    return f"{median} MHz (median of {len(seeds)} seeds, {clock['lowest_mhz']} to {clock['highest_mhz']})"


def _path(path: Mapping[str, Any]) -> str:
    return f"{path['begin']} to {path['end']}, {path['logic_ns']} ns logic, {path['routing_ns']} ns routing"


def _tools(found: Mapping[str, Any]) -> Iterator[str]:
    """Versions, and options of place and route."""
    yield ", ".join(f"{name} {number}" for name, number in found["tools"].items())
    if found["options"]:
        yield f"place and route: {' '.join(found['options'])}"


def _answer(found: Mapping[str, Any]) -> Iterator[str]:
    times, clock = found["timing"], found["clock"]
    if clock:
        speed = f"{times['frames_per_second']:,.0f} frames a second"
        latency = f"a frame’s last result word comes {times['frame_latency_us']:,.1f} µs after its last taxel"
        yield paragraph(f"{fmax(clock)}: {speed}; {latency}.", "answer")
    used = (
        f"{facts['used']:,} {name}" + (f" ({facts['percent']} %)" if facts["percent"] is not None else "")
        for name, facts in found["resources"].items()
    )
    yield paragraph(f"{', '.join(used)}.", "answer")
    for note in _notes(found):
        yield paragraph(f"{note[0].upper()}{note[1:]}.", "note")


def _shares(resources: Mapping[str, Mapping[str, Any]]) -> Iterator[str]:
    shares = {name: facts["percent"] for name, facts in resources.items() if facts["percent"] is not None}
    if shares:
        yield bars("Share of the part", [(name, share / 100, f"{share} %") for name, share in shares.items()])


def _clock(clock: Mapping[str, Any]) -> Iterator[str]:
    seeds, path = clock["seeds"], clock["critical_path"]
    fastest = max(seed["mhz"] for seed in seeds)
    rows = [(f"seed {s['seed']}", s["mhz"] / fastest, f"{s['mhz']} MHz, aim {s['aim_mhz']:g} MHz") for s in seeds]
    yield bars("Seeds", rows)
    cells = f"from `{path['begin_cell']}` to `{path['end_cell']}`"
    yield paragraph(f"Critical path: {_path(path)}, {cells}.")
