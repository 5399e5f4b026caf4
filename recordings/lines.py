"""Frames as they come: from lines of text, each read as one of a file is, or from a recording at its own rate."""

import time
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

import numpy as np

from tfra.model.arrays import Floats
from tfra.model.choices import Adc
from tfra.model.sensor import SensorArray
from tfra.recordings.columns import by_header
from tfra.recordings.formats.text import Table, are_headings, frames_of, table_for, table_of_names
from tfra.recordings.frames import Recording, front_end, in_place, pascals, tare_of
from tfra.recordings.input import Input
from tfra.recordings.intake import Intake
from tfra.runtime.errors import InputError

_PLACE = Path("line")
"""Stands for the file in complaints, which are about a line."""

RATE = 100.0
"""Frames a second of a recording that does not know its own."""

SLOWEST, FASTEST = 1.0, 1e5
"""Frames a second: times that say something else are not in seconds."""


class FrameLines:
    """Reads lines one by one, as ``given`` says; ``intake`` makes stress of them, and takes their tare.

    The separator is that of the first line that fits the taxels.
    """

    def __init__(self, sensor: SensorArray, adc: Adc, given: Input) -> None:
        """Read the tare's own file, if there is one; raises ``InputError`` for it."""
        self._sensor, self._adc, self._given = sensor, adc, given
        self.intake = Intake(front_end(_PLACE, sensor, adc, given, tare_of(sensor, adc, given)), adc, given)
        self._table: Table | None = None
        self._begun = False

    def frames(self, lines: Iterable[tuple[int, bytes]], check: Callable[[Floats], object]) -> Iterator[Floats | str]:
        """Yield the frames ``(rows, columns)`` in Pa, and for each line that is none what is wrong with it.

        ``check`` raises ``InputError`` for a frame ``(1, rows, columns)`` that its reader has no use for.
        """
        for number, line in lines:
            try:
                frame = self._frame(line)
                if frame is not None:
                    check(frame)
                    yield frame[0]
            except InputError as error:
                said = str(error)
                for part in (f"{_PLACE}: ", "line 0: ", "frames: ", "frame 0, "):
                    said = said.removeprefix(part)
                yield f"line {number}: {said}"

    def _frame(self, line: bytes) -> Floats | None:
        """The frame of a line, ``(1, rows, columns)``; None for headings, notes, and what is not shown."""
        text = _text(line)
        if not text.strip() or text.lstrip().startswith("#"):
            return None
        table = self._table or self._found(text)
        if table is None:
            return None
        first, self._begun = not self._begun, True
        if first and are_headings(table.cells(text)):
            return None
        ((_, cells),), _ = frames_of(table, [(0, text)])
        self._table = table
        values = np.array([[float(cell) for cell in table.taxels(cells)]])
        levels = in_place(_PLACE, values, self._sensor, self._adc, self._given)
        stress = pascals(_PLACE, levels, self.intake)
        return stress if len(stress) else None

    def _found(self, text: str) -> Table | None:
        """The table of the first line; None for one of names, and before that."""
        if not by_header(self._given):
            return table_for(_PLACE, self._sensor, self._given, [text])
        self._table, self._begun = table_of_names(_PLACE, self._sensor, self._given, text), True
        return None


def _text(line: bytes) -> str:
    try:
        text = line.decode("utf-8-sig").rstrip("\r")
    except UnicodeDecodeError:
        raise InputError(_PLACE, "", "is not UTF-8 text: is the baud rate of a serial port right?") from None
    if "\0" in text:
        raise InputError(_PLACE, "", "a NUL byte is in the text")
    return text


def due(recording: Recording, rate: float | None) -> Floats:
    """Return when each frame is due, ``(n,)`` in s since the first: ``rate`` a second, or as the recording says.

    Its times count if they rise and are in seconds: a log's are, those of other files where they give a likely rate.
    """
    times = recording.time
    if rate is None and times is not None and len(times) > 1 and (np.diff(times) > 0).all():
        own = float(1 / np.median(np.diff(times)))
        if recording.seconds or SLOWEST <= own <= FASTEST:
            return np.asarray(times - times[0])
    return np.arange(len(recording.frames)) / (rate or RATE)


def replayed(frames: Floats, when: Floats) -> Iterator[Floats]:
    """Yield each of ``frames (n, rows, columns)`` when it is due; the first is due at once."""
    begun = time.monotonic()
    for frame, at in zip(frames, when, strict=True):
        time.sleep(max(0.0, begun + at - time.monotonic()))
        yield frame
