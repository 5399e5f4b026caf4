"""Frames from lines as they come are those of a file of the same lines; those of a recording come when they are due."""

import time
import warnings
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

import tfra.recordings.intake as module
from tfra.model.arrays import Floats
from tfra.model.choices import Adc
from tfra.model.sensor import SensorArray
from tfra.recordings.frames import Recording, read_recording
from tfra.recordings.input import PLAIN, Input
from tfra.recordings.lines import FrameLines, due, replayed
from tfra.runtime.errors import InputError

SENSOR, ADC = SensorArray(2, 3, 4e-3, 4e-3, 3e-3), Adc(bits=12)

TAXELS = np.array([[1.5, -2.25, 3, 4, 5, 6], [7, 8, 9.5, -10, 11, 12], [0, 1, 2, 3, 4, 6]])


def lines(text: str) -> Iterator[tuple[int, bytes]]:
    return enumerate(text.encode().split(b"\n"), 1)


def read(text: str, given: Input = PLAIN) -> list[Floats | str]:
    return list(FrameLines(SENSOR, ADC, given).frames(lines(text), lambda frame: None))


def text_of(separator: str = ",", before: str = "", values: Floats = TAXELS) -> str:
    return "".join(before + separator.join(f"{value:g}" for value in row) + "\n" for row in values)


@pytest.mark.parametrize(
    ("text", "given"),
    [
        (text_of(), PLAIN),
        ("# note\n\na,b,c,d,e,f\n" + text_of(), PLAIN),
        (text_of(" "), Input(unit="kPa", compression="positive", order="columns", flip_x=True)),
        (text_of(";").replace(".", ","), Input(flip_y=True)),
        (text_of("\t", "12:30:01\t"), Input(skip_columns=1)),
        (text_of(values=np.rint(TAXELS) + 2048), Input(unit="codes", coding="offset")),
        (text_of().replace("\n", "\r\n"), PLAIN),
    ],
)
def test_as_a_file(text: str, given: Input, tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text(text, newline="")
    expected = read_recording(tmp_path / "a.csv", SENSOR, ADC, given).frames
    np.testing.assert_array_equal(np.array(read(text, given)), expected)
    assert len(expected) == 3


def test_the_tare_is_that_of_the_first_frames_or_of_a_file(tmp_path: Path) -> None:
    found = read(text_of(), Input(tare_frames=2))
    np.testing.assert_allclose(found, [(TAXELS[2] - TAXELS[:2].mean(axis=0)).reshape(2, 3)])
    (tmp_path / "rest.csv").write_text(text_of(values=TAXELS[:1]))
    found = read(text_of(), Input(tare=tmp_path / "rest.csv"))
    np.testing.assert_allclose(found, (TAXELS - TAXELS[0]).reshape(3, 2, 3))
    with pytest.raises(InputError, match=r"none\.csv: cannot be read"):
        FrameLines(SENSOR, ADC, Input(tare=tmp_path / "none.csv"))


def test_a_new_tare_is_the_next_frames(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "TARE_FRAMES", 2)
    for given, first in ((PLAIN, []), (Input(tare_frames=2), [0, 1])):
        reader, taken = FrameLines(SENSOR, ADC, given), []
        for at, frame in enumerate(reader.frames(lines(text_of(values=np.tile(TAXELS, (3, 1)))), lambda frame: None)):
            if at == 0:
                reader.intake.again()
                assert reader.intake.told == "Tare: keep the array at rest."
            taken.append(frame)
        at = len(first) + 1  # that of the first frame after the first tare
        rest = np.tile(TAXELS, (3, 1))[at : at + 2].mean(axis=0)
        np.testing.assert_allclose(taken[1:], (np.tile(TAXELS, (3, 1))[at + 2 :] - rest).reshape(-1, 2, 3))
        assert reader.intake.told.startswith("Tare: the mean of 2 frames")


def test_a_tare_says_how_far_it_is_and_what_is_wrong_with_it() -> None:
    reader = FrameLines(SENSOR, ADC, Input(tare_frames=3, unit="kPa"))
    assert reader.intake.told == "Tare: keep the array at rest, 0 of 3 frames have come."
    given = reader.frames(lines(text_of(values=TAXELS[[0, 0]]) + "# note"), lambda frame: None)
    assert list(given) == []
    assert reader.intake.told == "Tare: keep the array at rest, 2 of 3 frames have come."
    list(reader.frames(lines(text_of(values=100 * TAXELS[:1])), lambda frame: None))
    assert "was the array at rest in all 3 frames of it?" in reader.intake.told


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("1,2,3", "6 numbers (2 rows x 3 columns) are needed, got 3"),
        ("0.1,1,2,3,4,5,6", "6 numbers (2 rows x 3 columns) are needed, got 7: is the first column a time"),
        ("1,2,x,4,5,6", "'x' at position 3 is not a number"),
        ("1,2,nan,4,5,6", "row 0, column 2 is not finite"),
        ("1,2,3,4,5,1e13", "row 1, column 2 is 1e+13 Pa, the limit is 1e+12 Pa"),
        ("1,2,\0,4,5,6", "a NUL byte is in the text"),
        ("a,b,c,d,e,f", "'a' at position 1 is not a number"),
        ('"1",2,3\r,4,5,6', "6 numbers (2 rows x 3 columns) are needed, got 1"),
        (f'"{"1" * 200_000}",2,3,4,5,6', "6 numbers (2 rows x 3 columns) are needed, got 1"),
    ],
)
def test_a_line_that_is_no_frame_is_told_and_passed_over(line: str, said: str) -> None:
    first, wrong, last = read(f"1,2,3,4,5,6\n{line}\n6,5,4,3,2,1")
    np.testing.assert_array_equal(np.array([first, last]).reshape(2, 6), [[1, 2, 3, 4, 5, 6], [6, 5, 4, 3, 2, 1]])
    assert isinstance(wrong, str)
    assert wrong.startswith(f"line 2: {said}")


