"""A calibration: what is known of one sensor, in a file of TOML beside CONFIG."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from tfra.model.arrays import Bools, Floats
from tfra.model.sensor import SensorArray
from tfra.recordings.input import Input, Order, Sign
from tfra.runtime.errors import InputError
from tfra.runtime.inputs import read_toml

MOST_GAIN = 100.0

SURE, SAME = 1.96, 0.03
"""A cover is another one if its thickness is off by more than so many standard deviations, and by this share."""

_PLAIN = ConfigDict(extra="forbid", strict=True, frozen=True, allow_inf_nan=False)

_Positive = Annotated[float, Field(gt=0)]
_Error = Annotated[float, Field(ge=0, le=MOST_GAIN)]


class Cover(BaseModel):
    """The elastic cover with standard deviations; lengths in mm."""

    model_config = _PLAIN

    thickness_mm: _Positive
    thickness_error_mm: _Positive
    poisson: Annotated[float, Field(gt=0, le=0.5)]
    poisson_error: _Positive

    def is_other(self, thickness_mm: float) -> bool:
        """Whether this is not the cover of a sensor with ``thickness_mm``."""
        most = max(SURE * self.thickness_error_mm, SAME * thickness_mm)
        return abs(self.thickness_mm - thickness_mm) > most


class File(BaseModel):
    """What the file holds: tables with a list for each row of taxels, and what else ``tfra calibrate`` has found."""

    model_config = _PLAIN

    form: Literal["tfra-calibration-1"]
    gain: list[list[Annotated[float, Field(ge=0, le=MOST_GAIN)]]] | None = None
    gain_error: list[list[_Error]] | None = None
    rest: list[list[float]] | None = None
    noise: list[list[_Error]] | None = None
    dead: list[Annotated[list[int], Field(min_length=2, max_length=2)]] = []
    order: Order | None = None
    flip_x: bool | None = None
    flip_y: bool | None = None
    compression: Sign | None = None
    cover: Cover | None = None


@dataclass(frozen=True, eq=False)
class Calibration:
    """``gain (rows, columns)``: stress of a taxel over that which its number says.

    ``rest (rows, columns)``: its number at rest, in the recording's unit, if it is known; ``dead (rows, columns)``.
    ``gain_error (rows, columns)``: standard deviation of the gain, relative; ``cover``; None where they are not known.
    """

    gain: Floats
    rest: Floats | None
    dead: Bools
    gain_error: Floats | None = None
    cover: Cover | None = None

    @classmethod
    def none(cls, sensor: SensorArray) -> "Calibration":
        """All taxels are alike and alive."""
        shape = (sensor.rows, sensor.columns)
        return cls(np.ones(shape), None, np.zeros(shape, dtype=np.bool_))


def read_calibration(path: Path, sensor: SensorArray, given: Input | None = None) -> Calibration:
    """The calibration at ``path``, of recordings read as ``given``, if that is said.

    Raises ``InputError`` that names the key of what does not fit ``sensor`` or ``given``.
    """
    try:
        found = File.model_validate(read_toml(path))
    except ValidationError as error:
        first: Any = error.errors()[0]
        raise InputError(path, ".".join(map(str, first["loc"])), str(first["msg"])) from None
    for key in ("order", "flip_x", "flip_y", "compression"):
        of, got = getattr(found, key), getattr(given, key, None)
        if None not in (of, got) and of != got:
            raise InputError(path, key, f"its tables are for {key} = {_toml(of)}, [input] has {_toml(got)}")
    shape = (sensor.rows, sensor.columns)
    tables = {
        key: None if (rows := getattr(found, key)) is None else _table(path, key, rows, shape)
        for key in ("gain", "gain_error", "rest")
    }
    try:
        dead = marked(tuple((row, column) for row, column in found.dead), shape)
    except ValueError as error:
        key, _, reason = str(error).partition(": ")
        raise InputError(path, key, reason) from None
    if dead.all():
        raise InputError(path, "dead", "at least one taxel has to be alive")
    gain = np.ones(shape) if tables["gain"] is None else tables["gain"]
    return Calibration(gain, tables["rest"], dead, tables["gain_error"], found.cover)


def written(found: File) -> str:
    """The text of the file."""
    lines = []
    for key, value in found.model_dump(exclude_none=True, exclude={"cover"}).items():
        if isinstance(value, list) and value and isinstance(value[0], list):
            lines += [f"{key} = [", *(f"    {_toml(row)}," for row in value), "]"]
        else:
            lines.append(f"{key} = {_toml(value)}")
    if found.cover:
        lines += ["", "[cover]", *(f"{key} = {_toml(value)}" for key, value in found.cover.model_dump().items())]
    return "\n".join(lines) + "\n"


def _toml(value: object) -> str:
    """A value as TOML: numbers are the shortest that are read as the same."""
    if isinstance(value, list):
        return f"[{', '.join(map(_toml, value))}]"
    if isinstance(value, bool):
        return str(value).lower()
    return f'"{value}"' if isinstance(value, str) else repr(value)


def _table(path: Path, key: str, rows: list[list[float]], shape: tuple[int, int]) -> Floats:
    if len(rows) != shape[0] or any(len(row) != shape[1] for row in rows):
        raise InputError(path, key, f"{shape[0]} lists of {shape[1]} numbers are needed, one for each row of taxels")
    return np.array(rows, dtype=np.float64)


def marked(places: tuple[tuple[int, int], ...], shape: tuple[int, int]) -> Bools:
    """An array that is true at ``places``; raises ``ValueError`` for one beyond ``shape``."""
    dead = np.zeros(shape, dtype=np.bool_)
    for row, column in places:
        if not (0 <= row < shape[0] and 0 <= column < shape[1]):
            raise ValueError(f"dead: row {row}, column {column} is no taxel of {shape[0]} x {shape[1]}, from 0")
        dead[row, column] = True
    return dead
