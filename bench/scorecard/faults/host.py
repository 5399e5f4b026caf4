"""What a host is warned of in a recording of faulty frames, as ``tfra estimate`` warns."""

import re
from typing import Any

import numpy as np

from bench.scorecard.faults.streams import FAULTS, Plant, Stream, clean
from tfra.model.fixed.design import Design
from tfra.recordings.diagnosis import warnings
from tfra.recordings.input import Input
from tfra.recordings.levels import doubts

BLOCKS, FRAMES = 20, 200
"""Recordings of a class, and their frames."""

GIVEN = Input("codes")
OFFSET = 0.05
"""A wrong offset, as a share of full scale; those of all taxels are up to it."""


def _scaled(gain: float) -> Plant:
    def plant(stream: Stream, at: int, taxel: int, rng: np.random.Generator) -> None:
        stream.words[:, taxel] = np.clip(np.rint(gain * stream.words[:, taxel]), stream.low, -stream.low - 1)

    return plant


def _turned(stream: Stream, at: int, taxel: int, rng: np.random.Generator) -> None:
    stream.words *= -1


def _moved(stream: Stream, at: int, taxel: int, rng: np.random.Generator) -> None:
    stream.words[:, taxel] -= round(OFFSET * stream.low)


def _all_moved(stream: Stream, at: int, taxel: int, rng: np.random.Generator) -> None:
    stream.words += np.rint(OFFSET * stream.low * rng.uniform(-1, 1, stream.words.shape[1])).astype(np.int64)


CALIBRATION: dict[str, Plant] = {
    "gain of a taxel 0": _scaled(0),
    "gain of a taxel twice": _scaled(2),
    "gain of a taxel half": _scaled(0.5),
    "sign of all taxels": _turned,
    "offset of a taxel": _moved,
    "offsets of all taxels": _all_moved,
}
"""What a wrong table of the front end does to codes, by the class's name."""


def lines(design: Design, stream: Stream) -> set[str]:
    """The kinds of warnings about a recording of ``stream``: without their numbers."""
    shape = -1, design.sensor.rows, design.sensor.columns
    codes = stream.words.reshape(shape)
    levels, alive = codes.astype(float), np.ones(shape[1:], dtype=bool)
    stress = levels * design.adc.lsb
    before = list(doubts(levels, None, design.adc, GIVEN, alive))
    found = warnings(design, stress, design.float_model(stress).status, GIVEN, before)
    return {re.sub(r"\d\S*", "N", line) for line in found}


def told(design: Design, blocks: int, seed: int) -> dict[str, dict[str, Any]]:
    """By class: recordings with another kind of warning than the same one without the fault."""
    found = {}
    for name, plant in (FAULTS | CALIBRATION).items():
        new: list[set[str]] = []
        for block in range(blocks):
            both = []
            for faulty in (False, True):
                rng = np.random.default_rng([seed, block])
                stream = clean(design, 1 + FRAMES, 100, rng)
                stream.last = FRAMES
                if faulty:
                    plant(stream, 1, int(rng.integers(design.sensor.taxels)), rng)
                stream.words = stream.words[1:]
                both.append(lines(design, stream))
            if stream.odd or stream.words.min() < stream.low or stream.words.max() >= -stream.low:
                break  # no recording has such frames or words
            new.append(both[1] - both[0])
        else:
            kinds = sorted(set().union(*new))
            found[name] = {"blocks": blocks, "told": sum(map(bool, new)), "by": kinds}
    return found
