"""The gateware normaliser gives the model's frames and facts, in the cycles it promises, under any stalls."""

import random

import numpy as np
import pytest

from tests.hdl.parallel.designs import make
from tests.marks import STALLS
from tfra.hdl.parallel.normaliser import Normaliser
from tfra.model.fixed.butterfly import to_quads
from tfra.model.fixed.design import Design
from tfra.model.fixed.normaliser import normaliser
from tfra.sim.harness import flowing, run

SIZES = ((2, 2), (2, 3), (3, 2), (3, 3), (4, 4), (5, 7), (4, 6), (7, 4), (10, 10))


def corners(design: Design) -> list[np.ndarray]:
    """Zeros, one taxel alone, full scale of either sign, and the smallest codes."""
    m, top = design.sensor.taxels, (1 << (design.adc.bits - 1)) - 1
    alone = np.zeros((6, m), dtype=np.int64)
    alone[np.arange(6), [0, m - 1, m // 2, 0, m - 1, 1]] = [1, -1, top, -top - 1, -top, top - 1]
    signs = np.where(np.arange(m) % 3, 1, -1)
    full = [np.full(m, value) for value in (0, top, -top - 1, 1, -1)]
    return [*full, *alone, signs, np.where(signs > 0, top, -top - 1)]


def every_exponent(design: Design, rng: np.random.Generator) -> list[np.ndarray]:
    """A frame of random codes for every bit length."""
    sizes = [1 << bit for bit in range(design.adc.bits)]
    return [rng.integers(-size, size, design.sensor.taxels) for size in sizes]


def expected(design: Design, frames: list[np.ndarray]) -> tuple[list[list[int]], list[dict[str, int]]]:
    """Quads and facts of the model."""
    model = normaliser(design, np.array(frames))
    names = ("exponent", "magnitude", "contact", "traction", "saturated")
    facts = [{name: int(getattr(model, name)[k]) for name in names} for k in range(len(frames))]
    return to_quads(design, model.stress).reshape(-1, 4).tolist(), facts


def compare(design, frames, *, block=None, stall_in=flowing, stall_out=flowing, seed=0):
    quads, facts = expected(design, frames)
    seen = run(
        block or Normaliser(design),
        {"taxel": np.concatenate(frames).tolist()},
        {"quads": len(quads), "frame": len(facts)},
        stall_in=stall_in,
        stall_out=stall_out,
        seed=seed,
    )
    assert seen.values["frame"] == facts, f"facts differ (seed {seed})"
    assert seen.values["quads"] == quads, f"quads differ (seed {seed})"
    return seen


@pytest.mark.parametrize("size", SIZES)
def test_random_frames_of_any_size(size):
    seed = 10 * size[0] + size[1]
    design = make(*size)
    frames = np.random.default_rng(seed).integers(-8192, 8192, (4, design.sensor.taxels))
    compare(design, list(frames), seed=seed)


@pytest.mark.parametrize(("bits", "formats"), [(6, "standard"), (8, "wide"), (14, "standard"), (16, "wide")])
def test_corner_frames_and_every_exponent(bits, formats):
    design = make(3, 4, formats, bits=bits)
    compare(design, corners(design) + every_exponent(design, np.random.default_rng(bits)), seed=bits)


def near(design: Design, threshold: int) -> list[np.ndarray]:
    """Frames whose largest code is on either side of ``threshold``, of one sign and of both."""
    m, low = design.sensor.taxels, -(1 << (design.adc.bits - 1))
    codes = np.clip(np.arange(-threshold - 2, -threshold + 2), low, -1 - low).tolist()
    codes += np.clip(np.arange(threshold - 2, threshold + 2), low, -1 - low).tolist()
    frames = [np.full(m, rest) for rest in (0, -1) for _ in codes]
    for number, frame in enumerate(frames):
        frame[number % m] = codes[number % len(codes)]
    return frames


THRESHOLDS = [(6, 0), (6, 1), (6, None), (6, 31), (14, 63), (14, 64), (14, 65), (14, 8191), (20, 100_000)]


@pytest.mark.parametrize(("bits", "threshold"), THRESHOLDS)
def test_the_contact_threshold(bits, threshold):
    design = make(3, 4, "wide", bits=bits, threshold=threshold)
    compare(design, near(design, design.adc.threshold) + corners(design), seed=bits)


@pytest.mark.parametrize("wrong", [-1, 1])
@pytest.mark.parametrize("threshold", [1, 4, 30])
def test_a_wrong_threshold_is_noticed(threshold, wrong):
    design, other = (make(3, 4, bits=6, threshold=t) for t in (threshold, threshold + wrong))
    with pytest.raises(AssertionError, match="facts differ"):
        compare(design, near(design, threshold), block=Normaliser(other))


def test_widest_converter():
    design = make(5, 4, "wide", bits=20)
    compare(design, corners(design) + every_exponent(design, np.random.default_rng(20)), seed=20)


@pytest.mark.parametrize(("stall_in", "stall_out"), STALLS)
@pytest.mark.parametrize("size", [(2, 2), (3, 5)])
def test_stalls_on_every_port(stall_in, stall_out, size):
    design = make(*size, bits=8)
    rng = np.random.default_rng(7)
    frames = [f for pair in zip(every_exponent(design, rng), corners(design), strict=False) for f in pair]
    compare(design, frames[:8], stall_in=stall_in, stall_out=stall_out, seed=7)


@pytest.mark.parametrize("slow", ["quads", "frame"])
def test_a_frame_is_kept_until_all_of_it_is_taken(slow):
    """One output waits for a long time while the other one flows: nothing overtakes, nothing is lost."""
    design = make(3, 3, bits=8)
    frames = list(np.random.default_rng(3).integers(-128, 128, (5, 9)))

    first_draw = random.Random(f"0 {slow} out").random()  # the harness seeds the stalls with the port's name

    def patience(rng):
        pause = 60 if rng.random() == first_draw else 0
        while True:
            yield from [True] * pause
            yield False

    compare(design, frames, stall_out=patience)


@pytest.mark.parametrize("size", [(2, 2), (3, 5), (4, 4), (10, 10)])
def test_cycles_are_the_promised_ones(size):
    design = make(*size)
    block, m, q = Normaliser(design), design.sensor.taxels, design.quads
    cycles = compare(design, [np.full(m, value) for value in (0, 5, -8192, 1)], block=block).cycles
    last, first = np.array(cycles["taxel"][m - 1 :: m]), np.array(cycles["quads"][::q])
    assert (first - last == block.latency).all()
    assert (np.array(cycles["frame"]) - last == block.latency).all()
    assert (np.array(cycles["quads"][q - 1 :: q]) - first == q - 1).all()
    assert (np.diff(last) == max(m, block.latency + q)).all()


def test_a_corrupted_word_is_noticed(monkeypatch):
    design = make(4, 4)
    frames = list(np.random.default_rng(1).integers(-8192, 8192, (3, 16)))
    quads, facts = expected(design, frames)
    quads[5][2] ^= 1
    monkeypatch.setattr(f"{__name__}.expected", lambda *_: (quads, facts))
    with pytest.raises(AssertionError, match="quads differ"):
        compare(design, frames)
    quads[5][2] ^= 1
    facts[1]["magnitude"] += 1
    with pytest.raises(AssertionError, match="facts differ"):
        compare(design, frames)
