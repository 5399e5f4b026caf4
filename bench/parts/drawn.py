"""Twelve designs that chance has drawn and nobody tuned a price to: what they are estimated at, and what they take."""

from collections.abc import Iterator
from itertools import islice
from typing import Any

import numpy as np

from tfra.families import Target, find
from tfra.hdl.cores import microarchitecture
from tfra.model.choices import SERIAL, VECTOR_WORDS, Adc, Architecture, Formats, Search
from tfra.model.fixed.design import Design
from tfra.model.fixed.learned.design import LearnedDesign
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.learned.network import Weights
from tfra.model.sensor import SensorArray

SEED = 2_026
NUMBER = 12
RESOURCES = ("LUT", "FF", "DSP", "BRAM")


def drawn() -> list[tuple[Design, Target]]:
    """The designs, and the parts that they are synthesised for: always the same."""
    return list(islice(_buildable(np.random.default_rng(SEED)), NUMBER))


def _buildable(rng: np.random.Generator) -> Iterator[tuple[Design, Target]]:
    """Designs by chance; those whose words may overflow, or that no serial core holds, are left out."""
    number = 0
    while True:
        try:
            design, target = _draw(rng, f"d{number + 1}")
            microarchitecture(design).check()
        except ValueError:
            continue
        number += 1
        yield design, target


def _draw(rng: np.random.Generator, name: str) -> tuple[Design, Target]:
    """One design of any size, estimator, architecture and formats; parallel cores are for ECP5."""

    def between(fewest: int, most: int) -> int:
        return int(rng.integers(fewest, most + 1))

    rows, columns, parallel = between(4, 14), between(4, 12), between(0, 1)
    target = find("ecp5-85" if parallel or not between(0, 2) else "ice40up5k")
    formats = Formats("custom", between(12, 24), between(12, 24), between(5, 14), between(3, 8))
    lanes, words = 4 * between(1, 8), VECTOR_WORDS[between(0, 2)]
    sensor = SensorArray(rows, columns, 4e-3, 2e-3, 3e-3)
    common: dict[str, Any] = {
        "name": name,
        "adc": Adc(between(8, 16)),
        "search": Search(between(10, 200)),
        "formats": formats,
        "architecture": Architecture(lanes, words) if parallel else SERIAL,
        "target": target.family.name if between(0, 1) or target.family.name == "ice40" else "portable",
    }
    if between(0, 1):
        return TfraDesign(sensor, **common), target
    weights = random_weights(rng, sensor.taxels, between(8, 48), between(4, 24))
    return LearnedDesign(sensor, weights=weights, threshold=0.25, taxel_forces=bool(between(0, 1)), **common), target


def random_weights(rng: np.random.Generator, taxels: int, c1: int, c2: int) -> Weights:
    """Weights of no meaning: a core's size does not depend on them."""
    shapes = (c1, taxels), (4, c2, c1), (4, c2), (4, c1), (4, taxels)
    return Weights(*(rng.normal(size=shape) for shape in shapes))


def text(design: Design, target: Target) -> str:
    """The design in a few words."""
    bits, core = f"{design.formats.coefficient} × {design.formats.operand} bits", design.architecture
    lanes = f" {core.mac_lanes} × {core.vector_words}" if core.mac_lanes else ""
    size = f"{design.sensor.rows} × {design.sensor.columns}"
    return f"{size}, {design.estimator}, {core.kind}{lanes}, {bits}, {target.family.title}"
