"""``tfra estimate``: forces from frames, by the model of one's choice."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.console import Console
from rich.table import Table

from tfra.cli.common import Config, Json, print_json, progress
from tfra.cli.engines import Engine, run

if TYPE_CHECKING:
    from tfra.model.tfra import Result

SHOWN = 12  # rows of the table on a terminal

KEYS = ("forces", "resultant", "phi_deg", "mu", "mu_x", "mu_y", "sweep_index", "status")
"""Keys of RESULT.npz, each a field of ``tfra.model.tfra.Result``."""

Frames = Annotated[Path, typer.Argument(metavar="FRAMES", help="Stresses in Pa: .npz, .npy or .csv.")]
Out = Annotated[Path, typer.Option(metavar="RESULT.npz", help="Where the forces go.")]
EngineOption = Annotated[
    Engine,
    typer.Option(help="Double precision, the bit-accurate model, the simulated core, or the search in mu_x and mu_y."),
]


def estimate(
    config: Config, frames: Frames, out: Out, engine: EngineOption = Engine.FLOAT, json: Json = False
) -> None:
    """Estimate the forces under every taxel, the direction and the friction coefficient of every frame."""
    from tfra.codegen.config import load
    from tfra.codegen.files import check_archive, write_npz
    from tfra.codegen.framesfile import read_frames

    project = load(config)
    stresses = read_frames(frames, project.design.sensor)
    check_archive(out, "estimate", [config, frames])
    with progress(f"estimating forces ({engine.value})", len(stresses)) as advance:
        arrays = _arrays(run(engine, project, stresses, frames, advance))
    write_npz(out, arrays, "estimate")
    if json:
        print_json({"engine": engine.value, "out": str(out), **_summary(arrays)})
    else:
        _show(arrays)
        typer.echo(f"{out}: {len(stresses)} frames by the {engine.value} engine")


def _arrays(results: list[Result]) -> dict[str, Any]:
    import numpy as np

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
