"""``tfra generate``: the core in Verilog."""

from __future__ import annotations

from dataclasses import asdict

import typer

from tfra.cli.common import Config, Json, OutDirectory, print_json, progress
from tfra.codegen.core import check_core


def generate(config: Config, out: OutDirectory, json: Json = False) -> None:
    """Write the core: Verilog, ROM images, a testbench, and a JSON file that describes them.

    Prints the condition number of the sensor, and how often the core is expected to agree with double precision.
    """
    from tfra.codegen.config import load
    from tfra.codegen.generate import generate as write
    from tfra.codegen.outlook import outlook
    from tfra.codegen.processes import ToolError

    project = load(config)
    check_core(project)
    try:
        with progress("generating the core"):
            sidecar = write(project.design, out, [config])
    except ToolError as error:
        typer.echo(f"tfra generate: {error}", err=True)
        raise typer.Exit(1) from None
    expected = outlook(project.design)
    if json:
        print_json({**sidecar, "expected": asdict(expected)})
    else:
        typer.echo(f"{expected}")
        if expected.doubtful:
            typer.echo("the word lengths are short for this sensor: try formats.name = \"wide\", or tfra study")
        typer.echo(f"{out}: core {project.design.name}, described in {project.design.name}.json")
