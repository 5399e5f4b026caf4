"""Gain against its model: every rule, any stalls, constant latency."""

from dataclasses import fields
from typing import Any

import numpy as np
import pytest

from tests.hdl.parallel.designs import Joined, make
from tests.hdl.parallel.facts import frame_facts, transfers
from tests.marks import STALLS, long
from tfra.hdl.parallel import payloads
from tfra.hdl.parallel.angle import Angle
from tfra.hdl.parallel.gain import Gain
from tfra.model.choices import Formats
from tfra.model.fixed.design import Design
from tfra.model.fixed.gain import Resultant, gain, normal_gain
from tfra.model.fixed.normaliser import Normalised
from tfra.sim.harness import Recording, run

DESIGNS = {
    "4x4": make(4, 4, threshold=0),
    "3x5 wide": make(3, 5, "wide", threshold=0),
    "10x10": make(10, 10, threshold=0),
    "2x2 long": make(2, 2, Formats("long", 27, 27, 16, 0), bits=6, thickness=1, threshold=0),
    "3x2 short": make(3, 2, Formats("short", 10, 10, 0, 16), bits=6, thickness=8, threshold=0),
}

Case = tuple[Resultant, Normalised]


def random_case(d: Design, n: int, seed: int) -> Case:
    """Any resultants that are normalised, or not even that."""
    rng, w = np.random.default_rng(seed), d.widths
    top = (1 << (w.division - 1)) - 1
    words = rng.integers(-top - 1, top + 1, (n, 3)) >> rng.integers(0, w.division, (n, 3))
    words = np.where(rng.random((n, 3)) < 0.25, rng.choice([0, 1, -1, top, -top, -top - 1], (n, 3)), words)
    magnitude = rng.integers(1, 1 << w.magnitude, n) >> rng.integers(0, w.magnitude, n)
    frame = frame_facts(rng.random(n) < 0.85, rng.random(n) < 0.85, magnitude)
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
    return Resultant(words, np.arange(n) - 20), frame_facts(np.full(n, True), np.full(n, True), magnitude)


def send(dut: Joined, case: Case, **stalls: Any) -> Recording:
    total, frame = map(transfers, case)
    return run(dut, {"gain.total": total, "gain.frame": frame}, {"gain.gain": len(total)}, **stalls)


def with_cordic(d: Design) -> Joined:
    """Gain and the CORDIC that it asks."""
    wires = [("gain.vector", "angle.vector"), ("angle.turned", "gain.turned")]
    return Joined(wires, gain=Gain(d), angle=Angle(d))


def expected(d: Design, case: Case) -> list[dict[str, int]]:
    """The model's gain; shifts that leave nothing of any word are alike."""
    found = gain(d, *case)
    layout = payloads.gain(d).members
    columns = {f.name: getattr(found, f.name) for f in fields(found)}
    for name in ("force_shift", "resultant_shift"):
        columns[name] = np.minimum(columns[name], (1 << layout[name].width) - 1)
    return [{name: int(column[i]) for name, column in columns.items()} for i in range(len(found.mu))]


def check(d: Design, case: Case, **stalls: Any) -> Recording:
    """Words, and the latency when nothing stalls."""
    dut = with_cordic(d)
    seen, latency = send(dut, case, **stalls), dut.gain.latency
    assert seen.values["gain.gain"] == expected(d, case)
    cycles = seen.cycles["gain.gain"]
    if not stalls:  # inputs are valid in the first cycle, number 1
        assert cycles == [1 + latency + (latency + 2) * number for number in range(len(cycles))]
        assert seen.cycles["gain.total"] == seen.cycles["gain.frame"] == cycles
    return seen


@pytest.mark.parametrize("name", ["4x4", "3x2 short", *long("3x5 wide", "10x10", "2x2 long")])
def test_equals_the_model(name):
    check(DESIGNS[name], random_case(DESIGNS[name], 20, 1))


@pytest.mark.parametrize("name", ["4x4", "3x2 short", *long("2x2 long")])
def test_corners(name):
    check(DESIGNS[name], corner_case(DESIGNS[name]))


@pytest.mark.parametrize(("stall_in", "stall_out"), STALLS)
def test_survives_stalls(stall_in, stall_out):
    d = DESIGNS["3x2 short"]
    check(d, random_case(d, 6, 2), stall_in=stall_in, stall_out=stall_out, seed=2)


def test_rules_in_literal_numbers():
    """No normal force: mu is at its limit.  No force at all: so is the gain.  Not regular: the plain gain."""
    d = DESIGNS["4x4"]
    top = (1 << (d.widths.division - 1)) - 1
    words = np.array([[top, 0, 0], [0, 0, 0], [top, top, top], [0, 0, -top], [top // 2, 0, -top]])
    frame = frame_facts(np.full(5, True), np.arange(5) != 2, 1 << 16)
    seen = check(d, (Resultant(words, np.zeros(5, dtype=np.int64)), frame)).values["gain.gain"]
    limit = (1 << d.formats.operand) - 1
    assert [g["mu"] for g in seen] == [limit >> 1, limit >> 1, 0, 0, pytest.approx(1 << d.formats.operand - 4, abs=2)]
    assert [g["overflow"] for g in seen] == [1, 1, 0, 0, 0]
    assert [seen[1]["mantissa"], seen[2]["mantissa"]] == [limit, normal_gain(d)[0]]


def test_a_wrong_bit_is_noticed():
    d = DESIGNS["3x2 short"]
    case = random_case(d, 3, 5)
    wrong = expected(d, case)
    wrong[2]["mantissa"] ^= 1
    assert send(with_cordic(d), case).values["gain.gain"] != wrong
