"""``tfra verify``: compares the core with the bit-accurate model, and the model with double precision."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.console import Console

from tfra.cli.common import Config, Json, PageFile, Seed, print_json, progress, simulation_failures
from tfra.cli.frames import simulated
from tfra.cli.inputs import Given, for_recording, frames_at, reads_recording
from tfra.codegen.config.core import check_core
from tfra.engines import codes
from tfra.families import FAMILIES
from tfra.runtime.errors import InputError

if TYPE_CHECKING:
    from tfra.codegen.config.read import Project
    from tfra.model.arrays import Floats
    from tfra.sim.report import Report
    from tfra.sim.run import Netlist
    from tfra.sim.skin_report import SkinReport


class Simulator(StrEnum):
    """Simulators of the core."""

    ICARUS = "icarus"
    VERILATOR = "verilator"
    AMARANTH = "amaranth"


if TYPE_CHECKING:
    Family = str
else:
    Family = StrEnum("Family", [name for name, family in FAMILIES.items() if family.gates])
"""Device families whose netlist can be simulated."""

FramesOption = Annotated[
    Path | None, typer.Option(metavar="FRAMES", help="A recording. Default: frames of CONFIG's contacts.")
]
SimulatorOption = Annotated[Simulator | None, typer.Option(help="Default: the fastest that is installed.")]
NetlistOption = Annotated[
    Family | None, typer.Option(help="Simulate the netlist that yosys synthesises, instead of the Verilog.")
]
Random = Annotated[int, typer.Option(min=0, max=100_000, help="Number of random frames to add.")]

Waves = Annotated[
    Path | None,
    typer.Option(
        metavar="FILE.vcd",
        help="Write the waveforms of the first frame that differs, else of the first frame, for GTKWave.",
    ),
]


@reads_recording
def verify(
    config: Config,
    frames: FramesOption = None,
    simulator: SimulatorOption = None,
    seed: Seed = 0,
    random: Random = 200,
    netlist: NetlistOption = None,
    waves: Waves = None,
    page: PageFile = None,
    json: Json = False,
    given: Given | None = None,
) -> None:
    """Simulate the core and compare every bit with the bit-accurate model; exit code 1 if any differs."""
    from tfra.codegen.config.read import load
    from tfra.runtime.outputs import check_file, write_text, write_vcd
    from tfra.runtime.scratch import scratch, temporary
    from tfra.sim.render import page as report_page
    from tfra.sim.render import render
    from tfra.sim.verify import verify as check
    from tfra.sim.verify_skin import verify_skin

    project = load(config)
    check_core(project)
    project = _for_frames(project, frames, given or {})
    inputs = [config, *([frames] if frames else [])]
    if waves:
        check_file(waves, ".vcd", "verify", inputs)
    if page:
        check_file(page, ".html", "verify", inputs)
    stresses, known = _stimuli(project, frames)
    if netlist:
        project.require_array("tfra verify --netlist")
    core = _gates(project, netlist) if netlist else None
    chosen = Simulator.ICARUS if core and not simulator else simulator
    with scratch(temporary()) as place, simulation_failures("verify"), progress("simulating the core") as advance:
        signals = place / "waves.vcd" if waves else None
        how: dict[str, Any] = {"simulator": chosen and chosen.value, "seed": seed, "random": random}
        how |= {"progress": advance, "waves": signals}
        report: Report | SkinReport
        if project.skin:
            report = verify_skin(project.skin, stresses, **how)
        else:
            report = check(project.design, stresses, references=known, core=core, **how)
        if waves:
            write_vcd(waves, place / "waves.vcd", "verify")
    if page:
        write_text(page, report_page(report), "verify")
    if json:
        print_json(report.as_dict())
    else:
        render(report, Console())
        if page:
            print(f"report: {page}")
        if waves:
            print(f"signals of frame {report.recorded}: {waves}")
    if not report.passed:
        raise typer.Exit(1)


def _gates(project: Project, family: Family) -> Netlist:
    """Return the synthesised netlist of the core for ``family``."""
    from tfra.runtime.store import cache_directory
    from tfra.synth.gates import synthesised

    with simulation_failures("verify"), progress("synthesising the core"):
        return synthesised(project.design, family, cache_directory())


def _for_frames(project: Project, path: Path | None, given: Given) -> Project:
    if path is not None:
        return for_recording(project, path, given, "verify")
    if given:
        option = "--" + next(iter(given)).replace("_", "-")
        raise InputError("tfra verify", option, "is for recordings only: --frames is needed")
    return project


def _stimuli(project: Project, path: Path | None) -> tuple[Floats | None, dict[str, Any]]:
    """Return frames and, unless of a skin, reference values: from ``path``, else of CONFIG's contacts, else none."""
    from tfra.contacts import Truth
    from tfra.recordings.frames import read_references

    if path is None and not project.contacts:
        return None, {}
    known: dict[str, Any] = {}
    frames = simulated(project) if path is None else frames_at(path, project).frames
    if not project.skin:
        truth = Truth(project.contacts, project.frame)
        known = truth.arrays() if path is None else read_references(path, len(frames))
    codes(project, frames, path or project.path)  # stress over full scale is bad input
    return frames, known
