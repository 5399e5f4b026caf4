"""Frames from lines of text as they come, each read as a line of a recording is."""

from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

import numpy as np

from tfra.model.arrays import Floats
from tfra.model.choices import Adc
from tfra.model.sensor import SensorArray
from tfra.recordings.formats.text import Table, are_headings, require_numbers, table_for
from tfra.recordings.frames import in_place, pascals, tare_of
from tfra.recordings.input import Input
from tfra.runtime.errors import InputError

_PLACE = Path("line")
"""Stands for the file in complaints, which are about a line."""


class FrameLines:
    """Reads lines one by one, as ``given`` says: the first ``tare_frames`` frames are the tare, and no more than that.

    The separator is that of the first line that fits the taxels.
    """

    def __init__(self, sensor: SensorArray, adc: Adc, given: Input) -> None:
        """Read the tare's own file, if there is one; raises ``InputError`` for it."""
        self._sensor, self._adc, self._given = sensor, adc, given
        self._rest = tare_of(sensor, adc, given)
        self._tare: list[Floats] = []
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
        """The frame of a line, ``(1, rows, columns)``; None for headings, for notes, and for the frames of the tare."""
        text = _text(line)
        if not text.strip() or text.lstrip().startswith("#"):
            return None
        table = self._table or table_for(_PLACE, self._sensor, self._given.skip_columns, [text])
        first, self._begun = not self._begun, True
        if first and are_headings(table.cells(text)):
            return None
        ((_, cells),) = require_numbers(table, [(0, text)])
        self._table = table
        values = np.array([[float(cell) for cell in cells[self._given.skip_columns :]]])
        levels = in_place(_PLACE, values, self._sensor, self._adc, self._given)
        if len(self._tare) < self._given.tare_frames:
            self._tare.append(levels)
            if len(self._tare) == self._given.tare_frames:
                self._rest = np.concatenate(self._tare)
            return None
        return pascals(_PLACE, levels, self._adc, self._given, self._rest)


def _text(line: bytes) -> str:
    try:
        text = line.decode("utf-8-sig").rstrip("\r")
    except UnicodeDecodeError:
        raise InputError(_PLACE, "", "is not UTF-8 text: is the baud rate of a serial port right?") from None
    if "\0" in text:
        raise InputError(_PLACE, "", "a NUL byte is in the text")
    return text
