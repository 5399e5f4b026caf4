"""A sizing as a page: the answer, and every core that was considered."""

from __future__ import annotations

from html import escape

from tfra.report.html import bars, contents, document, grid, row
from tfra.synth.candidates import Candidate, Sizing
from tfra.synth.sizetext import lines


def page(sizing: Sizing) -> str:
    """A self-contained page.  Raises ``ValueError`` with the reason if no core was chosen."""
    toml = "\n".join(lines(sizing))
    titles = {"config": "For CONFIG", "estimated": "Cores that are fast enough", "cores": "All cores"}
    parts = [_answer(sizing), contents(titles)]
    parts += [f'<h2 id="config">{titles["config"]}</h2><pre tabindex="0">{escape(toml)}</pre>']
    parts += [f'<h2 id="estimated">{titles["estimated"]}</h2>', _estimated(sizing)]
    parts += [f'<h2 id="cores">{titles["cores"]}</h2>', _cores(sizing)]
    title = f"{sizing.design.name} on {sizing.target.name}: the smallest core"
    return document(title, parts, "pre { overflow-x: auto; background: #f6f6f6; padding: .6rem; font-size: .85rem; }")


def _answer(sizing: Sizing) -> str:
    chosen, bounds, clock = sizing.chosen, sizing.bounds, sizing.bounds.clock_mhz
    assert chosen
    assert chosen.speed
    fps, latency = chosen.speed.frames_per_second(clock), chosen.speed.latency_us(clock)
    said = (
        f"{chosen.title}: {fps:,.0f} frames/s and {latency:,.3f} µs from a frame’s last taxel to its last word at "
        f"{clock:g} MHz. {bounds.frames_per_second:,.10g} frames/s and {bounds.latency_us:,.10g} µs were required."
    )
    return f'<p class="answer">{escape(said[0].upper() + said[1:])}</p>'


def _estimated(sizing: Sizing) -> str:
    """The smallest first; a full bar is the part, or the largest core if the part's size is unknown."""
    found = sorted((used["LUT"], core) for core in sizing.candidates if (used := core.resources))
    full = sizing.target.available.get("LUT") or max(used for used, _ in found)
    return bars("Lookup tables", [(core.title, used / full, _said(used, core, sizing)) for used, core in found])


def _said(used: int, core: Candidate, sizing: Sizing) -> str:
    if core is sizing.chosen:
        return f"{used:,} LUT: chosen"
    return f"{used:,} LUT" + (f": {core.objections[0]}" if core.objections else "")


def _cores(sizing: Sizing) -> str:
    clock, names = sizing.bounds.clock_mhz, tuple(sizing.target.resources)
    header = ("core", "frames/s", "last word / µs", *names, "why not")
    rows = (row(_cells(core, clock, names, core is sizing.chosen), {0, len(header) - 1}) for core in sizing.candidates)
    return grid("All cores", header, [rows], {0, len(header) - 1})


def _cells(core: Candidate, clock: float, names: tuple[str, ...], chosen: bool) -> list[str]:
    speed, used = core.speed, core.resources
    times = [f"{speed.frames_per_second(clock):,.0f}", f"{speed.latency_us(clock):,.3f}"] if speed else ["–", "–"]
    resources = [f"{used[name]:,}" if used else "–" for name in names]
    why = "chosen" if chosen else "; ".join(core.objections) or "larger"
    return [core.title, *times, *resources, why]
