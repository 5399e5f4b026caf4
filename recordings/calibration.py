"""A calibration: what is known of each taxel of one sensor, in a file of TOML beside CONFIG."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from tfra.model.arrays import Bools, Floats
from tfra.model.sensor import SensorArray
from tfra.runtime.errors import InputError
from tfra.runtime.inputs import read_toml

MOST_GAIN = 100.0


class File(BaseModel):
    """What the file holds: tables with a list for each row of taxels."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True, allow_inf_nan=False)

    form: Literal["tfra-calibration-1"]
    gain: list[list[Annotated[float, Field(ge=0, le=MOST_GAIN)]]] | None = None
    rest: list[list[float]] | None = None
    dead: list[Annotated[list[int], Field(min_length=2, max_length=2)]] = []


@dataclass(frozen=True, eq=False)
class Calibration:
    """``gain (rows, columns)``: stress of a taxel over that which its number says.

    ``rest (rows, columns)``: its number at rest, in the recording's unit, if it is known; ``dead (rows, columns)``.
    """

    gain: Floats
    rest: Floats | None
    dead: Bools

    @classmethod
    def none(cls, sensor: SensorArray) -> "Calibration":
        """All taxels are alike and alive."""
        shape = (sensor.rows, sensor.columns)
        return cls(np.ones(shape), None, np.zeros(shape, dtype=np.bool_))


def read_calibration(path: Path, sensor: SensorArray) -> Calibration:
    """The calibration at ``path``; raises ``InputError`` that names the key of what does not fit ``sensor``."""
    try:
        found = File.model_validate(read_toml(path))
    except ValidationError as error:
        first: Any = error.errors()[0]
        raise InputError(path, ".".join(map(str, first["loc"])), str(first["msg"])) from None
    shape = (sensor.rows, sensor.columns)
    gain = np.ones(shape) if found.gain is None else _table(path, "gain", found.gain, shape)
    rest = None if found.rest is None else _table(path, "rest", found.rest, shape)
    try:
        dead = marked(tuple((row, column) for row, column in found.dead), shape)
    except ValueError as error:
        key, _, reason = str(error).partition(": ")
        raise InputError(path, key, reason) from None
    return Calibration(gain, rest, dead)


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
