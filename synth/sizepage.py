"""A sizing as a page: the answer, and every core that was considered."""

from html import escape

from tfra.report.html import Section, bars, paragraph
from tfra.report.html import page as document
from tfra.report.table import Table
from tfra.synth.candidates import Sizing
from tfra.synth.sizetext import lines


def page(sizing: Sizing) -> str:
    """A self-contained page.  Raises ``ValueError`` with the reason if no core was chosen."""
    toml = escape("\n".join(lines(sizing)))
    sections = [
        Section("config", "For CONFIG", [f'<pre tabindex="0">{toml}</pre>']),
        Section("estimated", "Cores that are fast enough", [_estimated(sizing)]),
        Section("cores", "All cores", [_cores(sizing).html()]),
    ]
    title = f"{sizing.design.name} on {sizing.target.name}: the smallest core"
    style = "pre { overflow-x: auto; background: #f6f6f6; padding: .6rem; font-size: .85rem; }"
    return document(title, [paragraph(_answer(sizing), "answer")], sections, style)


def _answer(sizing: Sizing) -> str:
    chosen, bounds, clock = sizing.chosen, sizing.bounds, sizing.bounds.clock_mhz
    assert chosen
    assert chosen.speed
    fps, latency = chosen.speed.frames_per_second(clock), chosen.speed.latency_us(clock)
    return (
        f"{chosen.title[0].upper()}{chosen.title[1:]}: {fps:,.0f} frames/s and {latency:,.3f} µs from a frame’s last "
        f"taxel to its last word at {clock:g} MHz. {bounds.frames_per_second:,.10g} frames/s and "
        f"{bounds.latency_us:,.10g} µs were required."
    )


def _estimated(sizing: Sizing) -> str:
    """The smallest first; a full bar is the part, or the largest core if the part's size is unknown."""
    fast = sorted((used["LUT"], core) for core in sizing.candidates if (used := core.resources))
    full = sizing.target.available.get("LUT") or max(luts for luts, _ in fast)
    rows = []
    for luts, core in fast:
        verdict = ": chosen" if core is sizing.chosen else "".join(f": {reason}" for reason in core.objections[:1])
        rows.append((core.title, luts / full, f"{luts:,} LUT{verdict}"))
    return bars("Lookup tables", rows)


def _cores(sizing: Sizing) -> Table:
    clock, names, rows = sizing.bounds.clock_mhz, sizing.target.resources, []
    for core in sizing.candidates:
        speed, used = core.speed, core.resources
        times = [f"{speed.frames_per_second(clock):,.0f}", f"{speed.latency_us(clock):,.3f}"] if speed else [None] * 2
        why = "chosen" if core is sizing.chosen else "; ".join(core.objections) or "larger"
        rows.append([core.title, *times, *(used and used[name] for name in names), why])
    header = ("core", "frames/s", "last word / µs", *names, "why not")
    return Table("All cores", header, rows, {0, len(header) - 1})
