"""``tfra estimate``: forces from frames, by a chosen engine."""

from __future__ import annotations

import textwrap
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from tfra.cli.common import Config, Json, print_json, progress, simulation_failures
from tfra.cli.inputs import Given, files_of, for_recording, frames_at, reads_recording
from tfra.cli.reports import ArrayReport, SkinReport
from tfra.engines import DOUBLE, Engine, run, run_skin
from tfra.runtime.errors import InputError

WIDTH = 80  # of the lines after the table

Frames = Annotated[
    Path, typer.Argument(metavar="FRAMES", help="A recording: .npz, .npy, text, .parquet, .mcap or rosbag2.")
]
Out = Annotated[
    Path,
    typer.Option(
        metavar="RESULT.npz",
        help="Output file; RESULT.csv and RESULT.parquet are folders of tables, RESULT.mcap is one of messages.",
    ),
]
EngineOption = Annotated[
    Engine,
    typer.Option(help="Double precision, bit-accurate model, that in C, simulated core, or a search in mu_x and mu_y."),
]
Codes = Annotated[
    bool, typer.Option("--codes", help="Feed float and two-variable with the converter's codes, as fixed and rtl are.")
]


@reads_recording
def estimate(
    config: Config,
    frames: Frames,
    out: Out,
    engine: EngineOption = Engine.FLOAT,
    codes: Codes = False,
    json: Json = False,
    given: Given | None = None,
) -> None:
    """Estimate the friction coefficient and direction of every frame, and the force under every taxel.

    On a skin, whose CONFIG has a section window, these are found for every contact.
    """
    from tfra.codegen.config.read import load
    from tfra.recordings.diagnosis import warnings
    from tfra.recordings.results import check_result, write_result

    if codes and engine not in DOUBLE:
        raise InputError("tfra estimate", "--codes", f"the {engine.value} engine always sees the converter's codes")
    project = for_recording(load(config), frames, given or {}, "estimate")
    recording = frames_at(frames, project)
    stresses, inputs = recording.frames, [config, frames, *files_of(project.input)]
    check_result(out, "estimate", inputs)
    report: ArrayReport | SkinReport
    with simulation_failures("estimate"), progress(f"estimating forces ({engine.value})", len(stresses)) as advance:
        if project.skin:
            report = SkinReport(run_skin(engine, project, project.skin, stresses, frames, advance, codes))
        else:
            report = ArrayReport(stresses, run(engine, project, stresses, frames, advance, codes))
    write_result(out, report.estimate(recording, engine.value, project.text()), "estimate", inputs)
    doubts = warnings(project.array, stresses, report.status, project.input, recording.doubts, recording.noise)
    for doubt in doubts:
        typer.echo(f"warning: {InputError(frames, '', doubt)}", err=True)  # one line, whatever the file name contains
    converted = codes or engine not in DOUBLE or project.input.unit == "codes"
    if json:
        source = {"engine": engine.value, "stress": "codes" if converted else "exact", "out": str(out)}
        print_json({**source, "frames": len(stresses), **report.values(), "warnings": doubts})
        return
    if (console := Console()).is_terminal:
        console.print(report.table().rich())
    for line in report.lines():
        typer.echo(textwrap.fill(line, WIDTH, subsequent_indent="  "))
    adc = project.array.adc
    of_codes = f"codes of the {adc.bits}-bit converter, {adc.lsb:.6g} Pa each"
    stress = of_codes if converted else "the file's exact stress"
    typer.echo(f"{out}: {len(stresses)} frames by the {engine.value} engine, from {stress}")
