"""The report of ``tfra synth`` to read, as text and as a page: the same tables and sentences."""

from collections.abc import Iterator, Mapping
from typing import Any

from tfra.report.html import Section, bars, paragraph
from tfra.report.html import page as document
from tfra.report.table import Table

_TIMES = {
    "latency": "latency, last taxel to first word",
    "frame_latency": "frame latency, last taxel to last word",
    "cut_through": "latency with CONTROL.cut_through",
    "interval": "initiation interval",
}
_COLUMNS = ("used", "available", "percent", "estimated")


def render(report: Mapping[str, Any]) -> str:
    """The report as text; lines of at most ``report.table.WIDTH`` characters, but for names and lists of seeds."""
    clock, tables = report["clock"], _tables(report)
    lines = [_title(report), *_notes(report), tables["resources"].text()]
    if clock:
        seeds = ", ".join(f"{row['mhz']} (seed {row['seed']})" for row in clock["seeds"])
        path = clock["critical_path"]
        lines += [f"Fmax: {fmax(clock)}", f"  {seeds}", f"critical path: {_path(path)}"]
        lines += [f"  from {path['begin_cell']}", f"  to   {path['end_cell']}"]
    lines += [tables["timing"].text(), *_tools(report)]
    return "\n".join(line.rstrip("\n") for line in lines) + "\n"


def page(report: Mapping[str, Any]) -> str:
    """The report as a self-contained page."""
    tables, clock = {name: table.html() for name, table in _tables(report).items()}, report["clock"]
    tools = "; ".join([report["generator"], *_tools(report)])
    note = paragraph("Estimates from before synthesis, since yosys flattens the blocks.", "note")
    sections = [
        Section("resources", "Resources", [*_shares(report["resources"]), tables["resources"]]),
        *([Section("clock", "Clock", list(_clock(clock)))] if clock else []),
        Section("timing", "Timing", [tables["timing"]]),
        Section("blocks", "Blocks", [note, tables["blocks"]]),
        Section("cells", "Cells", [tables["cells"], paragraph(tools, "note")]),
    ]
    return document(_title(report), _answer(report), sections)


def _title(report: Mapping[str, Any]) -> str:
    kind = report["architecture"]["kind"]
    return f"{report['name']} on {report['target']}: {kind} core, {report['mac_lanes']} MAC lanes"


def _notes(report: Mapping[str, Any]) -> Iterator[str]:
    """What a reader must know of the numbers."""
    if not report["complete"]:
        done = len(report["clock"]["seeds"]) if report["clock"] else 0
        yield f"not finished: yosys and {done} of {report['seeds_wanted']} seeds are done"
    if report["mapper"] == "abc":
        yield "ABC9 aborted on this netlist: ABC mapped it instead, without knowing delays"
    if report["note"]:
        yield f"no Fmax: {report['note']}"


def _tables(report: Mapping[str, Any]) -> dict[str, Table]:
    """Resources, timing, blocks, the largest first, and cells."""
    resources, times, names = report["resources"], report["timing"], list(report["resources"])
    largest_first = sorted(report["estimated_blocks"].items(), key=lambda item: -item[1][names[0]])
    blocks = [[block, *(used[name] for name in names)] for block, used in largest_first]
    stated = {name: title for name, title in _TIMES.items() if f"{name}_cycles" in times}
    timing = [["contacts of a frame", times["contacts"], ""]] if "contacts" in times else []
    timing += [["taxels of each", times["taxels_of_a_contact"], ""]] if timing else []
    timing += [[title, times[f"{name}_cycles"], _exact(times.get(f"{name}_us"))] for name, title in stated.items()]
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
        "cells": Table("Cells", ("cell", "number"), list(report["cells"].items())),
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


def _tools(report: Mapping[str, Any]) -> Iterator[str]:
    """Versions, and options of place and route."""
    yield ", ".join(f"{name} {number}" for name, number in report["tools"].items())
    if report["options"]:
        yield f"place and route: {' '.join(report['options'])}"


def _answer(report: Mapping[str, Any]) -> Iterator[str]:
    times, clock = report["timing"], report["clock"]
    if clock:
        speed = f"{times['frames_per_second']:,.0f} frames a second"
        latency = f"a frame’s last result word comes {times['frame_latency_us']:,.1f} µs after its last taxel"
        yield paragraph(f"{fmax(clock)}: {speed}; {latency}.", "answer")
    used = (
        f"{facts['used']:,} {name}" + (f" ({facts['percent']} %)" if facts["percent"] is not None else "")
        for name, facts in report["resources"].items()
    )
    yield paragraph(f"{', '.join(used)}.", "answer")
    for note in _notes(report):
        yield paragraph(f"{note[0].upper()}{note[1:]}.", "note")


def _shares(resources: Mapping[str, Mapping[str, Any]]) -> Iterator[str]:
    shares = {name: facts["percent"] for name, facts in resources.items() if facts["percent"] is not None}
    if shares:
        yield bars("Share of the part", [(name, share / 100, f"{share} %") for name, share in shares.items()])


def _clock(clock: Mapping[str, Any]) -> Iterator[str]:
    seeds, path = clock["seeds"], clock["critical_path"]
    fastest = max(seed["mhz"] for seed in seeds)
    rows = [(f"seed {s['seed']}", s["mhz"] / fastest, f"{s['mhz']} MHz") for s in seeds]
    yield bars("Seeds", rows)
    cells = f"from `{path['begin_cell']}` to `{path['end_cell']}`"
    yield paragraph(f"Critical path: {_path(path)}, {cells}.")
