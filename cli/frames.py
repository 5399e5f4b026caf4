"""``tfra frames``: what the array measures under the contacts of a CONFIG file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from tfra.cli.common import Config, Json, print_json, progress
from tfra.model.errors import InputError

if TYPE_CHECKING:
    from tfra.codegen.config import Project
    from tfra.model.arrays import Floats

CHUNK = 64  # contacts between two steps of the progress bar

Out = Annotated[Path, typer.Option(metavar="FRAMES.npz", help="Where the frames go.")]


def frames(config: Config, out: Out, json: Json = False) -> None:
    """Simulate the contacts: one frame of taxel stresses per contact and direction, with its true forces."""
    from tfra.codegen.config import load
    from tfra.codegen.files import check_archive, write_npz

    project = load(config)
    check_archive(out, "frames", [config])
    stresses = simulated(project)
    write_npz(out, {"frames": stresses, **references(project)}, "frames")
    peak, full_scale = float(abs(stresses).max()), project.design.adc.full_scale
    if json:
        print_json({"frames": len(stresses), "peak_pa": peak, "full_scale_pa": full_scale, "out": str(out)})
    else:
        limit = "of" if peak <= full_scale else "which is beyond"
        typer.echo(f"{out}: {len(stresses)} frames, peak {peak:.0f} Pa {limit} {full_scale:.0f} Pa full scale")


def simulated(project: Project) -> Floats:
    """Return the frames of every contact, ``(n, rows, columns)`` in Pa; raises ``InputError`` if there is none."""
    import numpy as np

    if not project.contacts:
        raise InputError(project.path, "contact", "at least one [[contact]] is needed to simulate frames")
    parts = []
    with progress("simulating contacts", len(project.contacts)) as advance:
        for start in range(0, len(project.contacts), CHUNK):
            part = project.contacts[start : start + CHUNK]
            try:
                parts.append(project.layer.frames(project.design.sensor, part))
            except ValueError as error:  # a mesh that is too coarse, or no finite elements installed
                raise InputError(project.path, "", str(error)) from None
            advance(len(part))
    return np.concatenate(parts)


def references(project: Project) -> dict[str, Any]:
    """Return what the contacts truly are, one row per frame: SI units, phi in degrees in [0, 360)."""
    import numpy as np

    contacts = project.contacts
    phi = np.degrees([c.phi for c in contacts])
    return {
        "resultant_ref": np.array([c.force for c in contacts]),
        "mu_ref": np.array([c.mu for c in contacts]),
        "phi_ref_deg": np.round(phi, 9) % 360.0,  # the way through radians costs the last digits
        "contact_shape": np.array([str(c.shape) for c in contacts]),
        "contact_center": np.array([(c.center_x, c.center_y) for c in contacts]),
        "contact_half": np.array([(c.half_x, c.half_y) for c in contacts]),
    }
