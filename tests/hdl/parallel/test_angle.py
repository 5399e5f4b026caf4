"""Angle against the model of the CORDIC: both users at once, any stalls of one, constant latency for the other."""

import random

import numpy as np
import pytest

from tests.hdl.parallel.designs import Joined, make
from tests.marks import STALLS
from tfra.hdl.lib.streams import PerFrameFifo
from tfra.hdl.parallel.angle import Angle
from tfra.hdl.parallel.cordic import cordic_latency, cordic_modulus, cordic_word
from tfra.model.choices import DIVISION_GUARD
from tfra.model.fixed.cordic import cordic
from tfra.model.fixed.design import Design
from tfra.sim.harness import flowing, run

NUMBER = 30


def design(formats: str) -> Design:
    return make(3, 4, formats)


def stored(d: Design) -> Joined:
    """Angle with a place for every modulus, which it does not wait for."""
    moduli = PerFrameFifo(cordic_modulus(d), (), NUMBER)
    return Joined([("angle.turned", "moduli.i")], angle=Angle(d), moduli=moduli)


def inputs(d: Design, seed: int) -> dict[str, list[dict[str, int]]]:
    rng = random.Random(seed)
    sign, word = d.formats.operand - 1, cordic_word(d).width - 1
    return {
        "angle.vector": [{w: rng.randrange(1 << word) >> rng.randrange(word) for w in "xy"} for _ in range(NUMBER)],
        "angle.direction": [{w: rng.randrange(-1 << sign, 1 << sign) for w in ("cos", "sin")} for _ in range(NUMBER)],
    }


def expected(d: Design, sent: dict[str, list[dict[str, int]]]) -> dict[str, list[int]]:
    x, y = (np.array([v[axis] for v in sent["angle.vector"]]) for axis in "xy")
    cos, sin = (np.array([v[word] for v in sent["angle.direction"]]) << DIVISION_GUARD for word in ("cos", "sin"))
    return {"moduli.o": cordic(d, x, y)[0].tolist(), "angle.phi": cordic(d, cos, sin)[1].tolist()}


@pytest.mark.parametrize("formats", ["standard", "wide"])
@pytest.mark.parametrize(("stall_in", "stall_out"), STALLS)
def test_both_users_get_their_own(formats, stall_in, stall_out):
    d = design(formats)
    sent = inputs(d, 1)
    want = expected(d, sent)
    ports = {name: NUMBER for name in want}
    seen = run(stored(d), sent, ports, stall_in=stall_in, stall_out=stall_out, seed=1)
    assert {name: seen.values[name] for name in want} == want


def test_directions_never_hold_up_a_vector():
    d = design("standard")
    sent, dut = inputs(d, 2), stored(d)
    seen = run(dut, sent, {"moduli.o": NUMBER, "angle.phi": NUMBER}, stall_in=flowing).cycles
    assert set(np.diff(seen["angle.vector"])) == {1}
    waits = {out - into for into, out in zip(seen["angle.vector"], seen["moduli.o"], strict=True)}
    assert waits == {cordic_latency(d) + PerFrameFifo.latency}


def test_a_wrong_bit_is_noticed():
    d = design("standard")
    sent = inputs(d, 3)
    wrong = expected(d, sent)
    wrong["angle.phi"][7] ^= 1
    assert run(stored(d), sent, {"angle.phi": NUMBER}).values["angle.phi"] != wrong["angle.phi"]
