"""A sizing to read: TOML to paste into CONFIG, with comments, the same facts for JSON, and a page of all cores."""

from collections.abc import Iterator
from dataclasses import asdict
from html import escape
from typing import Any

from tfra.families import Target
from tfra.families.family import PRICED
from tfra.report.html import Section, bars, paragraph
from tfra.report.html import page as document
from tfra.report.table import Table
from tfra.synth.candidates import Candidate, Sizing
from tfra.synth.clocks import clock_of
from tfra.synth.estimate import at_most, basis, prices
from tfra.synth.power import Power, power

# All functions raise ``ValueError`` with the reason if no core was chosen.


def lines(sizing: Sizing) -> Iterator[str]:
    """The chosen core as TOML; comments state its speed and size, and why the others were not chosen."""
    chosen, target = sizing.chosen, sizing.target
    assert chosen.speed
    assert chosen.resources
    for section, keys in config(sizing).items():
        yield f"[{section}]"
        for key, value in keys.items():
            yield f'{key} = "{value}"' if isinstance(value, str) else f"{key} = {value}"
    fps, latency, clock = chosen.speed.frames_per_second, chosen.speed.latency_us, chosen.speed.clock_mhz
    yield f"# {target.name} at {clock:g} MHz: {fps:,.0f} frames/s, {latency:,.3f} us from last taxel to last word"
    if sizing.bounds.clock_mhz is None:
        yield f"# {clock:g} MHz: {clock_of(chosen.architecture.kind, target).basis}"
    yield "# estimated: " + ", ".join(share(name, used, target) for name, used in chosen.resources.items())
    most = at_most(chosen.resources, target.family, chosen.architecture.kind)
    yield f"# at most, if as short as any estimate was: {', '.join(f'{used:,} {name}' for name, used in most.items())}"
    yield f"# {basis(chosen.architecture.kind, target.family)}"
    if watts := _power(chosen, target):
        yield f"# power, an estimate: {watts}; logic, multipliers and memories come on top"
    if target.price:
        yield f"# {target.part}: {target.price} EUR a piece ({PRICED})"
    if not target.available:
        yield f"# {target.name} stands for a whole family: the size of a part is not checked"
    yield "# not chosen:"
    for other, why in sizing.others:
        yield f"#   {other.title}: {why}"


def _power(core: Candidate, target: Target) -> Power | None:
    assert core.speed
    assert core.resources
    return power(core.resources, core.architecture.kind, core.speed.clock_mhz, target)


def share(name: str, used: int, target: Target) -> str:
    """``used`` of a resource, with what the part has, and the share of it, if its size is known."""
    if not (have := target.available.get(name)):
        return f"{used:,} {name}"
    return f"{used:,} of {have:,} {name} ({used / have:.0%})"


def facts(sizing: Sizing) -> dict[str, Any]:
    """The same for JSON."""
    chosen, target = sizing.chosen, sizing.target
    assert chosen.resources
    kind = chosen.architecture.kind
    rates = prices(kind, target.family.name)
    return {
        "target": target.name,
        **_core(chosen),
        "at_most": at_most(chosen.resources, target.family, kind),
        "clock_measured": sizing.bounds.clock_mhz is None and clock_of(kind, target).measured,
        "available": dict(target.available),
        "price_class_eur": target.price or None,
        "least_power": asdict(watts) if (watts := _power(chosen, target)) else None,
        "fitted_to": rates.family,
        "relative_error": dict(rates.error) if rates.family == target.family.name else None,
        "config": config(sizing),
        "others": [{**_core(other), "why": why} for other, why in sizing.others],
    }


def _core(candidate: Candidate) -> dict[str, Any]:
    speed = candidate.speed
    return {
        **asdict(candidate.architecture),
        "clock_mhz": speed and speed.clock_mhz,
        "frames_per_second": speed and speed.frames_per_second,
        "latency_us": speed and speed.latency_us,
        "interval": speed and speed.interval,
        "frame_latency": speed and speed.frame_latency,
        "estimated": candidate.resources,
    }


def config(sizing: Sizing) -> dict[str, dict[str, str | int]]:
    """Sections and keys of CONFIG for the chosen core; of ``[target]``, those that differ from CONFIG's."""
    chosen, asked = sizing.chosen, sizing.design
    assert chosen.design
    architecture = {key: value for key, value in asdict(chosen.architecture).items() if value}
    first = {"kind": architecture.pop("kind")}
    pairs = (("name", chosen.design.target, asked.target), ("images", chosen.design.images, asked.images))
    changed = {key: new for key, new, old in pairs if new != old}
    return {"architecture": first | architecture, **({"target": changed} if changed else {})}


def page(sizing: Sizing) -> str:
    """A self-contained page: the answer, and every core that was considered."""
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
    chosen, bounds = sizing.chosen, sizing.bounds
    assert chosen.speed
    fps, latency, clock = chosen.speed.frames_per_second, chosen.speed.latency_us, chosen.speed.clock_mhz
    return (
        f"{chosen.title[0].upper()}{chosen.title[1:]}: {fps:,.0f} frames/s and {latency:,.3f} µs from a frame’s last "
        f"taxel to its last word at {clock:g} MHz. {bounds.frames_per_second:,.10g} frames/s and "
        f"{bounds.latency_us:,.10g} µs were required."
    )


def _estimated(sizing: Sizing) -> str:
    """The smallest first, on one scale: grey is the part if its size is known, and longer bars are over it."""
    part, largest, rows = sizing.target.available.get("LUT", 0), sizing.fast[-1].luts, []
    full = max(part, largest)
    for core in sizing.fast:
        verdict = ": chosen" if core is sizing.chosen else "".join(f": {reason}" for reason in core.objections[:1])
        rows.append((core.title, core.luts / full, f"{share('LUT', core.luts, sizing.target)}{verdict}"))
    return bars("Lookup tables", rows, [(part or full) / full] * len(rows))


def _cores(sizing: Sizing) -> Table:
    names, rows = sizing.target.resources, []
    for core in sizing.candidates:
        speed, used = core.speed, core.resources
        times = [f"{speed.frames_per_second:,.0f}", f"{speed.latency_us:,.3f}"] if speed else [None] * 2
        why = "chosen" if core is sizing.chosen else "; ".join(core.objections) or "larger"
        rows.append([core.title, *times, *(used and used[name] for name in names), why])
    header = ("core", "frames/s", "last word / µs", *names, "why not")
    return Table("All cores", header, rows, {0, len(header) - 1})
