"""Writing the results of ``tfra estimate``: an archive, or a folder of tables.

    RESULT.npz                                      arrays
    RESULT.csv/frames.csv, forces.csv               a row for each frame; one for each taxel of each frame
    RESULT.parquet/frames.parquet, forces.parquet   the same
    RESULT.mcap/forces.mcap                         a message for each frame

The forces of a skin are those of the taxels in the windows of contacts, contacts.csv has a row for each contact, and
contacts.mcap is in the place of forces.mcap.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from tfra.model.skin.finding import Mark
from tfra.model.skin.result import SkinResult
from tfra.model.tfra import Result, Status
from tfra.recordings.formats import Columns, table_formats
from tfra.recordings.frames import Recording
from tfra.recordings.messages import CONTACTS, FORCES, LATEST, write_messages
from tfra.runtime.errors import InputError, require
from tfra.runtime.outputs import check_directory, check_file, output_directory, write_npz

KEYS = ("forces", "resultant", "phi_deg", "mu", "mu_x", "mu_y", "sweep_index", "status")
"""Keys of RESULT.npz that are fields of ``tfra.model.tfra.Result``."""

OPTIONAL = ("uncertainty", "residual")
"""Such keys that only some estimators have."""

MESSAGES = ".mcap"
"""The end of the name of a folder with messages."""

Messages = tuple[str, dict[str, Any], Iterator[dict[str, Any]]]
"""The name of their file, their schema, and messages, one for each frame; times are those of the recording."""

_FORCES = ("fx_n", "fy_n", "fz_n")
"""Columns of a force, in N."""

_PLACE = ("frame", "row", "column")


@dataclass(frozen=True, eq=False)
class Estimate:
    """Results of an engine for a recording, and the text of a CONFIG that makes the same design."""

    recording: Recording
    result: Result
    engine: str
    config: str

    def arrays(self) -> dict[str, npt.NDArray[Any]]:
        """Contents of RESULT.npz; ``stress`` is the input of the engine, before any conversion."""
        return {**_arrays(self.result), **_source(self)}

    def tables(self) -> dict[str, Columns]:
        """Tables by their names: a row for each frame, and one for each taxel of each frame."""
        n, rows, columns = self.recording.frames.shape
        taxels = np.indices((n, rows, columns)).reshape(3, -1)
        forces = {**dict(zip(_PLACE, taxels, strict=True)), **_forces(self.result)}
        return {"frames": self.frames(), "forces": forces}

    def messages(self) -> Messages:
        """A message for each frame."""
        return "forces", FORCES, self._messages()

    def _messages(self) -> Iterator[dict[str, Any]]:
        alone = self.result.resultant_alone
        for frame, (force, taxels) in enumerate(zip(_force_parts(self.result), self.result.forces, strict=True)):
            planes = {} if alone else {"taxels_n": dict(zip("xyz", taxels.tolist(), strict=True))}
            yield {"frame": frame, **force, **planes}

    def frames(self) -> Columns:
        """The table with a row for each frame."""
        return {"frame": np.arange(len(self.result.mu)), **_time(self.recording), **_columns(self.result)}


@dataclass(frozen=True, eq=False)
class SkinEstimate:
    """The same for a skin: the arrays of an ``Estimate`` have a row for each contact."""

    recording: Recording
    result: SkinResult
    engine: str
    config: str

    def arrays(self) -> dict[str, npt.NDArray[Any]]:
        """Contents of RESULT.npz."""
        counts = {"found": self.result.found, "dropped": self.result.dropped}
        return {**self._contacts(), **_arrays(self.result.windows), **counts, **_source(self)}

    def tables(self) -> dict[str, Columns]:
        """Tables by their names: a row for each contact, for each frame, and for each taxel of a contact's window."""
        found, recording = self.result, self.recording
        _, rows, columns = recording.frames.shape
        k, _, height, width = found.windows.forces.shape
        which, row, column = np.indices((k, height, width)).reshape(3, -1)
        place = found.frame[which], found.contact[which], row + found.top[which], column + found.left[which]
        there = (place[2] >= 0) & (place[2] < rows) & (place[3] >= 0) & (place[3] < columns)
        places = dict(zip(("frame", "contact", "row", "column"), place, strict=True))
        return {
            "contacts": {**self._contacts(), **_columns(found.windows)},
            "frames": {
                "frame": np.arange(len(found.found)),
                **_time(recording),
                "found": found.found,
                "dropped": found.dropped,
            },
            "forces": {key: values[there] for key, values in {**places, **_forces(found.windows)}.items()},
        }

    def messages(self) -> Messages:
        """A message for each frame."""
        return "contacts", CONTACTS, self._messages()

    def _messages(self) -> Iterator[dict[str, Any]]:
        found = self.result
        columns = (found.tracks(), 1e3 * found.x, 1e3 * found.y, found.taxels)
        places = zip(*(column.tolist() for column in columns), strict=True)
        contacts = [
            {**dict(zip(("track", "x_mm", "y_mm", "taxels"), place, strict=True)), **force}
            for place, force in zip(places, _force_parts(found.windows), strict=True)
        ]
        ends, counts = np.cumsum(found.found).tolist(), (found.found.tolist(), found.dropped.tolist())
        for frame, (end, count, dropped) in enumerate(zip(ends, *counts, strict=True)):
            yield {"frame": frame, "dropped": dropped, "contacts": contacts[end - count : end]}

    def _contacts(self) -> Columns:
        found = self.result
        places = {"x_mm": 1e3 * found.x, "y_mm": 1e3 * found.y}
        return {
            **{key: getattr(found, key) for key in ("frame", "contact")},
            "track": found.tracks(),
            **places,
            **{key: getattr(found, key) for key in ("taxels", "top", "left")},
        }


