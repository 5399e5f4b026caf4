"""``tfra synth``: resources and speed on a part, by yosys and nextpnr."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from tfra.cli.common import Config, Json, OutDirectory, print_json, progress
from tfra.codegen.config.core import check_core
from tfra.families import Target, find, part_names
from tfra.runtime.errors import InputError

if TYPE_CHECKING:
    from tfra.synth.run import Run

TargetName = Annotated[str, typer.Option("--target", metavar="NAME", help=f"{part_names()}.")]
Seeds = Annotated[int, typer.Option(min=1, max=99, help="Number of place and route runs; the result is their median.")]
_AIM = "Target frequency of place and route; the router takes long if it can't be reached."
Clock = Annotated[float | None, typer.Option(metavar="F", min=1, max=1000, help=_AIM)]

_BEHIND = "The core behind its buses, as the package has it: the module NAME_axi."
Package = Annotated[bool, typer.Option("--package", help=_BEHIND)]


def find_target(name: str) -> Target:
    """The target called ``name``; raises ``InputError`` for an unknown one."""
    try:
        return find(name)
    except ValueError as error:
        raise InputError("--target", "", str(error)) from None


def synth(
    config: Config,
    target: TargetName,
    out: OutDirectory,
    package: Package = False,
    seeds: Seeds = 3,
    clock_mhz: Clock = None,
    json: Json = False,
) -> None:
    """Synthesise, place and route the core: resources, frequency, critical path, frames per second."""
    from tfra.codegen.config.read import load
    from tfra.runtime.processes import Stopped, ToolError
    from tfra.synth.run import Run

    part = find_target(target)
    project = load(config)
    check_core(project)
    try:
        with progress("estimating") as advance:
            work = Run(project.array, part, seeds, clock_mhz or part.clock_mhz, advance, package)
            work.write(out, [config])
    except Stopped:
        _show(work, json)
        raise
    except ToolError as error:
        _show(work, json)
        typer.echo(f"tfra synth: {error}", err=True)
        raise typer.Exit(1) from None
    except InputError:
        raise
    except ValueError as error:
        raise InputError(project.path, "", str(error)) from None
    _show(work, json)


def _show(work: Run, json: bool) -> None:
    """Print the report, complete or partial."""
    from tfra.synth.page import render

    if not work.synthesis:
        return
    found = work.report()
    if json:
        print_json(found)
    else:
        typer.echo(render(found), nl=False)
    if not found["complete"]:
        typer.echo("tfra synth: finished steps are kept: the same command continues after them", err=True)
