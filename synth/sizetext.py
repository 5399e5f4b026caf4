"""A sizing as text: TOML to paste into CONFIG, with comments, and the same facts for JSON."""

from collections.abc import Iterator
from dataclasses import asdict
from typing import Any

from tfra.families import Target
from tfra.synth.candidates import Candidate, Sizing
from tfra.synth.estimate import basis, prices


def lines(sizing: Sizing) -> Iterator[str]:
    """The chosen core as TOML; comments state its speed and size, and why the others were not chosen.

    Raises ``ValueError`` with the reason when none was chosen.
    """
    chosen, target, clock = _chosen(sizing), sizing.target, sizing.bounds.clock_mhz
    assert chosen.speed
    assert chosen.resources
    for section, keys in config(sizing).items():
        yield f"[{section}]"
        for key, value in keys.items():
            yield f'{key} = "{value}"' if isinstance(value, str) else f"{key} = {value}"
    fps, latency = chosen.speed.frames_per_second(clock), chosen.speed.latency_us(clock)
    yield f"# {target.name} at {clock:g} MHz: {fps:,.0f} frames/s, {latency:,.3f} us from last taxel to last word"
    yield "# estimated: " + ", ".join(_share(name, used, target) for name, used in chosen.resources.items())
    yield f"# {basis(chosen.architecture.kind, target.family, sizing.design.estimator)}"
    if not target.available:
        yield f"# {target.name} stands for a whole family: the size of a part is not checked"
    yield "# not chosen:"
    for other, why in sizing.others:
        yield f"#   {other.title}: {why}"


def facts(sizing: Sizing) -> dict[str, Any]:
    """The same for JSON; raises as :func:`lines`."""
    chosen = _chosen(sizing)
    rates = prices(chosen.architecture.kind)
    return {
        "target": sizing.target.name,
        "clock_mhz": sizing.bounds.clock_mhz,
        **_core(chosen, sizing),
        "available": dict(sizing.target.available),
        "fitted_to": rates.family,
        "relative_error": dict(rates.error) if rates.family == sizing.target.family.name else None,
        "config": config(sizing),
        "others": [{**_core(other, sizing), "why": why} for other, why in sizing.others],
    }


def config(sizing: Sizing) -> dict[str, dict[str, str | int]]:
    """Sections and keys of CONFIG for the chosen core; of ``[target]``, those that differ from CONFIG's."""
    chosen, asked = _chosen(sizing), sizing.design
    assert chosen.design
    architecture = {key: value for key, value in asdict(chosen.architecture).items() if value}
    first = {"kind": architecture.pop("kind")}
    pairs = (("name", chosen.design.target, asked.target), ("images", chosen.design.images, asked.images))
    changed = {key: new for key, new, old in pairs if new != old}
    return {"architecture": first | architecture, **({"target": changed} if changed else {})}


def _chosen(sizing: Sizing) -> Candidate:
    if not (chosen := sizing.chosen):
        raise ValueError(sizing.refusal)
    return chosen


def _core(candidate: Candidate, sizing: Sizing) -> dict[str, Any]:
    clock, speed = sizing.bounds.clock_mhz, candidate.speed
    return {
        **asdict(candidate.architecture),
        "frames_per_second": speed and speed.frames_per_second(clock),
        "latency_us": speed and speed.latency_us(clock),
        "interval": speed and speed.interval,
        "frame_latency": speed and speed.frame_latency,
        "estimated": candidate.resources,
    }


def _share(name: str, used: int, target: Target) -> str:
    if not (have := target.available.get(name)):
        return f"{used:,} {name}"
    return f"{used:,} of {have:,} {name} ({used / have:.0%})"