def _force_parts(result: Result) -> Iterator[dict[str, Any]]:
    """What messages say of each force."""
    unsure = np.full(len(result.mu), np.nan) if result.uncertainty is None else result.uncertainty
    names = [(int(flag), str(flag.name)) for flag in (*Mark, *Status)]
    columns = (result.resultant, result.mu, result.phi_deg, unsure, result.status)
    for force, mu, phi, doubt, status in zip(*(values.tolist() for values in columns), strict=True):
        yield {
            "force_n": {axis: _known(part) for axis, part in zip("xyz", force, strict=True)},
            "mu": _known(mu),
            "phi_deg": _known(phi),
            "uncertainty_n": _known(doubt),
            "status": [name for bit, name in names if status & bit],
        }


def _known(value: float) -> float | None:
    """``value`` for JSON, which has no NaN."""
    return value if np.isfinite(value) else None


def _arrays(result: Result) -> dict[str, npt.NDArray[Any]]:
    """The keys of ``result`` in an archive."""
    threshold = {} if result.threshold is None else {"threshold": np.array(result.threshold)}
    return {**{key: np.asarray(getattr(result, key)) for key in KEYS}, **_optional(result), **threshold}


def _source(of: Estimate | SkinEstimate) -> dict[str, npt.NDArray[Any]]:
    """What a result was made of."""
    time, dead = of.recording.time, of.recording.dead
    return {
        "stress": np.ascontiguousarray(of.recording.frames),
        **({} if time is None else {"time": time}),
        **({} if dead is None else {"dead": dead.astype(np.uint8)}),
        "engine": np.array(of.engine),
        "config": np.array(of.config),
    }


def _time(recording: Recording) -> Columns:
    return {} if recording.time is None else {"time_s" if recording.seconds else "time": recording.time}


def _seconds(recording: Recording) -> list[float]:
    """Times of messages: those of the frames, or their numbers where there are none that MCAP can hold."""
    time = recording.time
    known = time is not None and time.min() >= 0 and time.max() < LATEST
    return [float(second) for second in (time if time is not None and known else np.arange(len(recording)))]


def _columns(result: Result) -> Columns:
    """Columns of a table with a row for each frame, or window."""
    return {
        **{key: getattr(result, key) for key in ("phi_deg", "mu", "mu_x", "mu_y")},
        **dict(zip(_FORCES, np.transpose(result.resultant), strict=True)),
        **{key: getattr(result, key) for key in ("sweep_index", "status")},
        **_optional(result),
    }


def _optional(result: Result) -> Columns:
    return {key: value for key in OPTIONAL if (value := getattr(result, key)) is not None}


def _forces(result: Result) -> Columns:
    """Forces at all taxels."""
    return dict(zip(_FORCES, np.moveaxis(result.forces, 1, 0).reshape(3, -1), strict=True))


def check_result(path: Path, command: str, inputs: Sequence[Path]) -> None:
    """Raise ``InputError`` now if ``write_result`` would, before a long computation."""
    if path.suffix == ".npz":
        check_file(path, ".npz", command, inputs)
        return
    if path.suffix == MESSAGES:
        require(path, "robot", "mcap")
        check_directory(path, command, inputs)
        return
    tables = table_formats()
    if path.suffix not in tables:
        names = ", ".join((".npz", *tables))
        raise InputError(path, "", f"the name of the output must end in {names} or {MESSAGES}")
    if needs := tables[path.suffix].needs:
        require(path, *needs)
    check_directory(path, command, inputs)


def write_result(path: Path, estimate: Estimate | SkinEstimate, command: str, inputs: Sequence[Path]) -> None:
    """Write ``estimate`` to ``path``, in the format of its suffix; equal results give equal bytes.

    Raises ``InputError`` as ``write_npz`` and ``output_directory``.
    """
    if path.suffix == ".npz":
        write_npz(path, estimate.arrays(), command)
        return
    if path.suffix == MESSAGES:
        name, described, messages = estimate.messages()
        with output_directory(path, command, inputs) as folder:
            write_messages(folder / f"{name}{MESSAGES}", described, messages, _seconds(estimate.recording))
        return
    write_table = table_formats()[path.suffix].write_table
    assert write_table
    with output_directory(path, command, inputs) as folder:
        for name, table in estimate.tables().items():
            write_table(folder / f"{name}{path.suffix}", table)
