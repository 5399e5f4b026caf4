"""``tfra calibrate``: gains, cover and orientation of a real sensor from loads that are known."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from tfra.cli.common import Config, Json, OutDirectory, print_json, progress
from tfra.cli.inputs import Given, for_recording, reads_recording
from tfra.cli.messages import print_error
from tfra.runtime.errors import require

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from tfra.calibrate.calibrated import Calibrated
    from tfra.calibrate.compare import Estimator
    from tfra.codegen.config.read import Project
    from tfra.model.arrays import Floats
    from tfra.model.sensor import SensorArray
    from tfra.model.tfra import Result

Recordings = Annotated[
    list[Path], typer.Argument(metavar="RECORDING...", help="Recordings of the loads, each of which starts at rest.")
]
Loads = Annotated[
    Path,
    typer.Option(metavar="LOADS.csv", help="What was done in each recording: docs/calibration.md has its columns."),
]


@reads_recording
def calibrate(
    config: Config,
    recordings: Recordings,
    loads: Loads,
    out: OutDirectory,
    json: Json = False,
    given: Given | None = None,
) -> None:
    """Find gains, offsets, dead taxels, the cover's thickness and how the array lies, from loads that are known.

    A load is an array at rest, a weight on a ball, a flat punch or a finger anywhere, a pull, or an even pressure.
    Writes cal.toml, which CONFIG's section input names, tables for a core's front end, and a page, index.html.
    """
    require("tfra calibrate", "calibrate", "matplotlib")
    from tfra.calibrate.advice import advice
    from tfra.calibrate.compare import errors
    from tfra.calibrate.doubts import doubts
    from tfra.calibrate.files import write
    from tfra.calibrate.page import compared, lines, render
    from tfra.calibrate.run import calibrate as run
    from tfra.codegen.config.read import load
    from tfra.recordings.front_end import Array
    from tfra.runtime.outputs import check_directory, output_directory

    inputs = [config, loads, *recordings]
    project = for_recording(load(config), recordings[0], given or {}, "calibrate")
    check_directory(out, "calibrate", inputs)
    with progress("calibrating") as advance:
        found = run(
            Array(project.array.sensor, project.array.adc),
            project.input,
            recordings,
            loads,
            lambda title: advance(0, title=title),
        )
        rows = errors(found, _estimators(project))
        warnings, said = list(doubts(found)), advice(found)
        with output_directory(out, "calibrate", inputs) as folder:
            write(found, folder)
            (folder / "index.html").write_text(render(found, rows, warnings, said), encoding="utf-8")
    for warning in warnings:
        print_error(f"warning: {warning}")
    if json:
        print_json({"out": str(out), **_summary(found), "warnings": warnings, "advice": said})
        return
    for line in lines(found):
        typer.echo(line)
    if rows:
        typer.echo(compared(rows).text())
    typer.echo(said)
    typer.echo(f'{out}: open index.html; [input] calibration = "{out / "cal.toml"}" uses it')


def _estimators(project: Project) -> Mapping[str, Estimator]:
    """TFRA with any cover, and the learned estimator of CONFIG, whose weights are of its cover; none of skins."""
    from tfra.model.fixed.tfra.design import TfraDesign

    if project.skin:
        return {}
    design = project.design

    def tfra(sensor: SensorArray) -> Callable[[Floats], Result]:
        return TfraDesign(sensor, adc=design.adc).float_model

    return {design.estimator: lambda sensor: design.float_model} | {TfraDesign.estimator: tfra}


def _summary(found: Calibrated) -> dict[str, Any]:
    fit = found.fit
    return {
        "loads": len(found.loads),
        "taxels": int(found.known.size),
        "known": int(found.known.sum()),
        "dead": found.dead_places,
        "common_gain": found.common,
        "spread": found.spread,
        "thickness_mm": 1e3 * fit.thickness,
        "thickness_error_mm": 1e3 * fit.thickness_error,
        "order": found.given.order,
        "flip_x": found.given.flip_x,
        "flip_y": found.given.flip_y,
        "compression": found.given.compression,
        "orientation_is_sure": found.orientation.is_sure,
        "drift_frames": found.drift_frames,
    }
