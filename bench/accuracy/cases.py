"""The sensors of the comparison: a CONFIG each, with a file of weights beside it."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from bench.publish import ROOT
from tfra.codegen.config.read import load
from tfra.codegen.config.weights import read_weights
from tfra.model.cover.contact import Contact
from tfra.model.fixed.learned.design import LearnedDesign

EXAMPLES = ("hertz_40x20", "rectangle_40x40", "skin_8x12")
"""Names in `examples/`; the other sensors are in this folder."""

BITS = 14
"""Of the converter."""

SEED = 31_415_926
"""Of all that is random here; no training and no other study uses it."""


@dataclass(frozen=True, eq=False)
class Case:
    """A sensor with its weights, and the ``contacts`` of its CONFIG."""

    name: str
    design: LearnedDesign
    contacts: tuple[Contact, ...]

    @property
    def coarseness(self) -> float:
        """Mean pitch, the root of a taxel's area, over the cover's thickness."""
        return float(np.sqrt(self.design.sensor.taxel_area) / self.design.sensor.thickness)

    def generator(self, purpose: str) -> np.random.Generator:
        """Random numbers that depend on the sensor's name and on ``purpose`` alone."""
        return np.random.default_rng([SEED, *f"{self.name} {purpose}".encode()])


def cases() -> list[Case]:
    """Every sensor; raises ``InputError`` for a file that can't be read, or that is not the sensor's."""
    own = sorted((ROOT / "bench" / "accuracy").glob("*.toml"))
    return [case(config) for config in [*(ROOT / "examples" / f"{name}.toml" for name in EXAMPLES), *own]]


def case(config: Path) -> Case:
    """The sensor of ``config``, with the weights beside it and a converter of ``BITS``."""
    project = load(config)
    sensor, adc = project.design.sensor, project.design.adc
    trained = read_weights(config.with_suffix(".weights.npz"), sensor)
    design = LearnedDesign(
        sensor=sensor,
        adc=replace(adc, bits=BITS, contact_threshold=None),
        weights=trained.weights,
        threshold=trained.threshold,
        taxel_forces=False,
    )
    return Case(config.stem, design, project.contacts)
