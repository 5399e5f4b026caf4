"""``tfra estimate``: forces from frames, by a chosen engine."""

from __future__ import annotations

import textwrap
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.console import Console

from tfra.cli.common import Config, Json, print_json, progress, simulation_failures
from tfra.cli.inputs import Given, for_recording, frames_at, reads_recording
from tfra.engines import DOUBLE, Engine, run
from tfra.runtime.errors import InputError

if TYPE_CHECKING:
    from tfra.model.tfra import Result

SHOWN = 12  # rows of the table on a terminal

WIDTH = 80  # of the lines after the table

Frames = Annotated[
    Path, typer.Argument(metavar="FRAMES", help="A recording: .npz, .npy, text, .parquet, .mcap or rosbag2.")
]
Out = Annotated[
    Path,
    typer.Option(metavar="RESULT.npz", help="Output file; RESULT.csv and RESULT.parquet are folders of two tables."),
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
    """Estimate the friction coefficient and direction of every frame, and the force under every taxel."""
    from tfra.codegen.config.read import load
    from tfra.codegen.config.write import config_text
    from tfra.model.truth import sentence
    from tfra.recordings.diagnosis import warnings
    from tfra.recordings.facts import as_dict, facts, lines
    from tfra.recordings.results import Estimate, check_result, write_result

    if codes and engine not in DOUBLE:
        raise InputError("tfra estimate", "--codes", f"the {engine.value} engine always sees the converter's codes")
    project = for_recording(load(config), frames, given or {}, "estimate")
    recording = frames_at(frames, project)
    stresses, tare = recording.frames, project.input.tare
    inputs = [config, frames, *([tare] if tare else [])]
    check_result(out, "estimate", inputs)
    with simulation_failures("estimate"), progress(f"estimating forces ({engine.value})", len(stresses)) as advance:
        result = run(engine, project, stresses, frames, advance, codes)
    text = config_text(project.design, project.layer, "", project.weights)
    write_result(out, Estimate(recording, result, engine.value, text), "estimate", inputs)
    summary = facts(stresses, result)
    doubts = warnings(project.design, stresses, result, project.input)
    for doubt in doubts:
        typer.echo(f"warning: {InputError(frames, '', doubt)}", err=True)  # one line, whatever the file name contains
    friction = sentence() if result.uncertainty is None else None  # the learned estimator finds it in another way
    converted = codes or engine not in DOUBLE
    if json:
        source = {"engine": engine.value, "stress": "codes" if converted else "exact", "out": str(out)}
        about = {"summary": as_dict(summary), "friction": friction, "warnings": doubts}
        print_json({**source, **_results(result), **about})
    else:
        _show(result)
        for line in (*lines(summary), *([friction] if friction else [])):
            typer.echo(textwrap.fill(line, WIDTH, subsequent_indent="  "))
        adc = project.design.adc
        of_codes = f"codes of the {adc.bits}-bit converter, {adc.lsb:.6g} Pa each"
        stress = of_codes if converted else "the file's exact stress"
        typer.echo(f"{out}: {len(stresses)} frames by the {engine.value} engine, from {stress}")


def _results(result: Result) -> dict[str, Any]:
    from tfra.model.tfra import Status

    return {
        "frames": len(result.phi_deg),
        "phi_deg": result.phi_deg.tolist(),
        "mu": result.mu.tolist(),
        "resultant_n": result.resultant.tolist(),
        "status": {flag.name: int((result.status & flag != 0).sum()) for flag in Status},
    }


def _show(result: Result) -> None:
    """Print the first frames as a table, on a terminal."""
    from tfra.model.tfra import Status
    from tfra.report.table import Table

    console = Console()
    if not console.is_terminal:
        return
    first = slice(SHOWN)
    columns = (result.phi_deg[first], result.mu[first], result.resultant[first], result.status[first])
    rows = [
        (frame, f"{phi:.1f}", f"{mu:.3f}", *(f"{f:.3f}" for f in force), Status(int(status)).name or "")
        for frame, (phi, mu, force, status) in enumerate(zip(*columns, strict=True))
    ]
    header = ("frame", "phi/°", "mu", "F_x/N", "F_y/N", "F_z/N", "status")
    console.print(Table("", header, rows, words=(6,)).rich())
