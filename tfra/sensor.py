"""``tfra.load`` and the sensor that it returns."""

import re
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np
import numpy.typing as npt
from pydantic import ValidationError

from tfra.codegen.config import read as config
from tfra.codegen.config.complaints import complaint
from tfra.codegen.config.schema import InputSection
from tfra.contacts import Truth, simulated
from tfra.engines import DOUBLE, Engine, run
from tfra.model.arrays import Floats
from tfra.model.choices import Adc, Formats
from tfra.model.cover.contact import Contact
from tfra.model.sensor import SensorArray
from tfra.model.tfra import check_frames
from tfra.recordings.diagnosis import warnings as doubts
from tfra.recordings.frames import Recording, read_as, read_recording
from tfra.recordings.input import Coding, Input, Order, Sign, Unit
from tfra.result import Result
from tfra.runtime.errors import InputError, Notice, quoted

if TYPE_CHECKING:
    from tfra.stepper import Stepper

EngineName = Literal["float", "fixed", "c", "rtl", "two-variable"]

_OPTION = re.compile(r"--([a-z][a-z-]*)( [A-Za-z0-9]+)?")


def load(path: str | Path) -> "Sensor":
    """Read the CONFIG file at ``path``: the sensor, its converter, the arithmetic of its core, and contacts.

    ``tfra init`` writes such a file, ``tfra examples --out examples`` those of this example:

        >>> sensor = tfra.load("examples/hertz_40x20.toml")
        >>> sensor.shape
        (10, 10)
        >>> sensor.adc.bits, sensor.adc.full_scale       # full scale in Pa
        (16, 100000.0)

    Raises ``tfra.InputError``, a line that names the file, the key and the reason, for anything wrong with it.
    """
    project = config.load(path)
    project.require_array("tfra.load")
    return Sensor(project)