def test_lines_that_are_all_wrong_say_why() -> None:
    found = read("7,1,2,3,4,5,6\n8,1,2,3,4,5,6\n")
    assert [str(line).startswith(f"line {n}: 6 numbers ") for n, line in enumerate(found, 1)] == [True, True]
    assert all(str(line).endswith("is the first column a time stamp? (--skip-columns 1)") for line in found)
    (line,) = FrameLines(SENSOR, ADC, PLAIN).frames([(1, b"\xff\x80")], lambda frame: None)
    assert line == "line 1: is not UTF-8 text: is the baud rate of a serial port right?"
    _, line = read('1,2,3,4,5,6\n""', Input(columns="1-6"))
    assert str(line).startswith("line 2: 6 numbers (2 rows x 3 columns) are needed, got 0")
    with warnings.catch_warnings(action="error"):
        (line,) = read("1,2,3,4,5,1e308", Input(unit="kPa"))
    assert line == "line 1: row 1, column 2 is not finite"
    (line,) = read("1,2,3,4,5,4000", Input(unit="codes"))
    assert str(line).startswith("line 1: row 1, column 2 is 4000, signed codes of 12 bits are from ")


def test_a_frame_that_its_reader_refuses() -> None:
    def check(frame: Floats) -> None:
        if frame.max() > 5:
            raise InputError("line", "", "frames: frame 0, row 1, column 2 is over full scale")

    found = FrameLines(SENSOR, ADC, PLAIN).frames(lines("1,2,3,4,5,6\n1,2,3,4,5,5"), check)
    assert next(found) == "line 1: row 1, column 2 is over full scale"
    np.testing.assert_array_equal(next(found), [[1, 2, 3], [4, 5, 5]])


FRAMES = np.arange(24.0).reshape(4, 2, 3)


@pytest.mark.parametrize(
    ("times", "seconds", "rate", "expected"),
    [
        (None, False, None, [0, 0.01, 0.02, 0.03]),
        (None, False, 50.0, [0, 0.02, 0.04, 0.06]),
        ([7, 7.5, 7.6, 8], False, None, [0, 0.5, 0.6, 1]),  # seconds
        ([7, 7.5, 7.6, 8], False, 4.0, [0, 0.25, 0.5, 0.75]),
        ([0, 20, 40, 60], False, None, [0, 0.01, 0.02, 0.03]),  # milliseconds, perhaps
        ([0, 20, 40, 60], True, None, [0, 20, 40, 60]),
        ([0, 0.5, 0.5, 1], True, None, [0, 0.01, 0.02, 0.03]),  # no order to follow
    ],
)
def test_due(times: list[float] | None, seconds: bool, rate: float | None, expected: list[float]) -> None:
    recording = Recording(FRAMES, None if times is None else np.array(times, dtype=np.float64), seconds)
    np.testing.assert_allclose(due(recording, rate), expected, atol=1e-12)


def test_no_frame_comes_before_it_is_due() -> None:
    begun, when = time.monotonic(), np.array([0, 0.02, 0.02, 0.05])
    for frame, expected, at in zip(replayed(FRAMES, when), FRAMES, when, strict=True):
        np.testing.assert_array_equal(frame, expected)
        assert time.monotonic() >= begun + at
