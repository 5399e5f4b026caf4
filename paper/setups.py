"""The two sensors and contacts of doi:10.1016/j.mechatronics.2023.103070, Section 4, and the estimators.

The contacts are defined in ``examples/*.toml``.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from pathlib import Path

import numpy as np

from tfra.codegen.config.read import Project, load
from tfra.model.arrays import Floats
from tfra.model.converter import quantise
from tfra.model.cover.contact import Contact
from tfra.model.fixed.tfra.pipeline import FixedTfra
from tfra.model.fixed.words import decode
from tfra.model.tfra import Result, Tfra
from tfra.model.two_variable import TwoVariable
from tfra.paper.published import PRINTED

EXAMPLES = Path(__file__).resolve().parent.parent / "examples"
"""Next to this package, in the repository as in an installation."""

DIRECTIONS = tuple(range(0, 360, 15))
"""phi of Fig. 5, in degrees."""

TABLE_DIRECTIONS = (0, 15, 30, 45, 60, 65, 75, 90)
"""phi of Tables 1 and 2, in degrees; the paper lists 65 after 90."""

Engine = Callable[[Floats], Result]
"""Forces of frames ``(n, rows, columns)`` in Pa."""


@dataclass(frozen=True)
class Setup:
    """One sensor with its contact: ``key`` names files, ``title`` is for readers, ``data`` holds published numbers.

    ``printed`` are the largest errors that the paper's text states, by the keys of ``published.PAPER``.
    """

    key: str
    title: str
    data: str
    printed: dict[str, float]
    project: Project

    def contacts(self, directions: Sequence[float], shift: tuple[float, float] = (0.0, 0.0)) -> list[Contact]:
        """The contact with phi = ``directions`` in degrees, moved by ``shift`` = (x, y) in pitches."""
        first, sensor = self.project.contacts[0], self.project.design.sensor
        x, y = first.center_x + shift[0] * sensor.pitch_x, first.center_y + shift[1] * sensor.pitch_y
        return [replace(first, center_x=x, center_y=y, phi=math.radians(phi)) for phi in directions]

    def stress(self, contacts: Sequence[Contact]) -> Floats:
        """The measured stress, ``(n, rows, columns)`` in Pa."""
        return self.project.layer.frames(self.project.design.sensor, contacts)

    @cached_property
    def tfra(self) -> Tfra:
        """Float TFRA with the project's sweep."""
        design = self.project.design
        return Tfra(design.sensor, design.search.steps, design.search.tolerance * design.adc.lsb)

    @cached_property
    def engines(self) -> dict[str, Engine]:
        """Float TFRA and the two-variable method on exact stress, the bit-accurate model on converter codes."""
        design = self.project.design
        fixed = FixedTfra(design)
        return {
            "TFRA, float": self.tfra,
            "TFRA, bit-accurate": lambda stress: decode(design, fixed(quantise(design, stress)).words),
            "two-variable, own reading": TwoVariable(design.sensor),
        }


@lru_cache(maxsize=1)
def setups() -> tuple[Setup, Setup]:
    """The Hertzian and the non-Hertzian contact, read once; raises ``InputError`` when an example is missing."""
    return (
        Setup(
            "hertz", "Hertzian contact", "table1_hertzian.csv",
            PRINTED["hertz_40x20"], load(EXAMPLES / "hertz_40x20.toml"),
        ),
        Setup(
            "rectangle", "non-Hertzian contact", "table2_nonhertzian.csv",
            PRINTED["rectangle_40x40"], load(EXAMPLES / "rectangle_40x40.toml"),
        ),
    )  # fmt: skip


def near(estimate_deg: Floats, reference_deg: Floats) -> Floats:
    """``estimate_deg`` plus the full turns that bring it closest to ``reference_deg``; same shapes."""
    return np.asarray(estimate_deg - 360.0 * np.round((estimate_deg - reference_deg) / 360.0))
