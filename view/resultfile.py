"""Reads the inputs of a page: results of ``tfra estimate``, and frames with reference values."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from tfra.codegen.config.read import Project, load_tfra
from tfra.model.arrays import Bools, Floats, Ints
from tfra.model.fixed.design import Design
from tfra.model.sensor import SensorArray
from tfra.model.tfra import Result, Status
from tfra.recordings.arrays import Archive, NeededShape, archive, doubles, fits
from tfra.recordings.formats import FRAMES
from tfra.recordings.frames import REFERENCES, read_references
from tfra.recordings.results import OPTIONAL
from tfra.runtime.errors import InputError, shortened
from tfra.runtime.scratch import scratch, temporary

VALUES = {"resultant": (3,), "phi_deg": (), "mu": (), "mu_x": (), "mu_y": (), "sweep_index": (), "status": ()}
"""Values of a frame in a result, by key: their shapes."""

CONTEXT = ("stress", "engine", "config")
"""Keys that say where a result comes from; those of earlier versions have none."""

OLD = "the key is missing, an earlier version made this file: run tfra estimate again"

MOST_WHOLE = 2**53
"""Integers below are doubles."""

_BITS = sum(Status)


@dataclass(frozen=True)
class Recorded:
    """A result as ``tfra estimate`` wrote it.

    ``stress (n, rows, columns)`` is what its engine saw, in Pa, compression negative; ``time (n,)`` in seconds, where
    the recording has it.  ``swept``: CONFIG's estimator is TFRA, whose sweep is shown beside the result.  ``dead (rows,
    columns)``: taxels that neighbours stood in for; None: none.
    """

    name: str
    engine: str
    design: Design
    found: Result
    stress: Floats
    time: Floats | None
    swept: bool = True
    dead: Bools | None = None


@dataclass(frozen=True)
class References:
    """What is true of the frames, where it is known, else nan: ``values`` by key, as ``read_references`` has them."""

    name: str
    values: dict[str, Floats]


def read_all(paths: Sequence[Path]) -> tuple[list[Recorded], list[References]]:
    """Return the results and the references at ``paths``, all of one sensor and of as many frames.

    Raises ``InputError`` for a file that is neither, is given twice, has other frames than the first result, or none.
    """
    for path in paths:
        if paths.count(path) > 1:
            raise InputError("tfra view", "RESULT.npz", f"{path} is given twice")
    kinds = {path: _kind(path) for path in paths}
    results = [_result(path) for path, kind in kinds.items() if kind is Recorded]
    if not results:
        raise InputError(
            paths[0], "forces", "at least one result of tfra estimate is needed, got reference values alone"
        )
    first = results[0]
    for path, other in zip([path for path in paths if kinds[path] is Recorded], results, strict=True):
        if (sensor := other.design.sensor) != (needed := first.design.sensor):
            reason = f"is of another sensor ({describe(sensor)}) than {first.name} ({describe(needed)})"
            raise InputError(path, "config", reason)
        _require_as_many(path, len(other.stress), first)
    return results, [_references(path, first) for path, kind in kinds.items() if kind is References]


def require_results(paths: Sequence[Path]) -> None:
    """Raise ``InputError`` for a file that by its name is no result, as a recording."""
    for path in paths:
        if path.suffix != ".npz" and path.exists():
            reason = "a page shows results: tfra estimate CONFIG RECORDING --out RESULT.npz makes one of a recording"
            raise InputError(path, "", reason)


def _kind(path: Path) -> type[Recorded] | type[References]:
    with archive(path) as found:
        if "forces" in found.keys:
            return Recorded
        if FRAMES in found.keys and set(REFERENCES) & set(found.keys):
            return References
        if FRAMES in found.keys:
            raise InputError(path, "", f"frames without reference values: one of {', '.join(REFERENCES)} is needed")
        have = shortened(", ".join(found.keys), 120) or "none"
        raise InputError(path, "forces", f"is no result of tfra estimate: the key is missing, the file has: {have}")


def _require_as_many(path: Path, count: int, first: Recorded) -> None:
    if count != len(first.stress):
        raise InputError(path, "", f"has {count:,} frames, {first.name} has {len(first.stress):,}")


def describe(sensor: SensorArray) -> str:
    """The sensor as a phrase."""
    lengths = (f"{1e3 * length:.6g}" for length in (sensor.pitch_x, sensor.pitch_y, sensor.thickness))
    return "{}×{} taxels, {} × {} mm apart, under {} mm".format(sensor.rows, sensor.columns, *lengths)


def _result(path: Path) -> Recorded:
    with archive(path) as found:
        engine, project = source(found)
        design = project.design
        stress, time, dead = frames_of(found, design.sensor)
        result = windows(found, len(stress), design, _BITS)
    return Recorded(path.name, engine, design, result, stress, time, result.uncertainty is None, dead)


def source(found: Archive) -> tuple[str, Project]:
    """The engine of a result, and the project that its CONFIG describes, without weights."""
    for key in CONTEXT:
        if key not in found.keys:
            raise InputError(found.file, key, OLD)
    engine, config = (found.text(key) for key in ("engine", "config"))
    return engine, _project(found.file, config)


def frames_of(found: Archive, sensor: SensorArray) -> tuple[Floats, Floats | None, Bools | None]:
    """The stress of a result's frames, at least one, their times where they are known, and the dead taxels, if any."""
    stress = numbers(found, "stress", (None, sensor.rows, sensor.columns))
    if not len(stress):
        raise InputError(found.file, "stress", "at least one frame is needed, got none")
    shapes = {"time": (len(stress),), "dead": stress.shape[1:]}
    time, dead = (numbers(found, key, shape) if key in found.keys else None for key, shape in shapes.items())
    return stress, time, None if dead is None else dead != 0


