"""Writing the results of ``tfra estimate``: an archive, or a folder of tables.

    RESULT.npz                                      arrays
    RESULT.csv/frames.csv, forces.csv               a row for each frame; one for each taxel of each frame
    RESULT.parquet/frames.parquet, forces.parquet   the same
"""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from tfra.model.tfra import Result
from tfra.recordings.frames import Recording
from tfra.runtime.errors import InputError
from tfra.runtime.extras import require
from tfra.runtime.outputs import check_archive, check_directory, output_directory, write_npz

KEYS = ("forces", "resultant", "phi_deg", "mu", "mu_x", "mu_y", "sweep_index", "status")
"""Keys of RESULT.npz that are fields of ``tfra.model.tfra.Result``."""

OPTIONAL = ("uncertainty", "residual")
"""Such keys that only some estimators have."""

_ROWS = 10_000  # of a CSV at a time

Columns = dict[str, npt.NDArray[Any]]
"""A table: one-dimensional arrays of the same length by their names."""


@dataclass(frozen=True, eq=False)
class Estimate:
    """Results of an engine for a recording, and the text of a CONFIG that makes the same design."""

    recording: Recording
    result: Result
    engine: str
    config: str

    def arrays(self) -> dict[str, npt.NDArray[Any]]:
        """Contents of RESULT.npz; ``stress`` is the input of the engine, before any conversion."""
        found = {key: np.asarray(getattr(self.result, key)) for key in KEYS}
        found["stress"] = np.ascontiguousarray(self.recording.frames)
        times = {} if self.recording.time is None else {"time": self.recording.time}
        found |= self._optional() | self._threshold() | times
        return found | {"engine": np.array(self.engine), "config": np.array(self.config)}

    def frames(self) -> Columns:
        """A row for each frame."""
        time, found = self.recording.time, self.result
        name = "time_s" if self.recording.seconds else "time"
        forces = dict(zip(("fx_n", "fy_n", "fz_n"), np.transpose(found.resultant), strict=True))
        return {
            "frame": np.arange(len(found.mu)),
            **({} if time is None else {name: time}),
            **{key: getattr(found, key) for key in ("phi_deg", "mu", "mu_x", "mu_y")},
            **forces,
            **{key: getattr(found, key) for key in ("sweep_index", "status")},
            **self._optional(),
        }

    def _threshold(self) -> Columns:
        threshold = self.result.threshold
        return {} if threshold is None else {"threshold": np.array(threshold)}

    def _optional(self) -> Columns:
        return {key: value for key in OPTIONAL if (value := getattr(self.result, key)) is not None}

    def forces(self) -> Columns:
        """A row for each taxel of each frame."""
        n, rows, columns = self.recording.frames.shape
        places = dict(zip(("frame", "row", "column"), np.indices((n, rows, columns)).reshape(3, -1), strict=True))
        axes = np.moveaxis(self.result.forces, 1, 0).reshape(3, -1)
        return places | dict(zip(("fx_n", "fy_n", "fz_n"), axes, strict=True))


def check_result(path: Path, command: str, inputs: Sequence[Path]) -> None:
    """Raise ``InputError`` now if ``write_result`` would, before a long computation."""
    if path.suffix == ".parquet":
        require(path, "tables", "polars")
    if path.suffix in (".csv", ".parquet"):
        check_directory(path, command, inputs)
    elif path.suffix == ".npz":
        check_archive(path, command, inputs)
    else:
        raise InputError(path, "", "the name of the output must end in .npz, .csv or .parquet")


def write_result(path: Path, found: Estimate, command: str, inputs: Sequence[Path]) -> None:
    """Write ``found`` to ``path``, in the format of its suffix; equal results give equal bytes.

    Raises ``InputError`` as ``write_npz`` and ``output_directory``.
    """
    if path.suffix == ".npz":
        write_npz(path, found.arrays(), command)
        return
    write = _write_csv if path.suffix == ".csv" else _write_parquet
    with output_directory(path, command, inputs) as folder:
        write(folder / f"frames{path.suffix}", found.frames())
        write(folder / f"forces{path.suffix}", found.forces())


def _write_csv(path: Path, table: Mapping[str, npt.NDArray[Any]]) -> None:
    """The shortest numbers that are read back as the same double."""
    with open(path, "x", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(table)
        for start in range(0, len(next(iter(table.values()))), _ROWS):
            parts = (column[start : start + _ROWS].tolist() for column in table.values())
            writer.writerows(zip(*parts, strict=True))


def _write_parquet(path: Path, table: Mapping[str, npt.NDArray[Any]]) -> None:
    import polars as pl

    pl.DataFrame(dict(table)).write_parquet(path, compression="zstd", statistics=False)
