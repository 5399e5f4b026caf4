"""The table of loads: what was done to the array in each recording, a row each, in a text file with a header."""

import csv
import difflib
import io
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationError

from tfra.calibrate.response import Indenter
from tfra.runtime.errors import InputError, quoted
from tfra.runtime.inputs import opened

MOST_BYTES = 1_000_000

STEEPEST = 2.0
"""Largest tangential force over the normal one: no finger or rubber holds more."""

_SEPARATORS = (";", "\t", ",")

_Number = Annotated[float, Field(allow_inf_nan=False, ge=-1e6, le=1e6)]
_Length = Annotated[float, Field(allow_inf_nan=False, gt=0, le=1e4)]
_Force = Annotated[float, Field(allow_inf_nan=False, gt=0, le=1e5)]


def _lower(value: Any) -> Any:
    return value.lower() if isinstance(value, str) else value


class _Row(BaseModel):
    """The cells of a row as they are written."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    recording: str
    force_n: _Force | None = None
    tangential_n: Annotated[float, Field(allow_inf_nan=False, ge=0, le=1e5)] | None = None
    direction_deg: Annotated[float, Field(ge=-360, le=360)] | None = None
    tilt_deg: Annotated[float, Field(ge=0, lt=90)] | None = None
    pressure_kpa: _Force | None = None
    indenter: Annotated[Indenter, BeforeValidator(_lower)] = Indenter.BALL
    radius_mm: _Length | None = None
    x_mm: _Number | None = None
    y_mm: _Number | None = None
    frames: Annotated[str, Field(pattern=r"^\d{1,9}-\d{1,9}$")] | None = None
    branch: Annotated[Literal["loading", "unloading"], BeforeValidator(_lower)] = "loading"
    error_percent: Annotated[float, Field(gt=0, le=50)] = 0.5


@dataclass(frozen=True)
class Load:
    """What was done in the recording of that name.

    ``normal`` and ``tangential``: forces on the array, N, > 0 and >= 0; ``direction`` of the latter on the array, rad
    from x, if it is known; ``pressure`` on all taxels, Pa.  None of both forces and pressure: the array was at rest.
    ``radius`` of the indenter and ``place`` on the array, origin in the first taxel, m.  ``frames``: the first and the
    last one under the load; None: they are found.  ``error``, relative, of forces and pressure.  ``line`` of the table.
    """

    recording: str
    line: int
    normal: float = 0.0
    tangential: float = 0.0
    direction: float | None = None
    pressure: float = 0.0
    indenter: Indenter = Indenter.BALL
    radius: float | None = None
    place: tuple[float, float] | None = None
    frames: tuple[int, int] | None = None
    unloading: bool = False
    error: float = 0.005

    @property
    def at_rest(self) -> bool:
        """Whether nothing touched the array."""
        return not self.normal and not self.pressure


def read_loads(file: Path) -> tuple[Load, ...]:
    """The loads in ``file``, in its order; raises ``InputError`` naming line and column of what is wrong.

    Cells are separated by semicolons, tabs or commas; between the former, numbers may have decimal commas.
    """
    with opened(file) as stream:
        data = stream.read(MOST_BYTES + 1)
    if len(data) > MOST_BYTES:
        raise InputError(file, "", f"a table of loads has at most {MOST_BYTES:,} bytes")
    try:
        lines = data.decode("utf-8-sig").splitlines()
    except UnicodeDecodeError:
        raise InputError(file, "", "is not UTF-8 text") from None
    texts = [(number, line) for number, line in enumerate(lines, 1) if line.strip() and not line.startswith("#")]
    if not texts:
        raise InputError(file, "", f"is empty: a header is needed, {', '.join(_Row.model_fields)}, and a row a load")
    separator = next((each for each in _SEPARATORS if each in texts[0][1]), ",")
    names = [name.strip().lower() for name in _cells(texts[0][1], separator)]
    _check_header(file, texts[0][0], names)
    loads = tuple(_load(file, number, names, _cells(line, separator), separator) for number, line in texts[1:])
    if not loads:
        raise InputError(file, "", "has no loads below its header")
    return loads


def _cells(line: str, separator: str) -> list[str]:
    """The cells of a line; one if it has too long a cell."""
    try:
        (cells,) = csv.reader(io.StringIO(line), delimiter=separator, skipinitialspace=True)
    except csv.Error:
        return [line]
    return cells


def _check_header(file: Path, line: int, names: list[str]) -> None:
    known = list(_Row.model_fields)
    for name in names:
        if name not in known:
            nearest = difflib.get_close_matches(name[:60], known, n=1, cutoff=0)[0]
            reason = f'unknown column {quoted(name)}, the nearest valid one is "{nearest}"'
            raise InputError(file, f"line {line}", reason)
    if len(set(names)) < len(names):
        raise InputError(file, f"line {line}", "a column is there twice")
    if "recording" not in names:
        raise InputError(file, f"line {line}", 'a column "recording" with the names of the files is needed')


def _load(file: Path, line: int, names: list[str], cells: list[str], separator: str) -> Load:
    if len(cells) != len(names):
        raise InputError(file, f"line {line}", f"{len(names)} cells are needed as in the header, got {len(cells)}")
    given = {name: cell.strip() for name, cell in zip(names, cells, strict=True) if cell.strip()}
    if separator == ";":
        given = {name: cell if name == "recording" else cell.replace(",", ".") for name, cell in given.items()}
    try:
        return _checked(_Row.model_validate(given), line)
    except ValidationError as error:
        first: Any = error.errors()[0]
        key = str(first["loc"][0])
        reason = _reason(key, first, given)
    except ValueError as error:
        key, _, reason = str(error).partition(": ")
    raise InputError(file, f"line {line}: {key}", reason)


def _reason(key: str, error: Mapping[str, Any], given: Mapping[str, str]) -> str:
    """What is wrong with a cell, in our words."""
    if error["type"] == "missing":
        return "is needed"
    if key == "force_n" and given[key].startswith("-"):
        return f"a force into the array is positive here, got {given[key]}"
    if error["type"] == "string_pattern_mismatch":
        return f"the first and the last frame are needed, as 120-180, got {quoted(given[key])}"
    message = str(error["msg"]).removeprefix("Input should be ")
    return f"{message} is needed, got {quoted(given[key])}"


def _checked(row: _Row, line: int) -> Load:
    """The row as a load in SI units; raises ``ValueError`` that starts with the column that contradicts another."""
    normal, tangential = row.force_n or 0.0, row.tangential_n or 0.0
    if row.pressure_kpa and row.force_n:
        raise ValueError("pressure_kpa: and force_n exclude each other")
    if not row.force_n and (tangential or row.tilt_deg):
        raise ValueError("force_n: is needed with a tangential force or a tilt")
    if row.tilt_deg is not None:
        if row.tangential_n is not None:
            raise ValueError("tilt_deg: and tangential_n exclude each other")
        tilt = math.radians(row.tilt_deg)
        normal, tangential = normal * math.cos(tilt), normal * math.sin(tilt)
    if tangential > STEEPEST * normal:
        raise ValueError(f"tangential_n: {tangential:g} beside {normal:g} N is no friction: is it an angle? (tilt_deg)")
    if (row.x_mm is None) != (row.y_mm is None):
        raise ValueError("x_mm: a place needs x_mm and y_mm")
    if row.indenter is Indenter.FLAT and row.radius_mm is None:
        raise ValueError("radius_mm: is needed of a flat punch")
    frames = None if row.frames is None else tuple(map(int, row.frames.split("-")))
    if frames and frames[0] > frames[1]:
        raise ValueError(f"frames: the first is after the last, got {row.frames}")
    return Load(
        recording=row.recording,
        line=line,
        normal=normal,
        tangential=tangential,
        direction=None if row.direction_deg is None else math.radians(row.direction_deg),
        pressure=1e3 * (row.pressure_kpa or 0.0),
        indenter=row.indenter,
        radius=None if row.radius_mm is None else row.radius_mm / 1e3,
        place=None if row.x_mm is None or row.y_mm is None else (row.x_mm / 1e3, row.y_mm / 1e3),
        frames=None if frames is None else (frames[0], frames[1]),
        unloading=row.branch == "unloading",
        error=row.error_percent / 100,
    )
