"""``tfra size``: the smallest core that is fast enough."""

from dataclasses import replace
from typing import Annotated

import typer

from tfra.cli.common import Config, Json, PageFile, print_json, progress
from tfra.cli.synth import TargetName, find_target
from tfra.codegen.config.core import check_core
from tfra.runtime.errors import InputError

Frames = Annotated[
    float, typer.Option(metavar="F", min=1e-3, max=1e12, help="Required throughput, in frames a second.")
]
Latency = Annotated[
    float,
    typer.Option(
        metavar="T",
        min=1e-3,
        max=1e12,
        help="Largest latency, in microseconds from a frame's last taxel to its last result word.",
    ),
]
Clock = Annotated[
    float | None,
    typer.Option(metavar="F", min=1, max=1000, help="Clock of the core. Default: the slowest measured on the part, or the aim of place and route if less."),
]


def size(
    config: Config,
    target: TargetName,
    frames_per_second: Frames,
    latency_us: Latency,
    clock_mhz: Clock = None,
    page: PageFile = None,
    json: Json = False,
) -> None:
    """Choose the smallest core, serial or parallel, that meets both bounds and fits the part.

    This takes seconds, since speed and resources are computed without synthesis. CONFIG's sensor, converter, search
    and formats are used, its architecture is not. The bounds are checked at the given clock; for a guarantee, give the
    frequency that tfra synth has found.

    Prints TOML to paste into CONFIG. Its comments state the core's speed, its resources, and why other cores were not
    chosen.
    """
    from tfra.codegen.config.read import load
    from tfra.model.choices import Architecture
    from tfra.runtime.outputs import check_file, write_text
    from tfra.synth.candidates import Bounds
    from tfra.synth.size import size as choose
    from tfra.synth.sizepage import facts, lines
    from tfra.synth.sizepage import page as drawn

    part = find_target(target)
    project = load(config)
    if page:
        check_file(page, ".html", "size", [config])
    check_core(replace(project, design=project.design.built_as(Architecture(4, 1))))
    bounds = Bounds(clock_mhz, frames_per_second, latency_us)
    with progress("sizing the core"):
        found = choose(project.array, part, bounds)
    try:
        if page:
            write_text(page, drawn(found), "size")
        if json:
            print_json(facts(found))
        else:
            typer.echo("\n".join(lines(found)))
    except ValueError as error:
        raise InputError(project.path, "", str(error)) from None
