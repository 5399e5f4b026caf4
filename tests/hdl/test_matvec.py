"""The matrix-vector unit gives the model's integers, on time, under any stalls."""

from __future__ import annotations

import numpy as np
import pytest

from tests.hdl.harness import PATTERNS, Recording, bursts, flowing, random_stalls, run
from tfra.hdl.matvec import MatVec
from tfra.model.design import FORMATS, Adc, Architecture, Design, Formats
from tfra.model.fixed.coefficients import PRODUCTS, stacks
from tfra.model.fixed.matvec import matvec
from tfra.model.fixed.widths import widths
from tfra.model.sensor import SensorArray

SHORT = Formats("short", coefficient=12, operand=27, vector_fraction=0, force_fraction=0)
LONG = Formats("long", coefficient=10, operand=10, vector_fraction=16, force_fraction=0)


def make(rows: int, columns: int, lanes: int, formats: Formats = FORMATS["standard"], bits: int = 14) -> Design:
    sensor = SensorArray(rows, columns, 4e-3, 2e-3, 3e-3)
    return Design(sensor, adc=Adc(bits), formats=formats, architecture=Architecture(mac_lanes=lanes, sweep_lanes=1))


SMALL = [
    make(2, 2, 1),
    make(2, 2, 2),
    make(2, 2, 4),
    make(2, 3, 8, SHORT, 6),
    make(4, 4, 2, FORMATS["wide"]),
    make(4, 4, 16),
    make(4, 4, 12, LONG, 10),
    make(4, 6, 8, FORMATS["wide"]),
    make(4, 6, 24),
]
LARGE = [make(4, 6, 1), make(5, 7, 4), make(5, 7, 20, FORMATS["wide"]), make(5, 7, 48), make(4, 4, 4)]


def label(design: Design) -> str:
    return f"{design.sensor.rows}x{design.sensor.columns}-{design.architecture.mac_lanes}-{design.formats.name}"


def draw(design: Design, frames: int, seed: int) -> np.ndarray:
    """Operands ``(frames, 5, Q, 4)``: random words of random lengths, one length for each parity of a vector."""
    rng = np.random.default_rng(seed)
    limit = 1 << (widths(design).vector - 1)
    length = rng.integers(0, widths(design).vector, (frames, len(PRODUCTS), 1, 4))
    return rng.integers(-limit, limit, (frames, len(PRODUCTS), design.quads, 4)) >> length


def corners(design: Design) -> np.ndarray:
    """Six frames of extremes: zeros, ones, both ends of the word, and sign patterns that line up with nothing."""
    top = (1 << (widths(design).vector - 1)) - 1
    shape = (len(PRODUCTS), design.quads, 4)
    alternating = np.where(np.indices(shape).sum(axis=0) % 2, top, -top - 1)
    one = np.zeros(shape, dtype=np.int64)
    one[:, -1, :] = [1, -1, 2, -2]
    constant = [np.full(shape, value, dtype=np.int64) for value in (0, -1, top, -top - 1)]
    return np.stack([*constant, alternating, one])


def expected(design: Design, frames: np.ndarray) -> list[list[int]]:
    """The model's results in order.

    Operands that no frame can lead to may have results longer than a vector's word; those wrap.
    """
    half = 1 << (widths(design).vector - 1)
    products = [matvec(design, name, frames[:, n]) for n, name in enumerate(PRODUCTS)]
    return ((np.concatenate(products, axis=1) + half) % (2 * half) - half).reshape(-1, 4).tolist()


def send(design: Design, frames: np.ndarray, unit: MatVec | None = None, **stalls) -> Recording:
    number = len(frames) * sum(stacks(design)[name].quads for name in PRODUCTS)
    return run(unit or MatVec(design), {"operand": frames.reshape(-1, 4).tolist()}, {"result": number}, **stalls)


def check(design: Design, frames: np.ndarray, seed: int = 0, **stalls) -> None:
    seen = send(design, frames, seed=seed, **stalls)
    assert seen.values["result"] == expected(design, frames), f"{label(design)}, seed {seed}"


