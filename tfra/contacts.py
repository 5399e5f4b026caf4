"""Simulated frames of contacts, and their ground truth."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from tfra.engines import Advance, silent
from tfra.model.arrays import Floats, Ints
from tfra.model.cover.contact import Contact
from tfra.runtime.errors import InputError

if TYPE_CHECKING:
    from tfra.codegen.config.read import Project

CHUNK = 64  # contacts between two steps of the progress bar


@dataclass(frozen=True, repr=False)
class Truth:
    """Ground truth of ``contacts``, to compare estimates with.

    Each has a frame of its own, or ``frame (n,)`` has the number of each one's, in order.
    """

    contacts: tuple[Contact, ...]
    frame: Ints | None = None

    @property
    def resultant(self) -> Floats:
        """``(n, 3)``: F_x, F_y, F_z in N; F_z < 0 presses."""
        return np.array([contact.force for contact in self.contacts])

    @property
    def mu(self) -> Floats:
        """``(n,)``: tangential over normal force."""
        return np.array([contact.mu for contact in self.contacts])

    @property
    def phi_deg(self) -> Floats:
        """``(n,)``: direction of the tangential force, degrees in [0, 360)."""
        phi = np.degrees([contact.phi for contact in self.contacts])
        return np.asarray(np.round(phi, 9) % 360.0)  # the conversion from radians loses the last digits

    def arrays(self) -> dict[str, Any]:
        """Arrays for a file of simulated frames, by key: SI units, phi in degrees."""
        return {
            "resultant_ref": self.resultant,
            "mu_ref": self.mu,
            "phi_ref_deg": self.phi_deg,
            **({} if self.frame is None else {"frame_ref": self.frame}),
            "contact_shape": np.array([str(c.shape) for c in self.contacts]),
            "contact_center": np.array([(c.center_x, c.center_y) for c in self.contacts]),
            "contact_half": np.array([(c.half_x, c.half_y) for c in self.contacts]),
        }

    def __len__(self) -> int:
        return len(self.contacts)

    def __repr__(self) -> str:
        return f"<tfra.Truth of {len(self)} contacts: resultant {self.resultant.shape} N, mu, phi_deg>"


def simulated(project: Project, truth: Truth, advance: Advance = silent) -> Floats:
    """Frames ``(n, rows, columns)`` in Pa, those of all contacts of a frame added; ``InputError`` if there is none."""
    contacts, sensor = truth.contacts, project.array.sensor
    if not contacts:
        raise InputError(project.path, "contact", "at least one [[contact]] is needed to simulate frames")
    frame = np.arange(len(contacts)) if truth.frame is None else truth.frame
    frames = np.zeros((frame[-1] + 1, sensor.rows, sensor.columns))
    for start in range(0, len(contacts), CHUNK):
        part = slice(start, start + CHUNK)
        try:
            np.add.at(frames, frame[part], project.layer.frames(sensor, contacts[part]))
        except ValueError as error:  # a mesh that is too coarse, or no finite elements installed
            raise InputError(project.path, "", str(error)) from None
        advance(len(contacts[part]))
    return frames
