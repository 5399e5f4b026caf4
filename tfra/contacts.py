"""Simulated frames of contacts, and their ground truth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from tfra.engines import Advance, silent
from tfra.model.arrays import Floats
from tfra.model.cover.contact import Contact
from tfra.runtime.errors import InputError

if TYPE_CHECKING:
    from tfra.codegen.config.read import Project

CHUNK = 64  # contacts between two steps of the progress bar


@dataclass(frozen=True, repr=False)
class Truth:
    """Ground truth of ``contacts``, one frame each, to compare estimates with."""

    contacts: tuple[Contact, ...]

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
            "contact_shape": np.array([str(c.shape) for c in self.contacts]),
            "contact_center": np.array([(c.center_x, c.center_y) for c in self.contacts]),
            "contact_half": np.array([(c.half_x, c.half_y) for c in self.contacts]),
        }

    def __len__(self) -> int:
        return len(self.contacts)

    def __repr__(self) -> str:
        return f"<tfra.Truth of {len(self)} contacts: resultant {self.resultant.shape} N, mu, phi_deg>"


def simulated(project: Project, contacts: Sequence[Contact], advance: Advance = silent) -> Floats:
    """Return the frames of ``contacts``, ``(n, rows, columns)`` in Pa; raises ``InputError`` if there is none."""
    if not contacts:
        raise InputError(project.path, "contact", "at least one [[contact]] is needed to simulate frames")
    parts = []
    for start in range(0, len(contacts), CHUNK):
        part = contacts[start : start + CHUNK]
        try:
            parts.append(project.layer.frames(project.design.sensor, part))
        except ValueError as error:  # a mesh that is too coarse, or no finite elements installed
            raise InputError(project.path, "", str(error)) from None
        advance(len(part))
    return np.concatenate(parts)
