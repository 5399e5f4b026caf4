"""Results of the float and the bit-accurate model, as `tfra estimate` writes them, and their frames."""

import base64
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from tfra.cli.frames import simulated
from tfra.codegen.config.read import Project, load
from tfra.contacts import Truth
from tfra.model.arrays import Floats
from tfra.model.converter import quantise
from tfra.model.fixed.words import decode
from tfra.model.tfra import Result, Tfra
from tfra.runtime.outputs import write_npz
from tfra.view.pack import Packed

CONFIG = """
[sensor]
rows = 4
columns = 6
pitch_x_mm = 4
pitch_y_mm = 3
thickness_mm = 3
[search]
plateau_tolerance = 3
[[contact]]
shape = "hertz"
half_x_mm = 6
half_y_mm = 4
force_n = -4
mu = 0.5
phi_deg = { start = 0, stop = 360, step = 15 }
"""

KEYS = ("forces", "resultant", "phi_deg", "mu", "mu_x", "mu_y", "sweep_index", "status")

NO_CONTACT, COMPRESSED = 4, 11
"""Frames without contact and without traction."""


def project(folder: Path) -> Project:
    file = folder / "skin.toml"
    file.write_text(CONFIG)
    return load(file)


def recording(of: Project) -> Floats:
    """Frames of all directions, one without a contact and one that nothing pulls at."""
    frames = simulated(of)
    frames[NO_CONTACT] = 0.0
    frames[COMPRESSED] = -np.abs(frames[COMPRESSED])
    return frames


def arrays(found: Result, stress: Floats, engine: str) -> dict[str, Any]:
    """What a result file holds."""
    held = {key: getattr(found, key) for key in KEYS}
    return held | {"stress": stress, "engine": np.array(engine), "config": np.array(CONFIG)}


def write(folder: Path) -> dict[str, dict[str, Any]]:
    """Write float.npz, fixed.npz and frames.npz, and return the arrays of each."""
    of = project(folder)
    frames, design = recording(of), of.design
    codes = quantise(design, frames)
    made = {
        "float": arrays(Tfra.of(design)(frames), frames, "float") | {"time": 0.01 * np.arange(len(frames))},
        "fixed": arrays(decode(design, design.model(codes).words), codes * design.adc.lsb, "fixed"),
        "frames": {"frames": frames, **Truth(of.contacts).arrays()},
    }
    for name, held in made.items():
        write_npz(folder / f"{name}.npz", held, "frames" if name == "frames" else "estimate")
    return made


def unpacked(array: Packed) -> npt.NDArray[Any]:
    """The numbers that a page's script reads."""
    return np.frombuffer(base64.b64decode(array["data"]), dtype=np.dtype(array["type"]).newbyteorder("<"))
