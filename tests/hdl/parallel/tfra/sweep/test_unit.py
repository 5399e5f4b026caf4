"""The sweep chooses the model's candidate, for contacts and for data made to tie, under any stalls."""

import itertools
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.hdl.parallel import designs
from tests.marks import STALLS, long
from tfra.hdl.lib.butterfly import Butterfly
from tfra.hdl.lib.streams import Buffer, Fifo
from tfra.hdl.parallel.tfra.combine.store import FRAMES
from tfra.hdl.parallel.tfra.sweep.unit import Sweep
from tfra.model.fixed.butterfly import butterfly, to_quads, to_taxels
from tfra.model.fixed.normaliser import normaliser
from tfra.model.fixed.tfra.centroids import centroids
from tfra.model.fixed.tfra.operators import PRODUCTS
from tfra.model.fixed.tfra.pipeline import FixedTfra
from tfra.model.fixed.tfra.sweep import sweep
from tfra.sim.harness import apart, bursts, flowing, run


def make(rows, columns, steps, tolerance=0.0, formats="standard", **choices):
    return designs.make(rows, columns, formats, steps=steps, tolerance=tolerance, threshold=0, **choices)


@dataclass
class Frames:
    """What goes in, frame by frame: ``stress, g (n, Q, 4)``, ``normal (n, 2 Q, 4)``."""

    stress: np.ndarray
    g: np.ndarray
    normal: np.ndarray
    negative: np.ndarray
    exponent: np.ndarray

    def __add__(self, other):
        pairs = zip(vars(self).values(), vars(other).values(), strict=True)
        return Frames(*(np.concatenate(pair) for pair in pairs))


def expected(design, frames):
    q = design.quads
    p = butterfly(frames.normal[:, :q] - frames.g)
    slope = butterfly(frames.normal[:, q:])
    taxels = (to_taxels(design, v) for v in (frames.stress, p, slope))
    return sweep(design, *taxels, frames.negative, frames.exponent).index


def contacts(design, number, seed):
    """Vectors of the model for random codes, small and large ones."""
    rng = np.random.default_rng(seed)
    top = 1 << (design.adc.bits - 1)
    codes = rng.integers(-top, top, (number, design.sensor.taxels))
    codes >>= rng.integers(0, design.adc.bits - 2, (number, 1))
    model = FixedTfra(design)
    stages = model(codes.reshape(number, design.sensor.rows, design.sensor.columns)).stages
    start = [0, *np.cumsum([design.stacks[name].quads for name in PRODUCTS])]
    sums = 3  # quads of sums, ahead of g
    g = stages["matvec"][:, start[1] + sums : start[1] + sums + design.quads]
    normal = stages["matvec"][:, start[2] : start[4]]
    negative, exponent = centroids(design, codes).negative, normaliser(design, codes).exponent
    return Frames(stages["normaliser"], g, normal, negative, exponent)


def synthetic(design, stress, p, slope, negative, exponent, seed=0):
    """Frames with ``4 p`` and ``4 slope (n, m)`` behind the butterfly and a random g."""
    g = np.random.default_rng(seed).integers(-999, 999, (len(p), design.quads, 4))
    # Odd parities of a middle line vanish in g as they do in every folded vector.
    g = butterfly(to_quads(design, to_taxels(design, g)))
    normal = np.concatenate([butterfly(to_quads(design, p)) + g, butterfly(to_quads(design, slope))], axis=1)
    assert np.abs(normal).max() < 1 << (design.widths.vector - 1)
    return Frames(to_quads(design, stress), g, normal, np.asarray(negative, bool), np.asarray(exponent))


def room(design):
    """Bound of |p| + |q| that keeps every sum in its word."""
    return (1 << (design.widths.candidate - 4)) // design.search.steps


