"""Reading frames of taxel stresses, in Pa, from .npz, .npy and .csv files."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np
import numpy.typing as npt

from tfra.codegen.arrays import Array, Shape, archive, read_npy
from tfra.codegen.csvfile import read_csv
from tfra.codegen.inputfile import no_memory
from tfra.model.arrays import Floats
from tfra.model.errors import InputError, shortened
from tfra.model.sensor import SensorArray

FRAMES = "frames"
"""The key of the stresses."""

REFERENCES = {"resultant_ref": (3,), "mu_ref": (), "phi_ref_deg": ()}
"""True values of a frame, by key: their shapes; in N, 1 and degrees, nan where unknown."""

MOST = 1e12
"""No stress, force or angle is beyond this, in its SI unit or degrees: diamond breaks at 1e11 Pa.

The models square sums over taxels at most, so with 4096 taxels nothing overflows below 1e150.
"""


def read_frames(path: str | Path, sensor: SensorArray) -> Floats:
    """Return the frames at ``path``: float64 of shape ``(n, rows, columns)``, n >= 1, all finite and within ``MOST``.

    A .npz file holds them under the key ``frames``, a .npy file as its only array, and a .csv file one frame
    a line, row by row, separated by commas, with an optional line of headings.  Raises ``InputError`` naming
    the file and the line, frame, row or column that is wrong; rows, columns and frames count from 0.
    """
    file = Path(path)
    try:
        frames = _doubles(_read(file, sensor))
        _require_stress(file, frames)
    except MemoryError as error:
        raise no_memory(file, error) from None
    if not len(frames):
        raise InputError(file, FRAMES, "at least one frame is needed, got none")
    return frames


def read_references(path: str | Path, count: int) -> dict[str, Floats]:
    """Return what a .npz file of ``count`` frames tells of their contacts: those of ``REFERENCES`` that it has.

    Unknown values are nan.  Raises ``InputError`` for a key of another shape, without real numbers, or with one that is
    infinite or beyond ``MOST``.  Other formats have no references.
    """
    file = Path(path)
    if file.suffix != ".npz":
        return {}
    with archive(file) as found:
        keys = [key for key in REFERENCES if key in found.keys]
        references = {key: _doubles(found.read(key, partial(_wrong_shape, (count, *REFERENCES[key])))) for key in keys}
    for key, values in references.items():
        if len(bad := np.argwhere(np.abs(values) > MOST)):
            raise InputError(file, key, f"frame {bad[0][0]}: {values[tuple(bad[0])]:g} is no true value")
    return references


def _read(file: Path, sensor: SensorArray) -> Array | Floats:
    match file.suffix:
        case ".npz":
            with archive(file) as found:
                if FRAMES not in found.keys:
                    have = shortened(", ".join(found.keys), 120) or "none"
                    raise InputError(file, FRAMES, f"the key is missing, the file has: {have}")
                return found.read(FRAMES, partial(_wrong_frames, sensor))
        case ".npy":
            return read_npy(file, FRAMES, partial(_wrong_frames, sensor))
        case ".csv":
            return read_csv(file, sensor)
    raise InputError(file, "", "a name that ends in .npz, .npy or .csv is needed")


def _wrong_shape(needed: Shape, shape: Shape) -> str | None:
    return None if shape == needed else f"shape {needed} is needed, got {shortened(str(shape))}"


def _wrong_frames(sensor: SensorArray, shape: Shape) -> str | None:
    """Say what is wrong with a ``shape`` that is not ``(n, rows, columns)``, and what it may be."""
    frame = rows, columns = sensor.rows, sensor.columns
    if len(shape) == 3 and shape[1:] == frame:
        return None
    hint = ""
    if shape in (frame, (sensor.taxels,)):
        hint = f": a single frame has the shape (1, {rows}, {columns})"
    elif len(shape) == 2 and shape[1] == sensor.taxels:
        hint = f": frames as rows become frames by reshape(-1, {rows}, {columns})"
    elif len(shape) == 3 and shape[1:] == (columns, rows):
        hint = ": is every frame transposed?"
    elif len(shape) == 3 and shape[:2] == frame:
        hint = ": is the number of frames last? it comes first"
    return f"shape (n, {rows}, {columns}) is needed, got {shortened(str(shape))}{hint}"


def _doubles(array: npt.NDArray[np.generic]) -> Floats:
    with np.errstate(all="ignore"):  # a long double may be infinite as a double
        return np.asarray(array, dtype=np.float64)


def _require_stress(file: Path, frames: Floats) -> None:
    """Raise ``InputError`` for the first value that is no stress."""
    bad = np.argwhere(~(np.abs(frames) <= MOST))
    if not len(bad):
        return
    value = frames[tuple(bad[0])]
    reason = f"is {value:g} Pa, no stress is beyond {MOST:g} Pa" if np.isfinite(value) else "is not finite"
    raise InputError(file, FRAMES, "frame {}, row {}, column {} {}".format(*bad[0], reason))
