"""Cordic against its model: any vector, in every cycle, constant latency; the senses of the rotations."""

import math
import random
from typing import Any

import numpy as np
import pytest
from amaranth import Cat, Module
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out, connect, flipped

from tests.hdl.parallel.designs import make
from tfra.hdl.lib.pipeline import delayed
from tfra.hdl.lib.streams import always_ready_stream
from tfra.hdl.parallel.cordic import Cordic, cordic_latency, cordic_modulus, cordic_vector, cordic_word
from tfra.model.choices import Formats
from tfra.model.fixed.cordic import ANGLE_GUARD, angle_table, cordic, cordic_gain, iterations
from tfra.model.fixed.design import Design
from tfra.sim.harness import PATTERNS, run

DESIGNS = {
    "standard": make(4, 4),
    "wide": make(4, 4, "wide"),
    "long": make(4, 4, Formats("long", 27, 27, 9, 4)),
}


class Turned(wiring.Component):
    """A Cordic with the senses of all rotations of a vector beside its modulus."""

    def __init__(self, design: Design) -> None:
        self.cordic = Cordic(design)
        turned = data.StructLayout({"modulus": cordic_modulus(design), "negative": iterations(design)})
        vector = always_ready_stream(cordic_vector(design))
        super().__init__({"vector": In(vector), "turned": Out(always_ready_stream(turned))})

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.cordic = cordic = self.cordic
        connect(m, flipped(self.vector), cordic.vector)
        senses = [delayed(m, sense, len(cordic.negative) - number) for number, sense in enumerate(cordic.negative)]
        m.d.comb += [
            self.turned.valid.eq(cordic.turned.valid),
            self.turned.p.modulus.eq(cordic.turned.p),
            self.turned.p.negative.eq(Cat(senses)),
        ]
        return m


def vectors(design: Design, seed: int) -> list[dict[str, int]]:
    top = (1 << (cordic_word(design).width - 1)) - 1
    corners = [0, 1, -1, 2, top, -top, -top - 1]
    pairs = [(x, y) for x in corners for y in corners]
    rng = random.Random(seed)
    for bits in range(1, cordic_word(design).width):
        pairs.append((rng.randrange(-1 << bits, 1 << bits), rng.randrange(-1 << bits, 1 << bits)))
    return [{"x": x, "y": y} for x, y in pairs]


def expected(design: Design, sent: list[dict[str, int]]) -> list[tuple[int, int]]:
    modulus, angle = cordic(design, np.array([v["x"] for v in sent]), np.array([v["y"] for v in sent]))
    return list(zip(modulus.tolist(), angle.tolist(), strict=True))


def found(design: Design, sent: list[dict[str, int]], turned: list[dict[str, int]]) -> list[tuple[int, int]]:
    """Moduli, and the angles that the senses make."""
    bits, result = design.formats.operand + ANGLE_GUARD, []
    for vector, word in zip(sent, turned, strict=True):
        angle = (vector["x"] < 0) << (bits - 1)
        for number, step in enumerate(angle_table(design)):
            angle += -step if word["negative"] >> number & 1 else step
        rounded = (angle + (1 << (ANGLE_GUARD - 1))) >> ANGLE_GUARD
        result.append((word["modulus"], rounded % (1 << design.formats.operand)))
    return result


@pytest.mark.parametrize("name", DESIGNS)
@pytest.mark.parametrize("stall_in", PATTERNS)
def test_equals_the_model(name, stall_in):
    design = DESIGNS[name]
    sent = vectors(design, seed=1)
    seen = run(Turned(design), {"vector": sent}, {"turned": len(sent)}, stall_in=stall_in, seed=1)
    assert found(design, sent, seen.values["turned"]) == expected(design, sent), "seed 1"


@pytest.mark.parametrize("name", DESIGNS)
def test_latency(name):
    """A vector a cycle."""
    sent = vectors(DESIGNS[name], seed=3)[:8]
    seen = run(Turned(DESIGNS[name]), {"vector": sent}, {"turned": len(sent)}).cycles
    assert set(np.diff(seen["vector"])) == {1}
    waits = {out - into for into, out in zip(seen["vector"], seen["turned"], strict=True)}
    assert waits == {cordic_latency(DESIGNS[name])}


def test_values_known_by_heart():
    design = DESIGNS["wide"]
    scale, turn = 1 << 20, 1 << design.formats.operand
    sent = [{"x": 3 * scale, "y": 4 * scale}, {"x": -scale, "y": 0}, {"x": 0, "y": -scale}, {"x": scale, "y": scale}]
    seen = found(design, sent, run(Turned(design), {"vector": sent}, {"turned": len(sent)}).values["turned"])
    lengths = [modulus / cordic_gain(design) / scale for modulus, _ in seen]
    assert lengths == pytest.approx([5, 1, 1, math.sqrt(2)], rel=1e-4)
    angles = [angle / turn for _, angle in seen]
    assert angles == pytest.approx([math.atan2(4, 3) / (2 * math.pi), 0.5, 0.75, 0.125], abs=1e-5)


def test_a_wrong_bit_is_noticed():
    design = DESIGNS["standard"]
    sent = vectors(design, seed=4)[:3]
    turned = run(Turned(design), {"vector": sent}, {"turned": 3}).values["turned"]
    turned[1]["negative"] ^= 1
    assert found(design, sent, turned) != expected(design, sent)
