"""``tfra.load`` and the sensor that it returns."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy.typing as npt

from tfra.array import Array, EngineName, keywords
from tfra.codegen.config import read as config
from tfra.contacts import Truth, simulated
from tfra.engines import estimator, run, taken
from tfra.model.arrays import Floats
from tfra.model.cover.contact import Contact
from tfra.model.tfra import joined
from tfra.recordings.frames import Recording
from tfra.result import Result
from tfra.runtime.errors import InputError, quoted

if TYPE_CHECKING:
    from tfra.stepper import Stepper
    from tfra.stream import Stream


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
class Sensor(Array):
    """A tactile array as its CONFIG file describes it, immutable; :func:`tfra.load` makes one.

    ``read`` reads a recording, ``simulate`` makes frames of known contacts, ``estimate`` finds their forces.
    """

    def __repr__(self) -> str:
        return f"<tfra.Sensor {self._described()}>"

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
        chosen, project, recording = self._asked(frames, engine, codes)
        with keywords():
            found = run(chosen, project, recording.frames, "Sensor.estimate", converted=codes)
        notices = self._notices(recording, found.status)
        return Result(**vars(found), project=self.project, recording=recording, engine=engine, notices=notices)

    def stream(self, engine: EngineName = "float", **given: Any) -> "Stream[Result]":
        """Return a function of frames as they come, in the converter's numbers: it tares them and gives their forces.

        ``given`` are the keys of [input], as of ``read``.  It is called with a frame or a few and returns their
        ``tfra.Result``, without notices, or None while there is none: in the tare, or within a mean.

            >>> sensor = tfra.load("examples/skin_8x12.toml")
            >>> stream = sensor.stream(unit="kPa", tare_frames=2, drift_frames=500)
            >>> frames = [0 * sensor.simulate()[0][0]] * 2 + list(sensor.simulate()[0] / 1000)
            >>> results = [stream(frame) for frame in frames]
            >>> [result is None for result in results[:3]]
            [True, True, False]
            >>> stream.told
            'Tare: the mean of 2 frames.'

        ``stream.tare()`` takes the next frames for a new tare.  Raises ``tfra.InputError`` for keys that are wrong.
        """
        from tfra.stream import Stream

        chosen, project = self._streamed(engine, given)

        def estimate(recording: Recording) -> Result:
            found = joined([model(taken(chosen, project, recording.frames, "Sensor.stream"))])
            return Result(**vars(found), project=self.project, recording=recording, engine=engine)

        with keywords():
            model = estimator(chosen, project)
            return Stream("Sensor.stream", project, estimate)
