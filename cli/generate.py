"""``tfra generate``: the core in Verilog, or its estimator in C or in C++ for HLS tools."""

from dataclasses import asdict
from enum import StrEnum
from typing import Annotated

import typer

from tfra.cli.common import Config, Json, OutDirectory, failures, print_json, progress
from tfra.codegen.config.core import check_core
from tfra.runtime.errors import InputError

Package = Annotated[
    bool,
    typer.Option("--package", help="Write a folder for FPGA projects: FuseSoC, Vivado, LiteX, a board, a datasheet."),
]


class Language(StrEnum):
    """The back ends by name."""

    VERILOG = "verilog"
    C = "c"
    HLS = "hls"


Backend = Annotated[
    Language, typer.Option(help="Verilog for FPGAs, C99 for PCs and microcontrollers, or C++ for Vitis HLS.")
]


def generate(
    config: Config,
    out: OutDirectory,
    package: Package = False,
    backend: Backend = Language.VERILOG,
    json: Json = False,
) -> None:
    """Write the core: Verilog, ROM images, a testbench, and a JSON file that describes them; or the same words in C.

    Prints the condition number of the sensor, and how often the core is expected to agree with double precision; with
    --package, a warning if core and wrapper fit no part of its family, and for HLS if the tables do not fit the part of
    its project files.
    """
    from tfra.codegen.config.names import check_packaged
    from tfra.codegen.config.read import load
    from tfra.codegen.generate import generate as write
    from tfra.codegen.hls.files import misfit
    from tfra.codegen.verilog.wrapper import check_wrapped
    from tfra.model.fixed.feasibility import accuracy_estimate
    from tfra.runtime.outputs import check_directory
    from tfra.runtime.processes import ToolError
    from tfra.synth.estimate import misfits, part_of

    project = load(config)
    if backend is Language.HLS:
        project.require_array("tfra generate --backend hls")
    check_core(project)
    if package and backend is not Language.VERILOG:
        raise InputError("--package", "", f"there is none of the back end {backend.value}")
    if package:  # what would be refused after a minute
        check_directory(out, "generate", [config])
        try:
            check_packaged(project.design.name)
            check_wrapped(project.array)
        except ValueError as error:
            raise InputError(project.path, "", str(error)) from None
    with failures("generate", ToolError), progress("generating the core"):
        part = part_of(project.array) if package else None
        sidecar = write(project.array, out, [config], part, backend.value)
    if part:
        used = {name: count for name, (count, _) in part.resources.items()}
        if lacks := misfits(used, part.target, project.design.architecture.kind):
            typer.echo(f"warning: {InputError(config, '', '; '.join(lacks))}", err=True)
    if backend is Language.HLS and (lacking := misfit(project.design)):
        typer.echo(f"warning: {InputError(config, '', lacking)}", err=True)
    expected = accuracy_estimate(project.design)
    if json:
        print_json({**sidecar, "expected": asdict(expected)})
    else:
        typer.echo(f"{expected}")
        if expected.doubtful:
            typer.echo('the word lengths are short for this sensor: try formats.name = "wide", or tfra study')
        typer.echo(f"{out}: core {project.design.name}, described in {project.design.name}.json")
