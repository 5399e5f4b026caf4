"""Cordic against its model: any vector, any stalls, constant latency."""

from __future__ import annotations

import math
import random

import numpy as np
import pytest

from tests.hdl.harness import PATTERNS, flowing, run
from tfra.hdl.cordic import Cordic, cordic_word
from tfra.model.design import FORMATS, Architecture, Design, Formats
from tfra.model.fixed.cordic import cordic, cordic_gain
from tfra.model.sensor import SensorArray

SENSOR = SensorArray(4, 4, 4e-3, 4e-3, 3e-3)
SINGLE = Architecture(1)
DESIGNS = {
    "standard": Design(SENSOR, architecture=SINGLE),
    "wide": Design(SENSOR, formats=FORMATS["wide"], architecture=SINGLE),
    "long": Design(SENSOR, formats=Formats("long", 27, 27, 9, 4), architecture=SINGLE),
}


def vectors(design: Design, seed: int) -> list[dict[str, int]]:
    top = (1 << (cordic_word(design).width - 1)) - 1
    corners = [0, 1, -1, 2, top, -top, -top - 1]
    pairs = [(x, y) for x in corners for y in corners]
    rng = random.Random(seed)
    for bits in range(1, cordic_word(design).width):
        pairs.append((rng.randrange(-1 << bits, 1 << bits), rng.randrange(-1 << bits, 1 << bits)))
    return [{"x": x, "y": y} for x, y in pairs]


def expected(design: Design, sent: list[dict[str, int]]) -> list[dict[str, int]]:
    modulus, angle = cordic(design, np.array([v["x"] for v in sent]), np.array([v["y"] for v in sent]))
    return [{"modulus": int(r), "angle": int(a)} for r, a in zip(modulus, angle, strict=True)]


@pytest.mark.parametrize("name", DESIGNS)
def test_equals_the_model(name):
    design = DESIGNS[name]
    sent = vectors(design, seed=1)
    seen = run(Cordic(design), {"i": sent}, {"o": len(sent)})
    assert seen.values["o"] == expected(design, sent), "seed 1"


@pytest.mark.parametrize("stall_in", PATTERNS)
@pytest.mark.parametrize("stall_out", PATTERNS)
def test_survives_stalls(stall_in, stall_out):
    design = DESIGNS["standard"]
    sent = vectors(design, seed=2)[-12:]
    seen = run(Cordic(design), {"i": sent}, {"o": len(sent)}, stall_in=stall_in, stall_out=stall_out, seed=2)
    assert seen.values["o"] == expected(design, sent), "seed 2"


@pytest.mark.parametrize("name", DESIGNS)
def test_latency(name):
    dut = Cordic(DESIGNS[name])
    sent = vectors(DESIGNS[name], seed=3)[:8]
    seen = run(dut, {"i": sent}, {"o": len(sent)}, stall_in=flowing, stall_out=flowing)
    assert {o - i for i, o in zip(seen.cycles["i"], seen.cycles["o"], strict=True)} == {dut.latency}
    assert set(np.diff(seen.cycles["o"])) == {1}


def test_values_known_by_heart():
    design = DESIGNS["wide"]
    scale, turn = 1 << 20, 1 << design.formats.operand
    sent = [{"x": 3 * scale, "y": 4 * scale}, {"x": -scale, "y": 0}, {"x": 0, "y": -scale}, {"x": scale, "y": scale}]
    seen = run(Cordic(design), {"i": sent}, {"o": len(sent)}).values["o"]
    lengths = [v["modulus"] / cordic_gain(design) / scale for v in seen]
    assert lengths == pytest.approx([5, 1, 1, math.sqrt(2)], rel=1e-4)
    assert [v["angle"] / turn for v in seen] == pytest.approx(
        [math.atan2(4, 3) / (2 * math.pi), 0.5, 0.75, 0.125], abs=1e-5
    )


def test_a_wrong_bit_is_noticed():
    design = DESIGNS["standard"]
    sent = vectors(design, seed=4)[:3]
    wrong = expected(design, sent)
    wrong[1]["angle"] ^= 1
    assert run(Cordic(design), {"i": sent}, {"o": 3}).values["o"] != wrong
