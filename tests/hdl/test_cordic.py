"""Cordic against its model: any vector, at any time, constant latency; what an urgent one throws out."""

from __future__ import annotations

import math
import random
from typing import Any

import numpy as np
import pytest
from amaranth import Module
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out, connect, flipped
from amaranth.sim import Simulator

from tests.hdl.harness import PATTERNS, flowing, run
from tfra.hdl.cordic import Cordic, cordic_vector, cordic_word
from tfra.hdl.streams import Facts
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


class Kept(wiring.Component):
    """A Cordic with a place for every result, which it does not wait for."""

    def __init__(self, design: Design, number: int) -> None:
        self.cordic, self._number = Cordic(design), number
        self._turned = self.cordic.turned.payload.shape()
        super().__init__(
            {
                "vector": In(stream.Signature(cordic_vector(design))),
                "turned": Out(stream.Signature(self._turned)),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.cordic = cordic = self.cordic
        m.submodules.kept = kept = Facts(self._turned, (), self._number)
        connect(m, flipped(self.vector), cordic.vector)
        connect(m, cordic.turned, kept.i)
        connect(m, kept.o, flipped(self.turned))
        return m


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
    return [{"modulus": int(r), "angle": int(a), "urgent": 0} for r, a in zip(modulus, angle, strict=True)]


@pytest.mark.parametrize("name", DESIGNS)
def test_equals_the_model(name):
    design = DESIGNS[name]
    sent = vectors(design, seed=1)
    seen = run(Kept(design, len(sent)), {"vector": sent}, {"turned": len(sent)})
    assert seen.values["turned"] == expected(design, sent), "seed 1"


@pytest.mark.parametrize("stall_in", PATTERNS)
@pytest.mark.parametrize("stall_out", PATTERNS)
def test_survives_stalls(stall_in, stall_out):
    design = DESIGNS["standard"]
    sent = vectors(design, seed=2)[-12:]
    ports = {"vector": sent}, {"turned": len(sent)}
    seen = run(Kept(design, len(sent)), *ports, stall_in=stall_in, stall_out=stall_out, seed=2)
    assert seen.values["turned"] == expected(design, sent), "seed 2"


@pytest.mark.parametrize("name", DESIGNS)
def test_latency(name):
    sent = vectors(DESIGNS[name], seed=3)[:8]
    dut = Kept(DESIGNS[name], len(sent))
    seen = run(dut, {"vector": sent}, {"turned": len(sent)}, stall_in=flowing, stall_out=flowing).cycles
    waits = {out - into for into, out in zip(seen["vector"], seen["turned"], strict=True)}
    assert waits == {dut.cordic.latency + Facts.latency}
    # Two at a time, one behind the other.
    assert np.diff(seen["vector"]).tolist() == [1, dut.cordic.latency, 1, dut.cordic.latency, 1, dut.cordic.latency, 1]


def test_values_known_by_heart():
    design = DESIGNS["wide"]
    scale, turn = 1 << 20, 1 << design.formats.operand
    sent = [{"x": 3 * scale, "y": 4 * scale}, {"x": -scale, "y": 0}, {"x": 0, "y": -scale}, {"x": scale, "y": scale}]
    seen = run(Kept(design, len(sent)), {"vector": sent}, {"turned": len(sent)}).values["turned"]
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
    assert run(Kept(design, len(sent)), {"vector": sent}, {"turned": 3}).values["turned"] != wrong


@pytest.mark.parametrize("gap", range(1, 50))
def test_an_urgent_vector_goes_first(gap):
    """It throws out the other one if, and only if, that is in its place; both are right, or one of them is lost."""
    design = DESIGNS["standard"]
    dut, found = Cordic(design), list[dict[str, int]]()
    sent = [{"x": 1000, "y": -300}, {"x": -77, "y": 5000}]
    lost = list[int]()

    async def testbench(ctx: Any) -> None:
        for cycle in range(gap + dut.latency + 1):
            urgent = cycle == gap
            ctx.set(dut.urgent, urgent)
            ctx.set(dut.vector.valid, cycle in (0, gap))
            ctx.set(dut.vector.p, sent[urgent])
            assert cycle not in (0, gap) or ctx.get(dut.vector.ready)
            lost.append(ctx.get(dut.lost))
            if ctx.get(dut.turned.valid):
                turned = dut.turned.p
                found.append({name: ctx.get(getattr(turned, name)) for name in ("modulus", "angle", "urgent")})
            await ctx.tick()

    simulator = Simulator(dut)
    simulator.add_clock(1e-6)
    simulator.add_testbench(testbench)
    simulator.run()
    first, second = expected(design, sent)
    collide = gap % 2 == 0 and gap < dut.latency
    assert lost == [int(collide and cycle == gap) for cycle in range(len(lost))]
    assert found == ([] if collide else [first]) + [{**second, "urgent": 1}]
