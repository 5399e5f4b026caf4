"""Writing the results of ``tfra estimate``: an archive, or a folder of tables.

    RESULT.npz                                      arrays
    RESULT.csv/frames.csv, forces.csv               a row for each frame; one for each taxel of each frame
    RESULT.parquet/frames.parquet, forces.parquet   the same
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from tfra.model.tfra import Result
from tfra.recordings.formats import Columns, table_formats
from tfra.recordings.frames import Recording
from tfra.runtime.errors import InputError, require
from tfra.runtime.outputs import check_directory, check_file, output_directory, write_npz

KEYS = ("forces", "resultant", "phi_deg", "mu", "mu_x", "mu_y", "sweep_index", "status")
"""Keys of RESULT.npz that are fields of ``tfra.model.tfra.Result``."""

OPTIONAL = ("uncertainty", "residual")
"""Such keys that only some estimators have."""

_FORCES = ("fx_n", "fy_n", "fz_n")
"""Columns of a force, in N."""


@dataclass(frozen=True, eq=False)
class Estimate:
    """Results of an engine for a recording, and the text of a CONFIG that makes the same design."""

    recording: Recording
    result: Result
    engine: str
    config: str

    def arrays(self) -> dict[str, npt.NDArray[Any]]:
        """Contents of RESULT.npz; ``stress`` is the input of the engine, before any conversion."""
        threshold, time = self.result.threshold, self.recording.time
        return {
            **{key: np.asarray(getattr(self.result, key)) for key in KEYS},
            "stress": np.ascontiguousarray(self.recording.frames),
            **self._optional(),
            **({} if threshold is None else {"threshold": np.array(threshold)}),
            **({} if time is None else {"time": time}),
            "engine": np.array(self.engine),
            "config": np.array(self.config),
        }

    def frames(self) -> Columns:
        """A row for each frame."""
        time, result = self.recording.time, self.result
        name = "time_s" if self.recording.seconds else "time"
        return {
            "frame": np.arange(len(result.mu)),
            **({} if time is None else {name: time}),
            **{key: getattr(result, key) for key in ("phi_deg", "mu", "mu_x", "mu_y")},
            **dict(zip(_FORCES, np.transpose(result.resultant), strict=True)),
            **{key: getattr(result, key) for key in ("sweep_index", "status")},
            **self._optional(),
        }

    def _optional(self) -> Columns:
        return {key: value for key in OPTIONAL if (value := getattr(self.result, key)) is not None}

    def forces(self) -> Columns:
        """A row for each taxel of each frame."""
        n, rows, columns = self.recording.frames.shape
        taxels = np.indices((n, rows, columns)).reshape(3, -1)
        forces = np.moveaxis(self.result.forces, 1, 0).reshape(3, -1)
        return dict(zip(("frame", "row", "column", *_FORCES), (*taxels, *forces), strict=True))


def check_result(path: Path, command: str, inputs: Sequence[Path]) -> None:
    """Raise ``InputError`` now if ``write_result`` would, before a long computation."""
    if path.suffix == ".npz":
        check_file(path, ".npz", command, inputs)
        return
    tables = table_formats()
    if path.suffix not in tables:
        *names, last = ".npz", *tables
        raise InputError(path, "", f"the name of the output must end in {', '.join(names)} or {last}")
    if needs := tables[path.suffix].needs:
        require(path, *needs)
    check_directory(path, command, inputs)


def write_result(path: Path, estimate: Estimate, command: str, inputs: Sequence[Path]) -> None:
    """Write ``estimate`` to ``path``, in the format of its suffix; equal results give equal bytes.

    Raises ``InputError`` as ``write_npz`` and ``output_directory``.
    """
    if path.suffix == ".npz":
        write_npz(path, estimate.arrays(), command)
        return
    write_table = table_formats()[path.suffix].write_table
    assert write_table
    with output_directory(path, command, inputs) as folder:
        write_table(folder / f"frames{path.suffix}", estimate.frames())
        write_table(folder / f"forces{path.suffix}", estimate.forces())