@dataclass(frozen=True, repr=False)
class Sensor:
    """A tactile array as its CONFIG file describes it, immutable; :func:`tfra.load` makes one.

    ``read`` reads a recording, ``simulate`` makes frames of known contacts, ``estimate`` finds their forces.
    """

    project: config.Project

    @property
    def name(self) -> str:
        """Name of the sensor's core and its files."""
        return self.project.design.name

    @property
    def array(self) -> SensorArray:
        """Geometry: rows, columns, pitch_x, pitch_y and the thickness of the cover, in m."""
        return self.project.design.sensor

    @property
    def shape(self) -> tuple[int, int]:
        """Shape of a frame: rows, columns."""
        return self.array.rows, self.array.columns

    @property
    def adc(self) -> Adc:
        """The converter: bits, full_scale in Pa, the contact threshold in codes."""
        return self.project.design.adc

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
        """CONFIG's contacts, one for each frame that ``simulate`` makes."""
        return self.project.contacts

    def __repr__(self) -> str:
        array, adc = self.array, self.adc
        lengths = (f"{1e3 * length:.6g}" for length in (array.pitch_x, array.pitch_y, array.thickness))
        return (
            f"<tfra.Sensor {self.name}: {array.rows}×{array.columns} taxels, "
            + "{} × {} mm apart, under {} mm; ".format(*lengths)
            + f"{adc.bits} bits for ±{adc.full_scale:g} Pa; {self.formats.name} formats; {len(self.contacts)} contacts>"
        )

    def read(
        self,
        path: str | Path,
        *,
        unit: Unit | None = None,
        compression: Sign | None = None,
        coding: Coding | None = None,
        tare_frames: int | None = None,
        tare: str | Path | None = None,
        order: Order | None = None,
        flip_x: bool | None = None,
        flip_y: bool | None = None,
        skip_columns: int | None = None,
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
        the array at rest; ``tare``: a file that does.  ``order``: a frame runs along "rows" or "columns".  ``flip_x``
        and ``flip_y`` mirror the array.  ``skip_columns``: the number of columns before the taxels, the first is the
        time.  ``topic`` of a log.

        Raises ``tfra.InputError`` that names the file and the place, or the option, that is wrong.
        """
        options = {key: value for key, value in locals().items() if key not in ("self", "path") and value is not None}
        given = {key: str(value) if isinstance(value, Path) else value for key, value in options.items()}
        try:
            checked = InputSection.model_validate(given).model_dump(exclude_none=True)
            if "tare" in checked:
                checked["tare"] = Path(checked["tare"])
            chosen = read_as(Path(path), self.input, checked)
        except ValidationError as error:
            raise InputError("Sensor.read", *complaint(error, InputSection)) from None
        except ValueError as error:
            raise InputError("Sensor.read", "", str(error)) from None
        with _keywords():
            return read_recording(path, self.array, self.adc, chosen)

    def stepper(self) -> "Stepper":
        """Return a function of one frame ``(rows, columns)`` in Pa, for control loops: the words of the core, compiled.

            >>> sensor = tfra.load("examples/skin_8x12.toml")
            >>> step = sensor.stepper()
            >>> step(sensor.simulate()[0][3]).resultant.shape
            (3,)

        It has a state of its own.  Raises ``tfra.InputError`` without a C compiler.
        """
        from tfra.stepper import Stepper

        return Stepper(self.project)

    def simulate(self, contacts: Sequence[Contact] | None = None) -> tuple[Floats, Truth]:
        """Simulate the array under ``contacts``, by default CONFIG's.

        Returns frames ``(n, rows, columns)`` in Pa, one for each contact, and their ``tfra.Truth``:

            >>> frames, truth = tfra.load("examples/skin_8x12.toml").simulate()
            >>> frames.shape, truth.resultant.shape
            ((12, 8, 12), (12, 3))

        Raises ``tfra.InputError`` if there is no contact, or one that leaves the cover.
        """
        given = self.contacts if contacts is None else contacts
        if not isinstance(given, Sequence) or not all(isinstance(each, Contact) for each in given):
            raise InputError("Sensor.simulate", "contacts", f"a list of tfra.Contact is needed, got {quoted(given)}")
        truth = Truth(tuple(given))
        return simulated(self.project, truth), truth

    def estimate(
        self, frames: Recording | npt.ArrayLike, engine: EngineName = "float", *, codes: bool = False
    ) -> Result:
        """Find the forces in ``frames``: a recording, or stress in Pa, ``(n, rows, columns)`` or ``(rows, columns)``.

        ``engine``: "float" is CONFIG's estimator in double precision, by default TFRA; "fixed" the bit-accurate model
        of the core; "c" the same, compiled; "rtl" the core itself in a simulator; "two-variable" the search in both
        friction coefficients.  The core uses codes of the converter; with ``codes=True``, "float" and "two-variable"
        use them, too.

            >>> sensor = tfra.load("examples/skin_8x12.toml")
            >>> frames, truth = sensor.simulate()
            >>> result = sensor.estimate(frames[3], engine="fixed")
            >>> result.forces.shape
            (1, 3, 8, 12)

        Raises ``tfra.InputError`` for frames of another shape, for NaN, and for stress over full scale where the
        converter is asked.  Warns with ``tfra.Notice`` of frames that look wrong: their unit, sign, tare or layout.
        """
        if engine not in tuple(Engine):
            raise InputError("Sensor.estimate", "engine", f"one of {', '.join(Engine)} is needed, got {quoted(engine)}")
        if codes and engine not in DOUBLE:
            raise InputError("Sensor.estimate", "codes", f"the {engine} engine always sees the converter's codes")
        if isinstance(frames, Recording):
            recording = replace(frames, frames=self._stress(frames.frames))
        else:
            recording = Recording(self._stress(frames))
        project = replace(self.project, input=recording.given)
        with _keywords():
            found = run(Engine(engine), project, recording.frames, "Sensor.estimate", converted=codes)
        doubted = doubts(project.array, recording.frames, found.status, recording.given)
        notices = [_as_arguments(doubt) for doubt in doubted]
        for notice in notices:
            warnings.warn(notice, Notice, stacklevel=2)
        return Result(**vars(found), project=self.project, recording=recording, engine=engine, notices=tuple(notices))

    def _stress(self, frames: npt.ArrayLike) -> Floats:
        """``frames`` as ``(n, rows, columns)``, n >= 1; raises ``InputError`` for another shape and for NaN."""
        try:
            stress = np.asarray(frames)
        except ValueError:  # lists of several lengths
            stress = np.empty(0, dtype=np.object_)
        if stress.dtype.kind not in "iuf":
            raise InputError("Sensor.estimate", "frames", "real numbers in one array are needed")
        stress = stress[None] if stress.ndim == 2 else stress
        if stress.ndim != 3 or stress.shape[1:] != self.shape or not len(stress):
            needed = f"shape (n, {self.array.rows}, {self.array.columns}) with n >= 1 is needed"
            raise InputError("Sensor.estimate", "frames", f"{needed}, got {np.shape(frames)}")
        try:
            return check_frames(self.array, stress)
        except ValueError as error:
            raise InputError("Sensor.estimate", "", str(error)) from None


@contextmanager
def _keywords() -> Iterator[None]:
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
