"""Sizings on many parts side by side: a table, the same facts for JSON, and a page whose bars have one scale."""

from collections.abc import Sequence
from typing import Any

from tfra.report.html import Section, bars, paragraph
from tfra.report.html import page as document
from tfra.report.table import Table
from tfra.synth.candidates import Candidate, Sizing
from tfra.synth.clocks import clock_of
from tfra.synth.sizepage import facts, share


GUESS = "* no core of this kind was measured on the part: the aim of place and route, or assumed where only yosys runs"


def table(sizings: Sequence[Sizing], *, reasons: bool = False) -> Table:
    """A row for each part: its core, if it has one, with resources as shares; with ``reasons``, why there is none."""
    names = dict.fromkeys(
        name for each in sizings if each.best for name in each.target.resources if _used(each.best)[name]
    )
    header = ["part", "core", "MHz", "frames/s", "last word / µs", *names, *(["why none"] if reasons else [])]
    rows = [[*_row(each, list(names)), *([each.refusal or ""] if reasons else [])] for each in sizings]
    return Table("", header, rows, {0, 1, len(header) - 1} if reasons else {0, 1})


def _row(sizing: Sizing, names: Sequence[str]) -> list[object]:
    if not (core := sizing.best):
        return [sizing.target.name, "none", *[None] * (3 + len(names))]
    assert core.speed
    guess = sizing.bounds.clock_mhz is None and not clock_of(core.architecture.kind, sizing.target).measured
    speed = f"{core.speed.clock_mhz:g}{'*' * guess}", f"{core.speed.frames_per_second:,.0f}", f"{core.speed.latency_us:,.1f}"
    used = [_share(name, core, sizing) if name in sizing.target.resources else None for name in names]
    return [sizing.target.name, core.title, *speed, *used]


def _share(name: str, core: Candidate, sizing: Sizing) -> str:
    """Lookup tables in full and as a share of the part, others as a share; in full where the part's size is unknown."""
    used = _used(core)[name]
    if name not in sizing.target.available:
        return f"{used:,}"
    part = f"{used / sizing.target.available[name]:.0%}"
    return f"{used:,}, {part}" if name == "LUT" else part


def _used(core: Candidate) -> dict[str, int]:
    return dict(core.resources or {})


def text(sizings: Sequence[Sizing]) -> str:
    """The table for a terminal, and a line for every part without a core."""
    reasons = [f"{each.target.name}: {each.refusal}" for each in sizings if each.refusal]
    return table(sizings).text() + "\n".join([GUESS, *reasons])


def all_facts(sizings: Sequence[Sizing]) -> dict[str, Any]:
    """The same for JSON, with CONFIG's keys for each part."""
    return {
        "parts": [facts(each) if each.best else {"target": each.target.name, "why": each.refusal} for each in sizings]
    }


def page(sizings: Sequence[Sizing]) -> str:
    """A self-contained page: bars that can be compared, and the table."""
    name, bounds, fit = sizings[0].design.name, sizings[0].bounds, [each for each in sizings if each.best]
    answer = (
        f"{len(fit)} of {len(sizings)} parts have a core for {bounds.frames_per_second:,.10g} frames/s and "
        f"{bounds.latency_us:,.10g} µs from a frame’s last taxel to its last word."
    )
    note = (
        "Grey is the part, blue the core, both on the scale of the largest part. A lookup table is another cell in "
        "each family, so bars of families compare roughly; the share of the part is exact as far as the estimate is."
    )
    sections = [
        Section("bars", "Lookup tables", [paragraph(note, "note"), _bars(sizings)]),
        Section("parts", "Parts", [table(sizings, reasons=True).html(), paragraph(GUESS, "note")]),
    ]
    return document(f"{name} on all parts: the smallest cores", [paragraph(answer, "answer")], sections)


def _bars(sizings: Sequence[Sizing]) -> str:
    """A bar for each part on one scale, that of the largest part or core."""
    sizes = [each.target.available.get("LUT", 0) for each in sizings]
    used = [each.best.luts if each.best else 0 for each in sizings]
    full = max(*sizes, *used)
    rows = []
    for each, luts in zip(sizings, used, strict=True):
        words = f"{share('LUT', luts, each.target)}: {each.best.title}" if each.best else "none"
        rows.append((each.target.name, luts / full, words))
    return bars("Lookup tables", rows, [size / full for size in sizes])
