"""What the objects of ``tfra.load`` and ``tfra.load_skin`` have in common."""

import re
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
import numpy.typing as npt
from pydantic import ValidationError

from tfra.codegen.config.complaints import complaint
from tfra.codegen.config.read import Project
from tfra.codegen.config.schema import InputSection
from tfra.engines import DOUBLE, Engine
from tfra.model.arrays import Floats, Ints
from tfra.model.choices import Adc, Formats
from tfra.model.cover.contact import Contact
from tfra.model.sensor import SensorArray
from tfra.model.tfra import check_frames
from tfra.recordings.diagnosis import warnings as doubts
from tfra.recordings.frames import Recording, read_as, read_recording
from tfra.recordings.input import FILES, Coding, Input, Order, Sign, Unit, overridden
from tfra.runtime.errors import InputError, Notice, quoted

EngineName = Literal["float", "fixed", "c", "rtl", "two-variable"]

_OPTION = re.compile(r"--([a-z][a-z-]*)( [A-Za-z0-9]+)?")


@dataclass(frozen=True, repr=False)
class Array:
    """The geometry of an array, its converter, and how recordings of it are read."""

    project: Project

    @property
    def name(self) -> str:
        """Name of the sensor's core and its files."""
        return self.project.design.name

    @property
    def array(self) -> SensorArray:
        """Geometry: rows, columns, pitch_x, pitch_y and the thickness of the cover, in m."""
        return self.project.array.sensor

    @property
    def shape(self) -> tuple[int, int]:
        """Shape of a frame: rows, columns."""
        return self.array.rows, self.array.columns

    @property
    def adc(self) -> Adc:
        """The converter: bits, full_scale in Pa, the contact threshold in codes."""
        return self.project.array.adc

    @property
    def formats(self) -> Formats:
        """Word lengths of the core's arithmetic."""
        return self.project.design.formats

    @property
    def input(self) -> Input:
        """How recordings are read: CONFIG's [input]."""
        return self.project.input

    @property
    def contacts(self) -> tuple[Contact, ...]:
        """CONFIG's contacts, for the frames that ``simulate`` makes."""
        return self.project.contacts

    def _described(self) -> str:
        """The array and its converter in one line."""
        array, adc = self.array, self.adc
        lengths = (f"{1e3 * length:.6g}" for length in (array.pitch_x, array.pitch_y, array.thickness))
        return (
            f"{self.name}: {array.rows}×{array.columns} taxels, "
            + "{} × {} mm apart, under {} mm; ".format(*lengths)
            + f"{adc.bits} bits for ±{adc.full_scale:g} Pa; {self.formats.name} formats; {len(self.contacts)} contacts"
        )

    def read(
        self,
        path: str | Path,
        *,
        unit: Unit | None = None,
        compression: Sign | None = None,
        coding: Coding | None = None,
        pa_per_code: float | None = None,
        rest_code: float | None = None,
        tare_frames: int | None = None,
        tare: str | Path | None = None,
        drift_frames: int | None = None,
        average: int | None = None,
        dead: Sequence[tuple[int, int]] | None = None,
        calibration: str | Path | None = None,
        order: Order | None = None,
        flip_x: bool | None = None,
        flip_y: bool | None = None,
        skip_columns: int | None = None,
        columns: str | None = None,
        strict: bool | None = None,
        topic: str | None = None,
    ) -> Recording:
        """Read a recording: ``frames (n, rows, columns)`` in Pa, compression negative, and ``time (n,)`` or None.

        docs/recordings.md has all formats and options.
        Arguments override CONFIG's [input]:

            >>> sensor = tfra.load("examples/skin_8x12.toml")
            >>> recording = sensor.read("log.csv", unit="kPa", compression="positive", tare_frames=50)
            >>> recording.frames.shape
            (60, 8, 12)

        ``unit``: "Pa", "kPa" or "codes" of the converter.  ``compression``: its sign, "negative" or "positive".
        ``coding`` of codes: "signed", "offset" or "unipolar".  ``tare_frames``: so many frames at the beginning show
        the array at rest; ``tare``: a file that does; ``rest_code``: the code that all taxels have then.
        ``pa_per_code``: stress of one.  ``drift_frames``: the time constant with which the offset follows between
        contacts.  ``average``: so many frames are one, their mean.  ``dead``: (row, column) of taxels that are computed
        from their neighbours.  ``calibration``: a file of their gains, numbers at rest and dead ones.  ``order``: a
        frame runs along "rows" or "columns".  ``flip_x`` and ``flip_y`` mirror the array.  ``skip_columns``: the number
        of columns before the taxels, the first is the time.  ``columns`` that are taxels, "2-64" or names as
        "T_{row}_{column}".  ``strict``: no line of text may be wrong.  ``topic`` of a log.

        Raises ``tfra.InputError`` that names the file and the place, or the option, that is wrong.
        """
        options = {key: value for key, value in locals().items() if key not in ("self", "path") and value is not None}
        given = {key: str(value) if isinstance(value, Path) else value for key, value in options.items()}
        given |= {"dead": [list(place) for place in dead]} if dead is not None else {}
        chosen = self._chosen("read", given, lambda checked: read_as(Path(path), self.input, checked))
        with keywords():
            return read_recording(path, self.array, self.adc, chosen)

    def _chosen(self, method: str, given: dict[str, Any], choose: Callable[[dict[str, Any]], Input]) -> Input:
        """What ``choose`` makes of the keys of [input] that are ``given`` to a method; raises ``InputError``."""
        try:
            checked = InputSection.model_validate(given).model_dump(exclude_none=True)
            return choose(checked | {key: Path(checked[key]) for key in FILES if key in checked})
        except ValidationError as error:
            raise InputError(f"{type(self).__name__}.{method}", *complaint(error, InputSection)) from None
        except ValueError as error:
            raise InputError(f"{type(self).__name__}.{method}", "", str(error)) from None

    def _streamed(self, engine: EngineName, given: dict[str, Any]) -> tuple[Engine, Project]:
        """The arguments of ``stream``, checked: the engine, and the project with the ``input`` of its frames."""
        chosen = self._chosen("stream", given, lambda checked: overridden(self.input, checked))
        return self._engine("stream", engine), replace(self.project, input=chosen)

    def _engine(self, method: str, engine: EngineName) -> Engine:
        if engine not in tuple(Engine):
            call = f"{type(self).__name__}.{method}"
            raise InputError(call, "engine", f"one of {', '.join(Engine)} is needed, got {quoted(engine)}")
        return Engine(engine)

    def _asked(
        self, frames: Recording | npt.ArrayLike, engine: EngineName, codes: bool
    ) -> tuple[Engine, Project, Recording]:
        """The arguments of ``estimate``, checked: the engine, the project and the recording that it is to run on."""
        chosen = self._engine("estimate", engine)
        if codes and chosen not in DOUBLE:
            raise InputError(self._call, "codes", f"the {engine} engine always sees the converter's codes")
        if isinstance(frames, Recording):
            recording = replace(frames, frames=self._stress(frames.frames))
        else:
            recording = Recording(self._stress(frames))
        return chosen, replace(self.project, input=recording.given), recording

    def _notices(self, recording: Recording, status: Ints) -> tuple[str, ...]:
        """Warn of what is probably wrong with a recording whose frames have this ``status (n,)``, and return that."""
        known = recording.doubts, recording.noise
        doubted = doubts(self.project.array, recording.frames, status, recording.given, *known)
        notices = tuple(_as_arguments(doubt) for doubt in doubted)
        for notice in notices:
            warnings.warn(notice, Notice, stacklevel=3)
        return notices

    @property
    def _call(self) -> str:
        """The method that complaints are about."""
        return f"{type(self).__name__}.estimate"

    def _stress(self, frames: npt.ArrayLike) -> Floats:
        """``frames`` as ``(n, rows, columns)``, n >= 1; raises ``InputError`` for another shape and for NaN."""
        try:
            stress = np.asarray(frames)
        except ValueError:  # lists of several lengths
            stress = np.empty(0, dtype=np.object_)
        if stress.dtype.kind not in "iuf":
            raise InputError(self._call, "frames", "real numbers in one array are needed")
        stress = stress[None] if stress.ndim == 2 else stress
        if stress.ndim != 3 or stress.shape[1:] != self.shape or not len(stress):
            needed = f"shape (n, {self.array.rows}, {self.array.columns}) with n >= 1 is needed"
            raise InputError(self._call, "frames", f"{needed}, got {np.shape(frames)}")
        try:
            return check_frames(self.array, stress)
        except ValueError as error:
            raise InputError(self._call, "", str(error)) from None


@contextmanager
def keywords() -> Iterator[None]:
    """Make messages name arguments instead of command-line options."""
    try:
        yield
    except InputError as error:
        raise InputError(_as_arguments(str(error)), "", "") from None


def _as_arguments(message: str) -> str:
    """``message`` with ``--tare-frames N`` as ``tare_frames=N``."""
    message = re.sub(r"(--[a-z-]+ [a-z]+) (?=--)", r"\1, ", message)

    def argument(found: re.Match[str]) -> str:
        value = (found[2] or "").strip()
        quotes = "" if value.isdigit() or value.isupper() else '"'
        return found[1].replace("-", "_") + (f"={quotes}{value}{quotes}" if value else "")

    return _OPTION.sub(argument, message)
