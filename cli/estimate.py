"""``tfra estimate``: forces from frames, by the model of one's choice."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.console import Console
from rich.table import Table

from tfra.cli.common import Config, Json, check_words, print_json, progress, required
from tfra.model.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable

    from tfra.codegen.config import Project
    from tfra.model.design import Design
    from tfra.model.sensor import Floats
    from tfra.model.tfra import Ints, Result

CHUNK = 512  # frames between two steps of the progress bar
SHOWN = 12  # rows of the table on a terminal

KEYS = ("forces", "resultant", "phi_deg", "mu", "mu_x", "mu_y", "sweep_index", "status")
"""Keys of RESULT.npz, each a field of ``tfra.model.tfra.Result``."""


class Engine(StrEnum):
    """Who computes."""

    FLOAT = "float"
    FIXED = "fixed"
    RTL = "rtl"
    TWO_VARIABLE = "two-variable"


Frames = Annotated[Path, typer.Argument(metavar="FRAMES", help="Stresses in Pa: .npz, .npy or .csv.")]
Out = Annotated[Path, typer.Option(metavar="RESULT.npz", help="Where the forces go.")]
EngineOption = Annotated[
    Engine,
    typer.Option(help="Double precision, the bit-accurate model, the simulated core, or the sweep over both."),
]


def estimate(
    config: Config, frames: Frames, out: Out, engine: EngineOption = Engine.FLOAT, json: Json = False
) -> None:
    """Estimate the forces under every taxel, the direction and the friction coefficient of every frame."""
    from tfra.codegen.config import load
    from tfra.codegen.files import check_writable, write_npz
    from tfra.codegen.framesfile import read_frames

    project = load(config)
    stresses = read_frames(frames, project.design.sensor)
    check_writable(out, ".npz")
    run = _engine(engine, project)
    data = stresses if engine is Engine.FLOAT else _codes(project.design, stresses, frames)
    arrays = _arrays(run, data, len(data) if engine is Engine.RTL else CHUNK)
    write_npz(out, arrays)
    if json:
        print_json({"engine": engine.value, "out": str(out), **_summary(arrays)})
    else:
        _show(arrays)
        typer.echo(f"{out}: {len(stresses)} frames by the {engine.value} engine")


def _engine(engine: Engine, project: Project) -> Callable[[Any], Result]:
    """Return the function from frames in Pa (float) or in converter codes (the others) to results."""
    design = project.design
    if engine is Engine.FLOAT:
        from tfra.model.tfra import Tfra

        search = design.search
        return Tfra(design.sensor, search.steps, search.tolerance * design.adc.lsb)
    if engine is Engine.TWO_VARIABLE:
        raise InputError("tfra estimate", "--engine", "two-variable is not available yet")
    from tfra.model.fixed.pipeline import FixedTfra
    from tfra.model.fixed.words import decode

    check_words(project)
    if engine is Engine.FIXED:
        fixed = FixedTfra(design)
        return lambda codes: decode(design, fixed(codes).words)
    simulate = required("tfra.sim.run", "simulate")
    return lambda codes: decode(design, simulate(design, codes))


def _codes(design: Design, frames: Floats, path: Path) -> Ints:
    from tfra.model.fixed.words import quantise

    try:
        return quantise(design, frames)
    except ValueError as error:  # over full scale
        raise InputError(path, "", str(error)) from None


def _arrays(run: Callable[[Any], Result], data: Any, chunk: int) -> dict[str, Any]:
    """Return what RESULT.npz holds, computed ``chunk`` frames at a time."""
    import numpy as np

    results = []
    with progress("estimating forces", len(data)) as advance:
        for start in range(0, len(data), chunk):
            results.append(run(data[start : start + chunk]))
            advance(len(results[-1].mu))
    return {key: np.concatenate([getattr(result, key) for result in results]) for key in KEYS}


def _summary(arrays: dict[str, Any]) -> dict[str, Any]:
    from tfra.model.tfra import Status

    return {
        "frames": len(arrays["phi_deg"]),
        "phi_deg": arrays["phi_deg"].tolist(),
        "mu": arrays["mu"].tolist(),
        "resultant_n": arrays["resultant"].tolist(),
        "status": {flag.name: int((arrays["status"] & flag != 0).sum()) for flag in Status},
    }


def _show(arrays: dict[str, Any]) -> None:
    """Print the first frames as a table, on a terminal."""
    from tfra.model.tfra import Status

    console = Console()
    if not console.is_terminal:
        return
    table = Table("frame", "phi/°", "mu", "F_x/N", "F_y/N", "F_z/N", "status")
    rows = zip(*(arrays[key][:SHOWN] for key in ("phi_deg", "mu", "resultant", "status")), strict=True)
    for index, (phi, mu, force, status) in enumerate(rows):
        numbers = f"{phi:.1f}", f"{mu:.3f}", *(f"{f:.3f}" for f in force)
        table.add_row(str(index), *numbers, Status(int(status)).name or "")
    console.print(table)
