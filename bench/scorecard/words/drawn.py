"""Configurations drawn by a seed: both estimators, both kinds of cores, alone and behind AXI; and those of presets."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from bench.exactness.designs import untrained
from bench.publish import ROOT
from bench.scorecard.words.harness import Configuration
from tfra.codegen.config.read import load
from tfra.codegen.verilog.wrapper import check_wrapped
from tfra.hdl.cores import microarchitecture
from tfra.model.choices import SERIAL, Adc, Architecture, Bus, Formats, Search
from tfra.model.fixed.design import Design
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.rounding import Rounding
from tfra.model.sensor import SensorArray

PRESETS = ("small", "fast", "learned_small", "learned_resultant", "fingers_32x32")


def drawn(count: int, seed: int) -> Iterator[Configuration]:
    """So many configurations: every sixth is serial, every third behind AXI, every other one has learned weights.

    What a core or the wrapper does not allow is drawn again.
    """
    for number in range(count):
        rng = np.random.default_rng([seed, number])
        while True:
            try:
                design = _design(number, rng)
                microarchitecture(design).check()
                wrapped = number % 3 == 2
                if wrapped:
                    check_wrapped(design)
            except ValueError:
                continue
            break
        yield Configuration(f"drawn {number}", design, wrapped, bool(wrapped and rng.integers(2)))


def presets() -> Iterator[Configuration]:
    """Cores of examples, with the cells of their devices, and a skin."""
    for name in PRESETS:
        yield Configuration(name, load(ROOT / "examples" / f"{name}.toml").array)


def _design(number: int, rng: np.random.Generator) -> Design:
    """Any choices; raises ``ValueError`` for those that don't fit together."""
    rows, columns = (int(side) for side in rng.integers(2, 6, 2))
    bits, serial = int(rng.integers(6, 19)), number % 6 == 5
    most = -(-rows // 2) * -(-columns // 2)
    lanes, words = 4 * int(rng.integers(1, most + 1)), int(rng.choice([1, 2, 4]))
    coefficient, operand = int(rng.integers(8, 25)), int(rng.integers(max(10, bits), 26))
    rounding = Rounding.HALF_UP if serial else list(Rounding)[rng.integers(len(Rounding))]
    vector, force = (int(fraction) for fraction in rng.integers(0, 12, 2))
    choices: dict[str, Any] = {
        "adc": Adc(bits, contact_threshold=None if rng.integers(3) else 0),
        "formats": Formats("drawn", coefficient, operand, vector, force, rounding=rounding),
        "architecture": SERIAL if serial else Architecture(lanes, words),
        "images": "inline" if serial or rng.integers(3) else "load",
        "bus": Bus(int(rng.choice([1, 2, 4]))),
    }
    if number % 2:
        counts = (int(rng.integers(2, 7)), int(rng.integers(2, 7)))
        return untrained(rows, columns, counts, taxel_forces=bool(rng.integers(2)), **choices)
    pitch = rng.uniform(2e-3, 5e-3, 3)
    search = Search(int(rng.integers(1, 33)), float(rng.choice([0.0, 1.5])))
    return TfraDesign(SensorArray(rows, columns, *map(float, pitch)), f"drawn_{number}", search=search, **choices)