def windows(found: Archive, count: int, design: Design, bits: int) -> Result:
    """The result of ``count`` frames that ``design`` saw; a status has some of ``bits``."""
    frame = design.sensor.rows, design.sensor.columns
    values: dict[str, Any] = {key: numbers(found, key, (count, *shape)) for key, shape in VALUES.items()}
    values |= {key: numbers(found, key, (count,)) for key in OPTIONAL if key in found.keys}
    learned = "uncertainty" in values
    values |= {"threshold": _threshold(found)} if learned else {}
    forces = numbers(found, "forces", (count, 3, *frame), may_lack=learned)  # a core may give the resultant alone
    values |= {key: whole(found, key, values[key]) for key in ("sweep_index", "status")}
    path = found.file
    _require_known(path, values["status"] & ~bits != 0, "status", "is no status")
    outside = (values["sweep_index"] < -1) | (values["sweep_index"] > design.search.steps)
    _require_known(path, outside, "sweep_index", f"is no candidate of {design.search.steps + 1}")
    return Result(forces, **values)


def _require_known(path: Path, wrong: npt.NDArray[np.bool_], key: str, reason: str) -> None:
    if wrong.any():
        raise InputError(path, key, f"frame {int(wrong.argmax())}: {reason}")


def _references(path: Path, first: Recorded) -> References:
    with archive(path) as found:
        frames = numbers(found, FRAMES, (None, *first.stress.shape[1:]))
    _require_as_many(path, len(frames), first)
    return References(path.name, read_references(path, len(frames)))


def _threshold(found: Archive) -> float:
    """The threshold of the uncertainty of a learned result; raises ``InputError`` for one that is none."""
    if "threshold" not in found.keys:
        raise InputError(found.file, "threshold", OLD)
    threshold = float(doubles(found.read("threshold", fits(()))))
    if not 0 < threshold < np.inf:
        raise InputError(found.file, "threshold", f"a positive number is needed, got {threshold:g}")
    return threshold


def numbers(found: Archive, key: str, needed: NeededShape, may_lack: bool = False) -> Floats:
    """The finite numbers of ``key``, whose shape is ``needed``; if they ``may_lack``, all are NaN.

    Raises ``InputError`` for others.
    """
    if key not in found.keys:
        raise InputError(found.file, key, "the key is missing")
    numbers = doubles(found.read(key, fits(needed)))
    bad = np.argwhere(~np.isfinite(numbers))
    if len(bad) and not (may_lack and np.isnan(numbers).all()):
        raise InputError(found.file, key, f"frame {bad[0][0]} has a value that is not finite")
    return numbers


def whole(found: Archive, key: str, values: Floats) -> Ints:
    """``values`` of ``key`` as integers; raises ``InputError`` where they are none."""
    if ((values % 1 != 0) | (np.abs(values) >= MOST_WHOLE)).any():
        raise InputError(found.file, key, "whole numbers are needed")
    return values.astype(np.int64)


def _project(path: Path, config: str) -> Project:
    """What a CONFIG describes, without weights; complaints name the result that it stands in."""
    with scratch(temporary()) as folder:
        file = folder / "sensor.toml"
        file.write_text(config, encoding="utf-8")
        try:
            return load_tfra(file)
        except InputError as error:
            raise InputError(path, "config", str(error).removeprefix(f"{file}: ")) from None