@pytest.mark.parametrize("design", SMALL, ids=label)
def test_extreme_operands(design):
    check(design, corners(design))


@pytest.mark.parametrize("design", SMALL, ids=label)
@pytest.mark.parametrize("stall", PATTERNS[1:])
def test_random_operands_with_stalls_on_both_sides(design, stall):
    check(design, draw(design, 3, 5), seed=5, stall_in=stall, stall_out=stall)


@pytest.mark.parametrize("design", LARGE, ids=label)
def test_random_operands_of_larger_designs(design):
    check(design, draw(design, 1, 6), seed=6, stall_out=random_stalls)


@pytest.mark.parametrize("design", [SMALL[2], SMALL[6]], ids=label)
@pytest.mark.parametrize("stall_in", PATTERNS)
@pytest.mark.parametrize("stall_out", PATTERNS)
def test_every_pair_of_stall_patterns(design, stall_in, stall_out):
    check(design, draw(design, 3, 7), seed=7, stall_in=stall_in, stall_out=stall_out)


@pytest.mark.parametrize("lanes", [64, 100])
def test_ten_by_ten(lanes):
    check(make(10, 10, lanes), draw(make(10, 10, lanes), 1, 8), seed=8, stall_out=bursts)


@pytest.mark.parametrize("seed", range(3))
def test_long_waits_of_the_receiver_hold_sums_back(seed):
    """The receiver sleeps for longer than passes take, so that credit, capture and the spare place all wait."""

    def sleepy(rng):
        while True:
            yield from [True] * rng.randrange(1, 90)
            yield from [False] * rng.randrange(1, 12)

    for design in (SMALL[1], SMALL[2], SMALL[5]):
        check(design, draw(design, 3, seed), seed=seed, stall_out=sleepy)


@pytest.mark.parametrize("product", range(len(PRODUCTS)))
@pytest.mark.parametrize("design", [SMALL[0], SMALL[1], SMALL[5], SMALL[7]], ids=label)
def test_latency_and_duration_are_as_told(design, product):
    """The unit is left idle before each product: its operand starts when all results before it are out."""
    unit, frames, name = MatVec(design), draw(design, 1, 9), PRODUCTS[product]
    idle = 2 * unit.interval + 100

    def pause(rng):
        yield from [False] * (product * design.quads) + [True] * idle
        yield from flowing(rng)

    seen = send(design, frames, unit, stall_in=pause)
    start = seen.cycles["operand"][(product + 1) * design.quads - 1]
    first = sum(stacks(design)[earlier].quads for earlier in PRODUCTS[:product])
    last = first + stacks(design)[name].quads - 1
    assert first == 0 or seen.cycles["result"][first - 1] < start - design.quads
    assert seen.cycles["result"][first] - start == unit.latency(name)
    assert seen.cycles["result"][last] - start == unit.duration(name)


@pytest.mark.parametrize("design", [*SMALL[:4], *SMALL[5:], make(5, 7, 48)], ids=label)
def test_frames_back_to_back_follow_at_the_interval(design):
    unit = MatVec(design)
    seen = send(design, draw(design, 5, 10), unit)
    starts = seen.cycles["result"][:: sum(stacks(design)[name].quads for name in PRODUCTS)]
    assert -(-(starts[4] - starts[2]) // 2) == unit.interval


def test_closed_forms_of_a_ten_by_ten_array():
    unit = MatVec(make(10, 10, 16))
    unit._MustUse__silence = True  # figures alone are wanted
    assert [unit.passes(name) for name in PRODUCTS] == [7, 20, 7, 7, 19]
    assert unit.depth == (7 + 20 + 7 + 19) * 25
    assert unit.multiplications == 4 * 25 * (26 + 78 + 25 + 25 + 75)
    assert unit.interval == (7 + 20 + 7 + 7 + 19) * 25
    assert unit.latency("normal") == 25 + 14


def test_a_wrong_bit_is_noticed():
    design = make(2, 2, 4)
    frames = draw(design, 1, 11)
    wrong = expected(design, frames)
    wrong[3][2] ^= 1
    assert send(design, frames).values["result"] != wrong
