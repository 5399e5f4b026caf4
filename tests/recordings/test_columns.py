"""Text as laboratories write it: columns by name and place, lines before a header, quotes, a few wrong lines."""

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tfra.model.choices import Adc
from tfra.model.sensor import SensorArray
from tfra.recordings.columns import guessed
from tfra.recordings.frames import Recording, read_recording
from tfra.recordings.input import PLAIN, Input, overridden
from tfra.recordings.lines import FrameLines
from tfra.runtime.errors import InputError

SENSOR = SensorArray(3, 2, 4e-3, 4e-3, 3e-3)
ADC = Adc(12, 1e6)
FRAMES = np.round(np.random.default_rng(0).uniform(-1e5, 1e5, (200, 3, 2)), 1)
TIMES = np.round(0.01 * np.arange(200), 2)
NAMES = [f"T_{row}_{column}" for row in range(3) for column in range(2)]


def text(order: list[int], *, names: list[str] | None = None, extra: bool = True) -> str:
    """A line for each frame: time, taxels in an ``order``, and a temperature if it is ``extra``."""
    head = ["t", *(names[place] for place in order), *(["temperature"] if extra else [])] if names else []
    rows = [
        [time, *frame.ravel()[order], *([21.5] if extra else [])] for time, frame in zip(TIMES, FRAMES, strict=True)
    ]
    return "\n".join(",".join(map(str, row)) for row in ([head] if head else []) + rows) + "\n"


def read(tmp_path: Path, content: str | bytes, given: Input = PLAIN) -> Recording:
    data = content if isinstance(content, bytes) else content.encode()
    (tmp_path / "log.csv").write_bytes(data)
    return read_recording(tmp_path / "log.csv", SENSOR, ADC, given)


def refusal(tmp_path: Path, content: str | bytes, given: Input = PLAIN) -> str:
    with pytest.raises(InputError) as told:
        read(tmp_path, content, given)
    return str(told.value).removeprefix(f"{tmp_path / 'log.csv'}: ")


def obeyed(hint: str, given: Input = PLAIN) -> list[Input]:
    """What each option of a message makes of ``given``."""
    options = re.findall(r"--(skip-columns|columns) ([^)]+)\)", hint)
    values: list[dict[str, Any]] = [
        {"columns": value, "skip_columns": 0} if name == "columns" else {"skip_columns": int(value)}
        for name, value in options
    ]
    return [overridden(given, each) for each in values]


@pytest.mark.parametrize("order", [[0, 1, 2, 3, 4, 5], [0, 2, 4, 1, 3, 5], [5, 3, 0, 1, 4, 2]])
@pytest.mark.parametrize("first", [0, 1])
def test_columns_by_their_names(tmp_path: Path, order: list[int], first: int) -> None:
    """In any order, among others, counted from 0 or 1; the time is the first of the others."""
    names = [f"T_{row + first}_{column + first}" for row in range(3) for column in range(2)]
    found = read(tmp_path, text(order, names=names), Input(columns="T_{row}_{column}"))
    assert (found.frames == FRAMES).all()
    assert found.time is not None
    assert (found.time == TIMES).all()
    names = [f"p{taxel + first}" for taxel in range(6)]
    assert (read(tmp_path, text(order, names=names), Input(columns="p{taxel}")).frames == FRAMES).all()


@pytest.mark.parametrize("given", [PLAIN, Input(skip_columns=1)])
def test_a_hint_that_is_obeyed_is_right(tmp_path: Path, given: Input) -> None:
    """Other columns first and last: the header's names; without names, both ends are named, and one is right."""
    hint = refusal(tmp_path, text([0, 2, 4, 1, 3, 5], names=NAMES), given)
    (better,) = obeyed(hint, given)
    assert (read(tmp_path, text([0, 2, 4, 1, 3, 5], names=NAMES), better).frames == FRAMES).all()
    for order in ([0, 2, 4, 1, 3, 5], [0, 1, 2, 3, 4, 5]):  # no column but the time, which the shorter option skips
        timed = text(order, names=NAMES, extra=False)
        (only,) = obeyed(refusal(tmp_path, timed))
        assert (only.skip_columns == 1) == (order[1] == 1)
        assert (read(tmp_path, timed, only).frames == FRAMES).all()
    nameless = text([0, 1, 2, 3, 4, 5])
    choices = obeyed(refusal(tmp_path, nameless, given), given)
    assert len(choices) == 2
    assert any((read(tmp_path, nameless, each).frames == FRAMES).all() for each in choices) == (given != PLAIN)


