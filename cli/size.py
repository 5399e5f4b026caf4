"""``tfra size``: how many lanes a core needs."""

from __future__ import annotations

from dataclasses import asdict
from typing import Annotated

import typer

from tfra.cli.common import Config, Json, print_json, progress
from tfra.cli.synth import TargetName, find_target
from tfra.codegen.core import check_core
from tfra.model.errors import InputError

Frames = Annotated[float, typer.Option(metavar="F", min=1e-3, max=1e12, help="Frames that must be done in a second.")]
Latency = Annotated[
    float,
    typer.Option(
        metavar="T", min=1e-3, max=1e12, help="Most microseconds from a frame's last taxel to its last word."
    ),
]
Clock = Annotated[float | None, typer.Option(metavar="F", min=1, max=1000, help="The core's clock.")]


def size(
    config: Config,
    target: TargetName,
    frames_per_second: Frames,
    latency_us: Latency,
    clock_mhz: Clock = None,
    json: Json = False,
) -> None:
    """Choose lanes and words a cycle: the smallest core that meets both bounds and fits the part."""
    from tfra.codegen.config import load
    from tfra.synth.size import Bounds
    from tfra.synth.size import size as choose

    part = find_target(target)
    project = load(config)
    check_core(project)
    clock = clock_mhz or part.clock_mhz
    try:
        with progress("sizing the core"):
            found = choose(project.design, part, Bounds(clock, frames_per_second, latency_us))
    except ValueError as error:
        raise InputError(project.path, "", str(error)) from None
    fps, latency = found.speed.frames_per_second(clock), found.speed.latency_us(clock)
    if json:
        facts = {"clock_mhz": clock, "frames_per_second": fps, "latency_us": latency, **asdict(found.speed)}
        print_json({"target": part.name, **asdict(found.architecture), **facts, "estimated": found.resources})
        return
    typer.echo("[architecture]")
    for key in ("mac_lanes", "vector_words"):
        typer.echo(f"{key} = {getattr(found.architecture, key)}")
    typer.echo(f"# {part.name} at {clock:g} MHz: {fps:,.0f} frames a second, {latency:.3f} us to the last word")
    typer.echo("# estimated: " + ", ".join(f"{number:,} {name}" for name, number in found.resources.items()))
