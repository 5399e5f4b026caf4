"""Sensors, a CONFIG each with a file of weights beside it, and what the estimators see.

These are contacts on covers, by the exact series, through arrays that are never perfect.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from bench.accuracy.loads import SHAPES, Cover, Load, Scene, pair, peak
from bench.publish import ROOT
from tfra.codegen.config.read import load
from tfra.codegen.config.weights import read_weights
from tfra.model.arrays import Floats, Ints
from tfra.model.choices import Choices
from tfra.model.converter import convert
from tfra.model.cover.contact import Contact, Contacts
from tfra.model.cover.scenes import any_contacts
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


LEVELS = (0.1, 0.75)
"""Peaks of the exact frames, as shares of the converter's full scale: no scene drives it far into its limits."""


@dataclass(frozen=True)
class Array:
    """What the taxels add, as shares of each frame's peak.

    ``noise``: standard deviation; ``offset``: of all taxels; ``gain``: standard deviation of the taxels' gains, drawn
    for each frame; ``dead``: a taxel reads zero; ``frames``: a frame is the mean of so many; ``unsigned``: tension
    reads zero.
    """

    noise: float = 1e-3
    offset: float = 0.0
    gain: float = 0.0
    dead: bool = False
    frames: int = 1
    unsigned: bool = False

    def codes(self, choices: Choices, stress: Floats, rng: np.random.Generator) -> Ints:
        """Converter codes ``(n, rows, columns)`` of the exact ``stress`` in Pa."""
        shape, highest = stress.shape, peak(stress)
        still = stress * (1 + self.gain * rng.standard_normal(shape)) + self.offset * highest
        noise = (self.noise * highest * rng.standard_normal(shape) for _ in range(self.frames))
        codes = np.rint(sum(convert(choices, still + each) for each in noise) / self.frames).astype(np.int64)
        if self.dead:
            flat, taxels = codes.reshape(len(codes), -1), rng.integers(choices.sensor.taxels, size=len(codes))
            flat[np.arange(len(codes)), taxels] = 0
        return np.minimum(codes, 0) if self.unsigned else codes


@dataclass(frozen=True)
class Setting:
    """A load on a cover, and an array."""

    load: Load
    array: Array


QUIET = "0.1 % noise"
NOISES = ("no noise", QUIET, "1 % noise")

SCENES: dict[str, Setting] = {
    "no noise": Setting(Cover(), Array(noise=0.0)),
    QUIET: Setting(Cover(), Array()),
    "1 % noise": Setting(Cover(), Array(noise=1e-2)),
    "1 % noise, mean of 16 frames": Setting(Cover(), Array(noise=1e-2, frames=16)),
    "offset of +0.5 %": Setting(Cover(), Array(offset=5e-3)),
    "offset of +1 %": Setting(Cover(), Array(offset=1e-2)),
    "offset of −1 %": Setting(Cover(), Array(offset=-1e-2)),
    "gains spread by 3 %": Setting(Cover(), Array(gain=0.03)),
    "gains spread by 10 %": Setting(Cover(), Array(gain=0.1)),
    "a dead taxel": Setting(Cover(), Array(dead=True)),
    "compression alone, tension reads zero": Setting(Cover(), Array(unsigned=True)),
    "cover 10 % thinner": Setting(Cover(thickness=0.9), Array()),
    "cover 10 % thicker": Setting(Cover(thickness=1.1), Array()),
    "cover that goes on": Setting(Cover(margin=5.0), Array()),
    "ν = 0.45": Setting(Cover(poisson=0.45), Array()),
    "ν = 0.5": Setting(Cover(poisson=0.5), Array()),
    "taxels that average": Setting(Cover(sampling="area"), Array()),
    **{name: Setting(shape, Array()) for name, shape in SHAPES.items()},
    "two contacts": Setting(pair, Array()),
}
"""Every scene; without another statement the noise is 0.1 % of the peak."""


def observed(choices: Choices, setting: Setting, contacts: Contacts, rng: np.random.Generator) -> tuple[Ints, Floats]:
    """Codes ``(n, rows, columns)`` of ``contacts``, and true resultants ``(n, 3)`` in N.

    The loads are scaled, so that the peaks of the exact frames are ``LEVELS`` of full scale.
    """
    level = rng.uniform(*LEVELS, len(contacts))
    scene = scaled(setting.load(choices.sensor, contacts, rng), level * choices.adc.full_scale)
    return setting.array.codes(choices, scene.stress, rng), scene.force


def scaled(scene: Scene, highest: Floats) -> Scene:
    """``scene`` with loads of another size: ``highest (n,)`` are the frames' peaks in Pa."""
    factor = highest / peak(scene.stress)[:, 0, 0]
    return replace(scene, stress=scene.stress * factor[:, None, None], force=scene.force * factor[:, None])


def scenes(case: Case, count: int) -> Iterator[tuple[str, Ints, Floats]]:
    """Name, codes and true resultants of every scene; all have the same contacts and the same peaks."""
    contacts = any_contacts(case.design.sensor, count, case.generator("contacts"))
    for name, setting in SCENES.items():
        yield name, *observed(case.design, setting, contacts, case.generator("array"))
