"""Gain against its model: every rule, any stalls, constant latency."""

from dataclasses import fields
from typing import Any

import numpy as np
import pytest

from tests.hdl.parallel.designs import Joined, make
from tests.marks import STALLS
from tfra.hdl.parallel import payloads
from tfra.hdl.parallel.angle import Angle
from tfra.hdl.parallel.gain import Gain
from tfra.model.choices import Formats
from tfra.model.fixed.design import Design
from tfra.model.fixed.gain import Resultant, gain, normal_gain
from tfra.model.fixed.normaliser import Normalised
from tfra.sim.harness import run

DESIGNS = {
    "4x4": make(4, 4, threshold=0),
    "3x5 wide": make(3, 5, "wide", threshold=0),
    "10x10": make(10, 10, threshold=0),
    "2x2 long": make(2, 2, Formats("long", 27, 27, 16, 0), bits=6, thickness=1, threshold=0),
    "3x2 short": make(3, 2, Formats("short", 10, 10, 0, 16), bits=6, thickness=8, threshold=0),
}


def with_cordic(d: Design) -> Joined:
    """Gain and the CORDIC that it asks."""
    ports = {"total": "gain.total", "frame": "gain.frame", "gain": "gain.gain"}
    wires = [("gain.vector", "angle.vector"), ("angle.turned", "gain.turned")]
    return Joined({"gain": Gain(d), "angle": Angle(d)}, ports, wires)


Case = tuple[Resultant, Normalised]


def facts(d: Design, contact: Any, traction: Any, magnitude: Any) -> Normalised:
    none = np.zeros(len(magnitude), dtype=np.int64)
    return Normalised(none[:, None], none, magnitude, contact, traction, none > 0)


def random_case(d: Design, n: int, seed: int) -> Case:
    """Any resultants that are normalised, or not even that."""
    rng, w = np.random.default_rng(seed), d.widths
    top = (1 << (w.division - 1)) - 1
    words = rng.integers(-top - 1, top + 1, (n, 3)) >> rng.integers(0, w.division, (n, 3))
    words = np.where(rng.random((n, 3)) < 0.25, rng.choice([0, 1, -1, top, -top, -top - 1], (n, 3)), words)
    magnitude = rng.integers(1, 1 << w.magnitude, n) >> rng.integers(0, w.magnitude, n)
    frame = facts(d, rng.random(n) < 0.85, rng.random(n) < 0.85, magnitude)
    return Resultant(words, rng.integers(-40, 60, n)), frame


def corner_case(d: Design) -> Case:
    """Every triple of zeros, units and limits, with the smallest and the largest magnitude."""
    w = d.widths
    top = (1 << (w.division - 1)) - 1
    words = np.array([(x, y, z) for x in (0, top) for y in (0, -top - 1) for z in (0, 1, -top - 1)])
    # tangential and four times normal close together: where mu leaves its range
    near = [(x, 0, (x >> 2) + delta) for x in (top & ~3, top >> 3 & ~3) for delta in (-1, 0, 1)]
    words = np.concatenate([words, near])
    words, n = np.concatenate([words, words]), 2 * len(words)
    magnitude = np.where(np.arange(n) % 2, 1, (1 << w.magnitude) - 1)
    magnitude[3] = 0
    return Resultant(words, np.arange(n) - 20), facts(d, np.full(n, True), np.full(n, True), magnitude)


def streams(d: Design, case: Case) -> dict[str, list[Any]]:
    total, frame = case
    return {
        "total": [
            {"words": w, "exponent": e} for w, e in zip(total.words.tolist(), total.exponent.tolist(), strict=True)
        ],
        "frame": [
            {"magnitude": int(m), "contact": int(c), "traction": int(t)}
            for m, c, t in zip(frame.magnitude, frame.contact, frame.traction, strict=True)
        ],
    }


def expected(d: Design, case: Case) -> list[dict[str, int]]:
    """The model's gain; shifts that leave nothing of any word are alike."""
    found = gain(d, *case)
    layout = payloads.gain(d).members
    columns = {f.name: getattr(found, f.name) for f in fields(found)}
    for name in ("force_shift", "resultant_shift"):
        columns[name] = np.minimum(columns[name], (1 << layout[name].width) - 1)
    return [{name: int(column[i]) for name, column in columns.items()} for i in range(len(found.mu))]


def check(d: Design, case: Case, note: str, **stalls: Any) -> None:
    wanted = expected(d, case)
    assert run(with_cordic(d), streams(d, case), {"gain": len(wanted)}, **stalls).values["gain"] == wanted, note


@pytest.mark.parametrize("name", DESIGNS)
def test_equals_the_model(name):
    check(DESIGNS[name], random_case(DESIGNS[name], 20, 1), f"{name}, seed 1")


@pytest.mark.parametrize("name", ["4x4", "2x2 long", "3x2 short"])
def test_corners(name):
    check(DESIGNS[name], corner_case(DESIGNS[name]), name)


@pytest.mark.parametrize(("stall_in", "stall_out"), STALLS)
def test_survives_stalls(stall_in, stall_out):
    d = DESIGNS["3x2 short"]
    check(d, random_case(d, 6, 2), "seed 2", stall_in=stall_in, stall_out=stall_out, seed=2)


def test_rules_in_literal_numbers():
    """No normal force: mu is at its limit.  No force at all: so is the gain.  Not regular: the plain gain."""
    d = DESIGNS["4x4"]
    top = (1 << (d.widths.division - 1)) - 1
    words = np.array([[top, 0, 0], [0, 0, 0], [top, top, top], [0, 0, -top], [top // 2, 0, -top]])
    regular = np.array([True, True, False, True, True])
    frame = facts(d, np.full(5, True), regular, np.full(5, 1 << 16))
    case = Resultant(words, np.zeros(5, dtype=np.int64)), frame
    check(d, case, "literal")
    seen = run(with_cordic(d), streams(d, case), {"gain": 5}).values["gain"]
    limit = (1 << d.formats.operand) - 1
    assert [g["mu"] for g in seen] == [limit >> 1, limit >> 1, 0, 0, pytest.approx(1 << d.formats.operand - 4, abs=2)]
    assert [g["overflow"] for g in seen] == [1, 1, 0, 0, 0]
    assert [seen[1]["mantissa"], seen[2]["mantissa"]] == [limit, normal_gain(d)[0]]


@pytest.mark.parametrize("name", DESIGNS)
def test_latency(name):
    d = DESIGNS[name]
    dut = with_cordic(d)
    latency = dut.blocks["gain"].latency
    seen = run(dut, streams(d, random_case(d, 4, 4)), {"gain": 4}).cycles
    assert seen["gain"][0] == 1 + latency  # inputs are valid in the first cycle, number 1
    assert set(np.diff(seen["gain"])) == {latency + 2}
    assert seen["total"] == seen["frame"] == seen["gain"]


def test_a_wrong_bit_is_noticed():
    d = DESIGNS["3x2 short"]
    case = random_case(d, 3, 5)
    wrong = expected(d, case)
    wrong[2]["mantissa"] ^= 1
    assert run(with_cordic(d), streams(d, case), {"gain": 3}).values["gain"] != wrong