def adversaries(design):
    """Ties, plateaus, zeros, extremes, winners at both ends, sweeps from -1."""
    m, k = design.sensor.taxels, design.search.steps
    top, large = (1 << (design.adc.bits - 1)) - 1, room(design) // 2
    one, zero = np.ones(m, np.int64), np.zeros(m, np.int64)
    sides = np.where(np.arange(m) % 2, 1, -1)
    unit = 1 << design.formats.vector_fraction
    rows = [  # stress, p, slope, negative
        (zero, zero, zero, 0),
        (one, zero, zero, 1),
        (-one, -large * one, one, 0),  # plateau of B^z everywhere
        (top * one, -large * one, -large * one, 0),
        (-(top + 1) * one, large * one, -large * one, 0),  # last wins
        (top * sides, large * one, large * one, 1),
        (top * sides, large * sides, -large * sides, 0),
        (sides, unit * sides, -2 * unit * sides, 0),  # symmetrical: ties between both halves
        (-sides, -unit * one + unit * sides, 2 * unit * sides, 1),
        (one, -4 * k * unit * one, unit * sides, 0),
        (-one, large * one, large * one, 1),
        (sides * top, -one, sides, 0),
    ]
    stress, p, slope, negative = (np.array(v) for v in zip(*rows, strict=True))
    return synthetic(design, stress, p, slope, negative, np.arange(len(rows)) % design.adc.bits)


def small_numbers(design, number, seed):
    """Tiny words, so that both sums tie often."""
    rng = np.random.default_rng(seed)
    shape, unit = (number, design.sensor.taxels), 1 << design.formats.vector_fraction
    p, slope = (rng.integers(-1, 2, shape) * unit for _ in range(2))
    negative, exponent = rng.integers(0, 2, number), rng.integers(0, design.adc.bits, number)
    return synthetic(design, rng.integers(-1, 2, shape), p, slope, negative, exponent, seed)


def transfers(frames):
    def quads(vectors):
        return vectors.reshape(-1, 4).tolist()

    return {
        "stress": quads(frames.stress),
        "g": quads(frames.g),
        "normal": quads(frames.normal),
        "direction": [{"cos": 1, "sin": -1, "sweep_y": 1, "negative": int(v), "vanishing": 0} for v in frames.negative],
        "frame": [
            {"exponent": int(v), "magnitude": 1, "contact": 1, "traction": 1, "saturated": 0} for v in frames.exponent
        ],
    }


