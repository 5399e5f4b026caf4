"""Sizings on many parts side by side: a table, the same facts for JSON, and a page whose bars have one scale."""

from collections.abc import Sequence
from typing import Any

from tfra.families import Target
from tfra.families.family import PRICED
from tfra.report.html import Section, bars, paragraph
from tfra.report.html import page as document
from tfra.report.table import Table
from tfra.synth.candidates import Sizing
from tfra.synth.clocks import clock_of
from tfra.synth.estimate import at_most
from tfra.synth.sizepage import facts, share

GUESS = "* no core of this kind was measured on the part: the aim of place and route, or assumed where only yosys runs"


def table(sizings: Sequence[Sizing]) -> Table:
    """A row for each part: its core, if it has one, with resources as shares, those that any core takes."""
    taken = [core.resources or {} for each in sizings if (core := each.best)]
    names = list(dict.fromkeys(name for resources in taken for name, used in resources.items() if used))
    header = ["part", "core", "MHz", "frames/s", "last word / µs", *names]
    return Table("", header, [_row(each, names) for each in sizings], {0, 1})


def reasons(sizings: Sequence[Sizing]) -> list[str]:
    """What the table's star and its prices mean, and a line for every part without a core."""
    return [GUESS, f"EUR: {PRICED}", *(f"{each.target.name}: {each.refusal}" for each in sizings if each.refusal)]


def _row(sizing: Sizing, names: Sequence[str]) -> list[object]:
    target = sizing.target
    part = f"{target.name},\n{target.price} EUR" if target.price else target.name
    if not (core := sizing.best):
        return [part, "none", *[None] * (3 + len(names))]
    assert core.speed
    assert core.resources
    speed, used, kind = core.speed, core.resources, core.architecture.kind
    guess = sizing.bounds.clock_mhz is None and not clock_of(kind, target).measured
    times = f"{speed.clock_mhz:g}{'*' * guess}", f"{speed.frames_per_second:,.0f}", f"{speed.latency_us:,.1f}"
    most = at_most(used, target.family, kind)["LUT"]
    shares = [_share(name, used[name], most, target) if name in used else None for name in names]
    return [part, core.title, *times, *shares]


def _share(name: str, used: int, most: int, target: Target) -> str:
    """Lookup tables in full, with the most, and as a share of the part, others as a share; in full without its size."""
    part = f"{used / have:.0%}" if (have := target.available.get(name)) else ""
    if name == "LUT":
        return ", ".join(filter(None, (f"{used:,}", part))) + f",\nat most {most:,}"
    return part or f"{used:,}"


def text(sizings: Sequence[Sizing]) -> str:
    """The same for a terminal."""
    return table(sizings).text() + "\n".join(reasons(sizings))


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
        Section("parts", "Parts", [table(sizings).html(), *(paragraph(line, "note") for line in reasons(sizings))]),
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
