"""``tfra verify``: the core against the bit-accurate model, and that against the float reference."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.console import Console

from tfra.cli.common import Config, Json, check_words, print_json, progress, simulation_failures
from tfra.cli.engines import codes
from tfra.cli.frames import references, simulated

if TYPE_CHECKING:
    from tfra.codegen.config import Project
    from tfra.model.sensor import Floats


class Simulator(StrEnum):
    """Who runs the core."""

    ICARUS = "icarus"
    VERILATOR = "verilator"
    AMARANTH = "amaranth"


FramesOption = Annotated[
    Path | None, typer.Option(metavar="FRAMES", help="Stresses in Pa; by default CONFIG's contacts.")
]
SimulatorOption = Annotated[Simulator | None, typer.Option(help="Who runs the core; by default the fastest here.")]
Seed = Annotated[int, typer.Option(min=0, help="Seed of the random frames and of the stalls.")]
Random = Annotated[int, typer.Option(min=0, help="Random frames to add.")]


def verify(
    config: Config,
    frames: FramesOption = None,
    simulator: SimulatorOption = None,
    seed: Seed = 0,
    random: Random = 200,
    json: Json = False,
) -> None:
    """Run frames through the simulated core and compare every bit; exit 1 when something differs."""
    from tfra.codegen.config import load
    from tfra.sim.verify import verify as check

    project = load(config)
    check_words(project)
    stresses, known = _stimuli(project, frames)
    with simulation_failures("verify"), progress("simulating the core") as advance:
        report = check(
            project.design,
            stresses,
            simulator=simulator and simulator.value,
            seed=seed,
            random=random,
            references=known,
            progress=advance,
        )
    if json:
        print_json(report.as_dict())
    else:
        report.render(Console())
    if not report.passed:
        raise typer.Exit(1)


def _stimuli(project: Project, path: Path | None) -> tuple[Floats | None, dict[str, Any]]:
    """Return frames and their true values: from ``path``, else of CONFIG's contacts, else none."""
    from tfra.codegen.framesfile import read_frames, read_references

    if path is not None:
        frames = read_frames(path, project.design.sensor)
        known = read_references(path, len(frames))
    elif project.contacts:
        frames, known = simulated(project), references(project)
    else:
        return None, {}
    codes(project, frames, path or project.path)  # those over full scale are bad input
    return frames, known
