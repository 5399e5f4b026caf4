"""Frames of a recording, unchanged: their stress without noise is unknown."""

from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path

import numpy as np
import polars as pl

from tfra.model.arrays import Floats, Ints
from tfra.model.choices import Adc
from tfra.model.sensor import SensorArray
from tfra.recordings.frames import REFERENCES, read_recording, read_references
from tfra.recordings.input import PLAIN, Input
from tfra.runtime.ownership import is_as_written
from tfra.study.frames.block import BLOCK, Block, Part


@dataclass(frozen=True, eq=False)
class Recording:
    """``frames (n, rows, columns)`` in Pa, and the known references of their contacts.

    Training frames are taken from the beginning, held-out ones from the end backwards: neighbours in time are nearly
    the same, so a random split would put every held-out contact among the training ones, too.
    """

    frames: Floats
    references: dict[str, Floats]

    @classmethod
    def read(cls, file: Path, sensor: SensorArray, adc: Adc, given: Input) -> "Recording":
        """Read a file in the format ``given``, but one of ``tfra frames`` in its own format.

        Raises ``InputError`` as ``read_recording``.
        """
        own = is_as_written(file, "frames")
        frames = read_recording(file, sensor, adc, PLAIN if own else given).frames
        return cls(frames, read_references(file, len(frames)))

    @property
    def digest(self) -> str:
        """Hash of the frames and the references."""
        hashed = sha256(self.frames.tobytes())
        for key, values in sorted(self.references.items()):
            hashed.update(key.encode() + values.tobytes())
        return hashed.hexdigest()

    def block(self, part: Part, number: int, count: int) -> Block:
        """Return the first ``count`` frames of block ``number``."""
        rows = number * BLOCK + np.arange(count)
        if part is Part.HELD_OUT:
            rows = len(self.frames) - 1 - rows
        stress = self.frames[rows].astype(np.float32)
        return Block(number * BLOCK, stress, stress, np.full_like(stress, np.nan), self._truth(rows))

    def _truth(self, rows: Ints) -> pl.DataFrame:
        known = {
            key: self.references.get(key, np.full((len(self.frames), *shape), np.nan))[rows]
            for key, shape in REFERENCES.items()
        }
        f_x, f_y, f_z = known["resultant_ref"].T
        columns = {"force_x_n": f_x, "force_y_n": f_y, "force_z_n": f_z}
        return pl.DataFrame({**columns, "mu": known["mu_ref"], "phi_deg": known["phi_ref_deg"]})