def simulate(design, frames, stall_in=flowing, **how):
    """Vectors of ``FRAMES`` frames at most, quads as far apart as the queues need; normal ones behind the rest."""
    q, passed = design.quads, Fifo.latency + design.cycles_per_quad

    def leave(quads):
        return lambda quad, record, cycle: len(record.cycles["index"]) > quad // quads - FRAMES

    def there(quad, record, cycle):
        before = [record.cycles[name][(quad // (2 * q) + 1) * q - 1 :][:1] for name in ("g", "stress")]
        return leave(2 * q)(quad, record, cycle) and all(last and cycle > last[0] + passed for last in before)

    places = {"g": leave(q), "normal": there}
    stall_in = apart(stall_in, design.cycles_per_quad)
    return run(Sweep(design), transfers(frames), {"index": len(frames.g)}, leave=places, stall_in=stall_in, **how)


def check(design, frames, seed=0, **how):
    found = simulate(design, frames, seed=seed, **how).values["index"]
    assert found == expected(design, frames).tolist(), f"seed {seed}"


DESIGNS = [
    make(4, 4, 7),
    make(4, 4, 7, tolerance=1.5),
    make(5, 7, 7, tolerance=0.3),
    make(3, 3, 1),
    make(3, 3, 1, tolerance=40.0, formats="wide"),
    make(3, 2, 2),
    make(2, 2, 7, bits=6),
    make(2, 2, 100),
    make(3, 4, 7, words=1),
    make(4, 4, 5, tolerance=0.7, words=2),
    make(4, 6, 100, formats="wide", bits=16),
    make(5, 4, 13, tolerance=1e9, formats="wide", bits=20),
]


@pytest.mark.parametrize("design", [*DESIGNS[3:8:2], DESIGNS[8], *long(*DESIGNS[:3], *DESIGNS[4:8:2], *DESIGNS[9:])])
def test_contacts_and_adversaries(design):
    check(design, contacts(design, 3, 1) + adversaries(design) + small_numbers(design, 6, 2))


def test_a_large_array():
    design = make(10, 10, 20)
    check(design, contacts(design, 3, 5))


@pytest.mark.parametrize(("stall_in", "stall_out"), STALLS)
@pytest.mark.parametrize("design", [make(3, 4, 7, tolerance=0.7), make(2, 3, 3)])
def test_any_stalls(design, stall_in, stall_out):
    frames = contacts(design, 2, 6) + small_numbers(design, 3, 6)
    check(design, frames, 6, stall_in=stall_in, stall_out=stall_out)


def predicted(design, cycles):
    """Cycle of every index from the transfers into the unit, by the rules of Sweep's docstring."""
    unit, q = Sweep(design), design.quads
    normal = np.reshape(cycles["normal"], (-1, 2 * q)) + Fifo.latency + design.cycles_per_quad - 1
    facts = np.maximum(cycles["direction"], cycles["frame"]) + Buffer.latency + 1
    found, entry, behind = [], 0, 0  # the memories are cleared behind a reset
    for n, frame in enumerate(normal):
        swept, entry = entry + unit.frame_interval, entry + unit.quad_interval - unit.e0_interval
        for cycle in frame[:q]:
            entry = max(entry + unit.e0_interval, cycle)
        behind = max(entry + unit.turn, swept, facts[n])
        for cycle in frame[q:]:
            entry = behind = max(behind, cycle)
            behind += unit.quad_interval
        found.append(entry + unit.latency - Fifo.latency)
    return found


@pytest.mark.parametrize("stall_in", [flowing, bursts])
@pytest.mark.parametrize("design", [*DESIGNS[:2], *long(*DESIGNS[2:])])
def test_every_index_comes_when_stated(design, stall_in):
    cycles = simulate(design, contacts(design, 4, 9), stall_in=stall_in).cycles
    assert cycles["index"] == predicted(design, cycles)


@pytest.mark.long
@settings(max_examples=20)
@given(st.data())
def test_any_size(data):
    rows, columns, steps = (data.draw(st.integers(*ends)) for ends in ((2, 6), (2, 6), (1, 24)))
    tolerance, seed = data.draw(st.sampled_from([0.0, 0.4, 30.0])), data.draw(st.integers(0, 99))
    design = make(rows, columns, steps, tolerance, words=data.draw(st.sampled_from([1, 2, 4])))
    frames = contacts(design, 2, seed) + small_numbers(design, 4, seed)
    seen = simulate(design, frames)
    assert seen.values["index"] == expected(design, frames).tolist()
    assert seen.cycles["index"] == predicted(design, seen.cycles)


def test_frames_that_cannot_leave_wait_in_the_unit():
    def late(_):
        yield from itertools.repeat(True, 900)
        yield from itertools.repeat(False)

    for design in (make(2, 2, 3), make(2, 2, 3, tolerance=2.0)):
        frames = small_numbers(design, 9, 13)
        check(design, frames, stall_out=late)


@pytest.mark.parametrize("design", [make(2, 2, 3), make(3, 4, 7, words=1)])
def test_stress_of_all_frames_has_its_place(design):
    """Of the frames in flight, of the next operand, and of what the fold and the fork in front of it hold."""
    dut, taken = Sweep(design), []

    async def drive(ctx):
        ctx.set(dut.stress.valid, 1)
        for _ in range(8 * design.quads + 8):
            taken.append(ctx.get(dut.stress.ready))
            await ctx.tick()

    designs.simulate(dut, drive)
    held = Butterfly(design.widths.stress).latency + 1
    assert sum(taken) == (FRAMES + 1) * design.quads + held


@pytest.mark.parametrize("port", ["stress", "g", "normal", "negative"])
def test_a_corrupted_value_is_seen(port):
    design = make(4, 4, 25)
    frames = contacts(design, 4, 11)
    if port == "stress":  # decides on a plateau alone: all tie while every stress is far below zero
        one, unit = np.ones((1, design.sensor.taxels), np.int64), 1 << design.formats.vector_fraction
        plateau = synthetic(design, -8000 * one, -2 * unit * one, unit * one, [0], [0])
        frames = contacts(design, 2, 11) + plateau + contacts(design, 1, 12)
    broken = Frames(**{name: value.copy() for name, value in vars(frames).items()})
    wrong = getattr(broken, port)
    wrong[2] = ~wrong[2]
    found = simulate(design, broken).values["index"]
    assert [a == b for a, b in zip(found, expected(design, frames), strict=True)] == [True, True, False, True]
