"""``tfra frames``: simulated frames of the contacts in a CONFIG file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tfra.cli.common import Config, Json, print_json, progress

if TYPE_CHECKING:
    from tfra.codegen.config.read import Project
    from tfra.model.arrays import Floats

Out = Annotated[Path, typer.Option(metavar="FRAMES.npz", help="Output file.")]


def frames(config: Config, out: Out, json: Json = False) -> None:
    """Simulate CONFIG's contacts: a frame of taxel stresses per contact and direction, with ground truth."""
    from tfra.codegen.config.read import load
    from tfra.contacts import Truth
    from tfra.runtime.outputs import check_file, write_npz

    project = load(config)
    check_file(out, ".npz", "frames", [config])
    stresses = simulated(project)
    write_npz(out, {"frames": stresses, **Truth(project.contacts, project.frame).arrays()}, "frames")
    peak, full_scale = float(abs(stresses).max()), project.array.adc.full_scale
    if json:
        print_json({"frames": len(stresses), "peak_pa": peak, "full_scale_pa": full_scale, "out": str(out)})
    else:
        limit = "of" if peak <= full_scale else "which exceeds"
        typer.echo(f"{out}: {len(stresses)} frames, peak {peak:.0f} Pa {limit} {full_scale:.0f} Pa full scale")


def simulated(project: Project) -> Floats:
    """Return the frames of CONFIG's contacts, ``(n, rows, columns)`` in Pa; raises ``InputError`` if there is none."""
    from tfra.contacts import Truth, simulated

    with progress("simulating contacts", len(project.contacts)) as advance:
        return simulated(project, Truth(project.contacts, project.frame), advance)