def test_an_order_that_the_names_contradict_is_told(tmp_path: Path) -> None:
    columns_first = text([0, 2, 4, 1, 3, 5], names=NAMES, extra=False)
    (doubt,) = read(tmp_path, columns_first, Input(skip_columns=1)).doubts or ()
    assert "another order than row by row" in doubt
    (better,) = obeyed(doubt)
    assert (read(tmp_path, columns_first, better).frames == FRAMES).all()
    rows_first = text([0, 1, 2, 3, 4, 5], names=NAMES, extra=False)
    assert read(tmp_path, rows_first, Input(skip_columns=1)).doubts == ()


FRAMES_IN_TIME = list(zip(TIMES, FRAMES, strict=True))
GERMAN = "\n".join(
    [
        "sep=;",
        "Messgerät: 12;Rate 100 Hz",
        '"Zeit";"a1";"a2";"a3";"a4";"a5";"a6"',
        "s;kPa;kPa;kPa;kPa;kPa;µN",
        *(";".join(f'"{number}"'.replace(".", ",") for number in [t, *f.ravel()]) for t, f in FRAMES_IN_TIME),
    ]
)


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "latin-1"])
def test_lines_of_a_logger(tmp_path: Path, encoding: str) -> None:
    found = read(tmp_path, GERMAN.encode(encoding), Input(skip_columns=1))
    assert (found.frames == FRAMES).all()
    assert found.doubts == ()


def test_a_few_lines_may_be_wrong(tmp_path: Path) -> None:
    lines = text([0, 1, 2, 3, 4, 5], extra=False).splitlines()
    cut = "\n".join([*lines[:-1], lines[-1][:20]])
    found = read(tmp_path, cut, Input(skip_columns=1))
    assert (found.frames == FRAMES[:-1]).all()
    (doubt,) = found.doubts or ()
    assert doubt.startswith("1 of 200 lines are no frames and left out (--strict refuses them): line 200: 6 numbers")
    assert refusal(tmp_path, cut, Input(skip_columns=1, strict=True)).startswith("line 200: 6 numbers")
    words = "\n".join([*lines[:50], "overrun", *lines[50:100], "overrun", *lines[100:150], "overrun", *lines[150:]])
    assert refusal(tmp_path, words, Input(skip_columns=1)).startswith("line 51: ")


def test_wrong_columns(tmp_path: Path) -> None:
    named = text([0, 1, 2, 3, 4, 5], names=NAMES)
    for columns, reason in {
        "2-8": "input.columns: 6 columns are needed, 2-8 are 7",
        "0-5": "input.columns: 6 columns are needed, 0-5 are 6",
        "all": "input.columns: FIRST-LAST from 1, or names",
        "P_{row}_{column}": "no line names 6 taxels as 'P_{row}_{column}' (--columns)",
    }.items():
        assert refusal(tmp_path, named, Input(columns=columns)).startswith(reason)
    with pytest.raises(ValueError, match="columns: and skip_columns exclude"):
        overridden(PLAIN, {"columns": "2-7", "skip_columns": 1})
    np.save(tmp_path / "f.npy", FRAMES)
    with pytest.raises(InputError, match=r"input.columns: are of text"):
        read_recording(tmp_path / "f.npy", SENSOR, ADC, Input(columns="1-6"))


def test_lines_that_come_one_by_one() -> None:
    """A header of names, then frames."""
    for given in (Input(columns="T_{row}_{column}"), Input(columns="2-7")):
        content = text([0, 1, 2, 3, 4, 5], names=NAMES if given.columns != "2-7" else None)
        numbered = enumerate((line.encode() for line in content.splitlines()), 1)
        frames = list(FrameLines(SENSOR, ADC, given).frames(numbered, lambda _: None))
        assert all(isinstance(frame, np.ndarray) for frame in frames)
        assert (np.array(frames) == FRAMES).all()


def test_a_name_of_many_digits_is_looked_at_no_further() -> None:
    """All ways to part it would take days."""
    assert guessed(["1" * 200_000, "a" * 200_000], SENSOR) is None
