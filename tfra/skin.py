"""``tfra.load_skin`` and the skin that it returns."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from tfra.array import Array, EngineName, keywords
from tfra.codegen.config import read as config
from tfra.contacts import Truth, simulated
from tfra.engines import run_skin, skin_estimator, taken
from tfra.found import Contacts
from tfra.model.arrays import Floats
from tfra.model.cover.contact import Contact
from tfra.model.skin import skin
from tfra.recordings.frames import Recording
from tfra.runtime.errors import InputError, quoted

if TYPE_CHECKING:
    from tfra.stream import Stream


def load_skin(path: str | Path) -> "Skin":
    """Read the CONFIG file of a skin at ``path``, one with a section window: a large array with many contacts.

        >>> skin = tfra.load_skin("examples/fingers_32x32.toml")
        >>> skin.shape, skin.window
        ((32, 32), (10, 10))

    Raises ``tfra.InputError`` as ``tfra.load``, and for a CONFIG file without such a section.
    """
    project = config.load(path)
    if project.skin is None:
        raise InputError(project.path, "window", "is missing: tfra.load_skin is for skins, tfra.load for other arrays")
    return Skin(project, project.skin)


@dataclass(frozen=True, repr=False)
class Skin(Array):
    """A large array as its CONFIG file describes it, immutable; :func:`tfra.load_skin` makes one.

    It has the methods of a ``tfra.Sensor``; ``estimate`` finds contacts, and the force of each.
    """

    skin: skin.Skin

    def __repr__(self) -> str:
        return f"<tfra.Skin {self._described()}; windows of {self.window[0]}×{self.window[1]}>"

    @property
    def window(self) -> tuple[int, int]:
        """Rows and columns that the estimator of one contact sees."""
        return self.skin.shape

    def simulate(self, frames: Sequence[Sequence[Contact]] | None = None) -> tuple[Floats, Truth]:
        """Simulate ``frames`` of contacts that act together, by default CONFIG's.

        Returns frames ``(n, rows, columns)`` in Pa and the ``tfra.Truth`` of all contacts, whose ``frame`` has the
        number of each one's:

            >>> frames, truth = tfra.load_skin("examples/fingers_32x32.toml").simulate()
            >>> frames.shape, truth.frame.shape
            ((24, 32, 32), (96,))

        Raises ``tfra.InputError`` if there is no contact, or one that leaves the cover.
        """
        if frames is None:
            truth = Truth(self.contacts, self.project.frame)
        else:
            contacts = [each for frame in frames for each in frame]
            if not all(isinstance(each, Contact) for each in contacts):
                raise InputError("Skin.simulate", "frames", f"lists of tfra.Contact are needed, got {quoted(frames)}")
            truth = Truth(tuple(contacts), np.repeat(np.arange(len(frames)), [len(frame) for frame in frames]))
        return simulated(self.project, truth), truth

    def estimate(
        self, frames: Recording | npt.ArrayLike, engine: EngineName = "float", *, codes: bool = False
    ) -> Contacts:
        """Find the contacts in ``frames`` and their forces; arguments and errors are those of ``tfra.Sensor``.

        >>> skin = tfra.load_skin("examples/fingers_32x32.toml")
        >>> frames, truth = skin.simulate()
        >>> contacts = skin.estimate(frames, engine="c")
        >>> contacts.found.tolist() == [4] * 24
        True
        """
        chosen, project, recording = self._asked(frames, engine, codes)
        with keywords():
            found = run_skin(chosen, project, self.skin, recording.frames, "Skin.estimate", converted=codes)
        notices = self._notices(recording, found.frame_status)
        return Contacts(**vars(found), project=self.project, recording=recording, engine=engine, notices=notices)

    def stream(self, engine: EngineName = "float", **given: Any) -> "Stream[Contacts]":
        """Return a function of frames as they come; arguments and errors are those of ``tfra.Sensor.stream``.

        The frames of each call begin at 0, and so do the tracks of its ``tfra.Contacts``.
        """
        from tfra.stream import Stream

        chosen, project = self._streamed(engine, given)

        def estimate(recording: Recording) -> Contacts:
            found = model(taken(chosen, project, recording.frames, "Skin.stream"))
            return Contacts(**vars(found), project=self.project, recording=recording, engine=engine)

        with keywords():
            model = skin_estimator(chosen, project, self.skin)
            return Stream("Skin.stream", project, estimate)
