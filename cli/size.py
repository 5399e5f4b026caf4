"""``tfra size``: the smallest core that is fast enough."""

from dataclasses import replace
from typing import Annotated

import typer

from tfra.cli.common import Config, Json, PageFile, print_json, progress
from tfra.cli.synth import find_target
from tfra.codegen.config.core import check_core
from tfra.families import part_names
from tfra.runtime.errors import InputError

ALL = "all"
"""Instead of a part: every part, side by side."""

_HELP = f"{part_names()}; {ALL} compares every part, at its slowest grade."
PartName = Annotated[str, typer.Option("--target", metavar="NAME", help=_HELP)]
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
_CLOCK = "Clock of the core. Default: the slowest measured on the part, or the aim of place and route if that is less."
Clock = Annotated[float | None, typer.Option(metavar="F", min=1, max=1000, help=_CLOCK)]


def size(
    config: Config,
    target: PartName,
    frames_per_second: Frames,
    latency_us: Latency,
    clock_mhz: Clock = None,
    page: PageFile = None,
    json: Json = False,
) -> None:
    """Choose the smallest core, serial or parallel, that meets both bounds and fits the part.

    This takes seconds, since speed and resources are computed without synthesis. CONFIG's sensor, converter, search
    and formats are used, its architecture is not. For a guarantee, give the frequency that tfra synth has found.

    Prints TOML to paste into CONFIG. Its comments state the core's speed, its resources, and why other cores were not
    chosen. For all parts, prints a table: the core of each, or why there is none.
    """
    from tfra.codegen.config.read import load
    from tfra.model.choices import Architecture
    from tfra.runtime.outputs import check_file, write_text
    from tfra.synth import partspage, sizepage
    from tfra.synth.candidates import Bounds
    from tfra.synth.size import size as choose
    from tfra.synth.size import size_parts

    part = None if target == ALL else find_target(target)
    project = load(config)
    if page:
        check_file(page, ".html", "size", [config])
    check_core(replace(project, design=project.design.built_as(Architecture(4, 1))))
    bounds = Bounds(clock_mhz, frames_per_second, latency_us)
    with progress("sizing the core") as advance:
        found = [choose(project.array, part, bounds)] if part else size_parts(project.array, bounds, advance)
    if not any(each.best for each in found):
        last = max(found, key=lambda each: each.target.available.get("LUT", 0))
        where = "" if part else f"no part has such a core: on {last.target.name}, "
        raise InputError(project.path, "", f"{where}{last.refusal}")
    if page:
        write_text(page, sizepage.page(found[0]) if part else partspage.page(found), "size")
    if json:
        print_json(sizepage.facts(found[0]) if part else partspage.all_facts(found))
    else:
        typer.echo("\n".join(sizepage.lines(found[0])) if part else partspage.text(found))
