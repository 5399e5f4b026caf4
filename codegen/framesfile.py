"""Reading frames of taxel stresses, in Pa, from .npz, .npy and .csv files."""

from __future__ import annotations

import zipfile
import zlib
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import numpy.typing as npt

from tfra.model.errors import InputError
from tfra.model.sensor import Floats, SensorArray
from tfra.model.tfra import check_frames

Array = npt.NDArray[np.generic]

REFERENCES = {"resultant_ref": (3,), "mu_ref": (), "phi_ref_deg": ()}
"""True values of a frame, by key: their shapes; in N, 1 and degrees."""

_DAMAGE = (ValueError, EOFError, RuntimeError, zipfile.BadZipFile, zlib.error)
"""What NumPy and zipfile raise for pickles, truncated, encrypted and damaged files."""


def read_frames(path: str | Path, sensor: SensorArray) -> Floats:
    """Return the frames at ``path``: float64 of shape ``(n, rows, columns)``, n >= 1, all finite.

    A .npz file holds them under the key ``frames``, a .npy file as its only array, and a .csv file one frame
    a line, row by row, separated by commas, with an optional line of headings.  Raises ``InputError`` naming
    the file and the line, frame, row or column that is wrong; rows, columns and frames count from 0.
    """
    file = Path(path)
    try:
        array = _read(file, sensor)
    except OSError as error:
        raise InputError(file, "", f"cannot be read: {error.strerror or error}") from None
    if array.dtype.kind not in "iuf":
        raise InputError(file, "frames", f"real numbers are needed, got {array.dtype}")
    try:
        frames = check_frames(sensor, array)
    except ValueError as error:
        key, _, reason = str(error).partition(": ")
        raise InputError(file, key, reason) from None
    if not len(frames):
        raise InputError(file, "frames", "at least one frame is needed, got none")
    return frames


def read_references(path: str | Path, count: int) -> dict[str, Floats]:
    """Return what a .npz file of ``count`` frames tells of their contacts: those of ``REFERENCES`` that it has.

    Raises ``InputError`` for a key of another shape or without numbers.  Other formats have no references.
    """
    file = Path(path)
    if file.suffix != ".npz":
        return {}
    with np.load(file, allow_pickle=False) as archive:
        return {key: _reference(file, archive, key, count) for key in REFERENCES if key in archive.files}


def _reference(file: Path, archive: Mapping[str, Array], key: str, count: int) -> Floats:
    shape = (count, *REFERENCES[key])
    try:
        array = np.asarray(archive[key], dtype=np.float64)
    except _DAMAGE:
        raise InputError(file, key, "is not a readable array of numbers") from None
    if array.shape != shape:
        raise InputError(file, key, f"shape {shape} is needed, got {array.shape}")
    return array


def _read(file: Path, sensor: SensorArray) -> Array:
    match file.suffix:
        case ".npz":
            return _read_npz(file)
        case ".npy":
            return _read_npy(file)
        case ".csv":
            return _read_csv(file, sensor)
    raise InputError(file, "", "a name that ends in .npz, .npy or .csv is needed")


def _read_npz(file: Path) -> Array:
    archive = _load(file)
    if not isinstance(archive, np.lib.npyio.NpzFile):
        raise InputError(file, "", "is not a .npz file")
    with archive:
        if "frames" not in archive.files:
            raise InputError(file, "frames", f"the key is missing, the file has: {', '.join(archive.files)}")
        try:
            return np.asarray(archive["frames"])
        except _DAMAGE:
            raise InputError(file, "frames", "is not a readable array of numbers") from None


def _read_npy(file: Path) -> Array:
    array = _load(file)
    if not isinstance(array, np.ndarray):
        raise InputError(file, "", "is not a .npy file")
    return array


def _load(file: Path) -> object:
    try:
        return np.load(file, allow_pickle=False)
    except _DAMAGE:
        raise InputError(file, "", f"is not a readable {file.suffix} file of numbers") from None


def _read_csv(file: Path, sensor: SensorArray) -> Floats:
    try:
        text = file.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError:
        raise InputError(file, "", "is not UTF-8 text") from None
    lines = [(number, line.split(",")) for number, line in enumerate(text.splitlines(), 1) if line.strip()]
    if lines and not any(map(_is_number, lines[0][1])):
        del lines[0]  # headings
    values = [_numbers(file, sensor, *line) for line in lines]
    return np.array(values, dtype=np.float64).reshape(-1, sensor.rows, sensor.columns)


def _numbers(file: Path, sensor: SensorArray, line: int, cells: list[str]) -> list[float]:
    if len(cells) != sensor.taxels:
        needed = f"{sensor.taxels} numbers ({sensor.rows} rows x {sensor.columns} columns) are needed"
        raise InputError(file, f"line {line}", f"{needed}, got {len(cells)}")
    for position, cell in enumerate(cells, 1):
        if not _is_number(cell):
            raise InputError(file, f"line {line}", f"{cell.strip()!r} at position {position} is not a number")
    return [float(cell) for cell in cells]


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True
