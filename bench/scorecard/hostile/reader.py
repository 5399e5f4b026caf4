"""What a reader of bytes from outside is, and what all of them need."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from bench.scorecard.hostile.mutate import Draw, archived, changed_bytes, of, of_arrays
from tfra.codegen.config.read import load
from tfra.runtime.errors import InputError

CONFIG = """\
[sensor]
rows = 3
columns = 4
pitch_x_mm = 4
pitch_y_mm = 3
thickness_mm = 3
[architecture]
kind = "serial"
[[contact]]
shape = "hertz"
half_x_mm = 4
half_y_mm = 3
force_n = -4
mu = 0.5
phi_deg = { start = 0, stop = 360, step = 60 }
"""

Read = Callable[[bytes], object]
Prepared = tuple[Draw, Read]


class Wrong(Exception):
    """A reader returned what it must not."""


@dataclass(frozen=True)
class Reader:
    """``make`` prepares, in an empty folder, what is drawn and what reads it; ``count`` inputs in a full run.

    ``refusals`` are the exceptions that its docstring states.
    """

    make: Callable[[Path], Prepared]
    count: int
    refusals: tuple[type[Exception], ...] = (InputError,)


def of_file(file: Path, read: Callable[[Path], object]) -> Read:
    """A reader of bytes in a ``file`` that ``read`` takes."""

    def reading(data: bytes) -> object:
        file.write_bytes(data)
        return read(file)

    return reading


def configured(folder: Path, text: str = CONFIG) -> Any:
    """The project of a small CONFIG in ``folder``."""
    (folder / "sensor.toml").write_text(text)
    return load(folder / "sensor.toml")


def archives(stored: list[Any]) -> Draw:
    """Archives with changed arrays, and with changed bytes."""
    whole = of_arrays(stored)
    seeds = [archived(one) for one in stored]
    damaged = of(seeds, changed_bytes)
    return lambda rng: (damaged if rng.randrange(3) == 0 else whole)(rng)
