"""The report of ``tfra synth`` as a page: resources, frequency, critical path."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from html import escape
from typing import Any

from tfra.report.html import bars, contents, document, grid, row
from tfra.synth.report import TIMES, cell, fmax, unfinished

_TITLES = {"resources": "Resources", "clock": "Clock", "timing": "Timing", "blocks": "Blocks", "cells": "Cells"}


def page(found: Mapping[str, Any]) -> str:
    """The report as a self-contained page."""
    kind = found["architecture"]["kind"]
    parts = [*_answer(found), contents({name: title for name, title in _TITLES.items() if found.get(name, True)})]
    parts += [_resources(found), *_clock(found), _timing(found["timing"]), _blocks(found), _cells(found)]
    return document(f"{found['name']} on {found['target']}: {kind} core, {found['mac_lanes']} MAC lanes", parts, "")


def _answer(found: Mapping[str, Any]) -> Iterator[str]:
    times, rows = found["timing"], found["resources"].items()
    used = ", ".join(
        f"{row['used']:,} {name}" + (f" ({row['percent']} %)" if row["percent"] is not None else "")
        for name, row in rows
    )
    if found["clock"]:
        yield (
            f'<p class="answer">{escape(fmax(found["clock"]))}: {times["frames_per_second"]:,.0f} frames a second; a '
            f"frame’s last result word comes {times['frame_latency_us']:,.1f} µs after its last taxel.</p>"
        )
    yield f'<p class="answer">{escape(used)}.</p>'
    if missing := unfinished(found):
        yield f'<p class="note">{escape(missing.capitalize())}.</p>'
    if found["mapper"] == "abc":
        yield '<p class="note">ABC9 aborted on this netlist: ABC mapped it instead, without knowing delays.</p>'
    if found["note"]:
        yield f'<p class="note">{escape(found["note"])}</p>'


def _heading(name: str) -> str:
    return f'<h2 id="{name}">{_TITLES[name]}</h2>'


def _resources(found: Mapping[str, Any]) -> str:
    rows = found["resources"]
    shown = [
        (name, facts["percent"] / 100, f"{facts['percent']} %")
        for name, facts in rows.items()
        if facts["percent"] is not None
    ]
    columns = ("used", "available", "percent", "estimated")
    table = (row([name, *(cell(facts[key]) for key in columns)], {0}) for name, facts in rows.items())
    drawn = bars("Share of the part", shown) if shown else ""
    return f"{_heading('resources')}{drawn}{grid('Resources', ['', *columns], [table], {0})}"


def _clock(found: Mapping[str, Any]) -> Iterator[str]:
    clock = found["clock"]
    if not clock:
        return
    seeds = clock["seeds"]
    fastest = max(seed["mhz"] for seed in seeds)
    yield _heading("clock")
    yield bars(
        "Seeds",
        [(f"seed {s['seed']}", s["mhz"] / fastest, f"{s['mhz']} MHz, aim {s['aim_mhz']:g} MHz") for s in seeds],
    )
    path = clock["critical_path"]
    yield (
        f"<p>The critical path goes from {escape(path['begin'])} to {escape(path['end'])}: {path['logic_ns']} ns "
        f"logic, {path['routing_ns']} ns routing.<br><code>{escape(path['begin_cell'])}</code> to "
        f"<code>{escape(path['end_cell'])}</code></p>"
    )


def _timing(times: Mapping[str, Any]) -> str:
    table = (
        row([text, cell(times[f"{name}_cycles"]), cell(times.get(f"{name}_us"))], {0}) for name, text in TIMES.items()
    )
    products = (
        f"<p>A frame takes {times['multiplications_per_frame']:,} products; the MAC lanes multiply in "
        f"{times['mac_utilisation']:.1%} of the cycles.</p>"
    )
    return f"{_heading('timing')}{grid('Timing', ['', 'cycles', 'µs'], [table], {0})}{products}"


def _blocks(found: Mapping[str, Any]) -> str:
    """The largest block first, by the estimate before synthesis."""
    blocks: Mapping[str, Mapping[str, int]] = found["estimated_blocks"]
    names = list(found["resources"])
    order = sorted(blocks.items(), key=lambda item: -item[1][names[0]])
    table = (row([block, *(f"{numbers[name]:,}" for name in names)], {0}) for block, numbers in order)
    note = '<p class="note">Estimates from before synthesis, since yosys flattens the blocks.</p>'
    return f"{_heading('blocks')}{note}{grid('Blocks', ['block', *names], [table], {0})}"


def _cells(found: Mapping[str, Any]) -> str:
    table = (row([name, f"{number:,}"], {0}) for name, number in found["cells"].items())
    tools = ", ".join(f"{name} {number}" for name, number in found["tools"].items())
    made = f"{found['generator']}, {tools}"
    made += f"; place and route: {' '.join(found['options'])}" if found["options"] else ""
    return f"{_heading('cells')}{grid('Cells', ['cell', 'number'], [table], {0})}<p class=\"note\">{escape(made)}</p>"
