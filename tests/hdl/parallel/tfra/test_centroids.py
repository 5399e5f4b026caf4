"""The gateware centroids give the model's directions, in the cycles they promise, under any stalls."""

import numpy as np
import pytest

from tests.hdl.parallel.designs import make
from tests.marks import STALLS
from tfra.hdl.parallel.tfra.centroids import Centroids, shift_distances
from tfra.model.choices import Formats
from tfra.model.fixed.design import Design
from tfra.model.fixed.tfra.centroids import centroids, pitch_ratio
from tfra.sim.harness import flowing, run

SIZES = ((2, 2), (2, 3), (3, 2), (4, 4), (5, 7), (4, 6), (10, 10))
PITCHES = ((2.0, 2.0), (4.0, 2.0), (2.0, 4.0), (1.27, 2.54), (3.7, 2.3), (1.0, np.pi), (np.e, 1.3))


def corners(design: Design) -> list[np.ndarray]:
    """Zeros, one zone alone, one taxel, mirror images (a zero in x, in y or in both), full scale."""
    rows, columns, top = design.sensor.rows, design.sensor.columns, (1 << (design.adc.bits - 1)) - 1
    frame = np.zeros((12, rows, columns), dtype=np.int64)
    frame[1:3] = [[[top]], [[-top - 1]]]
    frame[3, 0, 0], frame[4, -1, -1] = -1, top
    frame[5, 0], frame[5, -1] = -top - 1, top
    frame[6, :, 0], frame[6, :, -1] = top, -top - 1
    frame[7, 0, 0], frame[7, -1, -1] = -1, 1
    frame[8, 0, -1], frame[8, -1, 0] = -top - 1, top
    frame[9, 0, 0], frame[9, 0, -1] = 1, -1
    frame[10, 0], frame[10, -1] = 1, 1
    frame[10, :, 0] -= 1
    frame[11] = np.where(np.add.outer(np.arange(rows), np.arange(columns)) % 2, top, -top - 1)
    return list(frame.reshape(12, -1))


def random_frames(design: Design, number: int, seed: int) -> list[np.ndarray]:
    """Codes of every size; the smallest ones bring ties between x and y and frames without a direction."""
    rng = np.random.default_rng(seed)
    limits = 1 << rng.integers(0, design.adc.bits, number)
    return [rng.integers(-limit, limit, design.sensor.taxels) for limit in limits]


def expected(design: Design, frames: list[np.ndarray]) -> list[dict[str, int]]:
    model = centroids(design, np.array(frames))
    names = ("cos", "sin", "sweep_y", "negative", "vanishing")
    return [{name: int(getattr(model, name)[k]) for name in names} for k in range(len(frames))]


def compare(design, frames, *, block=None, stall_in=flowing, stall_out=flowing, seed=0):
    golden = expected(design, frames)
    seen = run(
        block or Centroids(design),
        {"taxel": np.concatenate(frames).tolist()},
        {"direction": len(golden)},
        stall_in=stall_in,
        stall_out=stall_out,
        seed=seed,
    )
    assert seen.values["direction"] == golden, f"directions differ (seed {seed})"
    return seen


@pytest.mark.parametrize("size", SIZES)
def test_random_frames_of_any_size(size):
    design, seed = make(*size), 10 * size[0] + size[1]
    compare(design, random_frames(design, 8, seed), seed=seed)


@pytest.mark.parametrize("pitches", PITCHES)
def test_pitches(pitches):
    design = make(3, 4, pitches=pitches)
    compare(design, corners(design) + random_frames(design, 8, 1), seed=1)


def test_every_kind_of_pitch_ratio_is_there():
    assert [pitch_ratio(make(3, 4, pitches=p)) for p in PITCHES[:5]] == [(1, 1), (2, 1), (1, 2), (1, 2), (37, 23)]
    assert max(pitch_ratio(make(3, 4, pitches=PITCHES[5]))) > 1 << 12


@pytest.mark.parametrize("pitches", [(1.0, np.pi), (1.0, np.sqrt(2)), (np.e, 1.3)])
def test_pitch_ratios_are_the_nearest_of_their_length(pitches):
    """Of all pairs whose larger number has 2^(operand - 2) at most."""
    design = make(3, 4, pitches=pitches)
    larger = np.arange(1, (1 << (design.formats.operand - 2)) + 1)
    ratio = min(pitches) / max(pitches)
    error = np.abs(np.rint(ratio * larger) / larger - ratio)
    found = sorted(pitch_ratio(design))
    assert found == [round(ratio * larger[error.argmin()]), larger[error.argmin()]]


@pytest.mark.parametrize(
    ("bits", "formats"),
    [
        (6, "wide"),
        (8, "standard"),
        (14, "wide"),
        (16, "standard"),
        (10, Formats("short", coefficient=12, operand=10, vector_fraction=4, force_fraction=2)),
        (20, Formats("long", coefficient=14, operand=24, vector_fraction=4, force_fraction=2)),
    ],
)
def test_corner_frames_of_any_converter(bits, formats):
    design = make(4, 3, formats, bits=bits, pitches=(1.0, np.pi))
    compare(design, corners(design) + random_frames(design, 6, bits), seed=bits)


def test_ties_and_frames_without_direction():
    """A square array and codes of -1, 0, 1 meet every tie of the comparisons."""
    design = make(2, 2, bits=8, pitches=(2.0, 2.0))
    codes = np.stack(np.meshgrid(*[[-1, 0, 1]] * 4), axis=-1).reshape(-1, 4)
    model = centroids(design, codes)
    assert model.vanishing.any()
    assert (~model.vanishing & (abs(model.cos) == abs(model.sin))).any()
    compare(design, list(codes))


@pytest.mark.parametrize(("stall_in", "stall_out"), STALLS)
@pytest.mark.parametrize("size", [(2, 2), (5, 7)])
def test_stalls_on_every_port(stall_in, stall_out, size):
    design = make(*size, bits=8)
    for seed in range(2):
        compare(design, random_frames(design, 5, seed), stall_in=stall_in, stall_out=stall_out, seed=seed)


def test_a_direction_is_kept_until_it_is_taken():
    """The next frames wait at the input for a sink that sleeps, and none of them is lost."""
    design = make(3, 3, bits=8)

    def patience(rng):
        while True:
            yield from [True] * 300
            yield False

    compare(design, random_frames(design, 4, 5), stall_out=patience)


@pytest.mark.parametrize(
    ("size", "pitches"), [((2, 2), (2.0, 2.0)), ((3, 5), (1.0, np.pi)), ((4, 4), (3.7, 2.3)), ((10, 10), (4.0, 2.0))]
)
def test_cycles_are_the_promised_ones(size, pitches):
    design = make(*size, pitches=pitches)
    block, m = Centroids(design), design.sensor.taxels
    frames = [np.zeros(m, dtype=np.int64), *random_frames(design, 3, 2)]
    cycles = compare(design, frames, block=block).cycles
    last = np.array(cycles["taxel"][m - 1 :: m])
    assert (np.array(cycles["direction"]) - last == block.latency).all()
    assert (np.diff(last) == max(m, block.latency + 1)).all()


def left(places, distances):
    """Places that are left of a shift."""
    for distance in distances:
        places -= distance * (places >= distance)
    return places


@pytest.mark.parametrize("most", range(1, 90))
def test_any_shift_is_made_and_no_distance_is_idle(most):
    distances = shift_distances(most)
    assert not any(left(places, distances) for places in range(most + 1))
    for idle in range(len(distances)):
        others = distances[:idle] + distances[idle + 1 :]
        assert any(left(places, others) for places in range(most + 1)), distances[idle]


@pytest.mark.parametrize(("operand", "largest"), [(18, 1), (19, 2)])
def test_the_shortest_products_fill_their_word(operand, largest):
    """A product of -1 moves through its whole register: 31 places are 16 and three times 4 and 1, 32 are one more."""
    formats = Formats("odd", coefficient=18, operand=operand, vector_fraction=9, force_fraction=4)
    design = make(2, 2, formats, bits=8, pitches=(2.0, 2.0))
    codes = np.stack(np.meshgrid(*[[-1, 0, 1]] * 4), axis=-1).reshape(-1, 4)
    compare(design, list(codes[::3]))
    sums, products, shifts, rounding, decision = 4, 11 + 2, 2 * 2 * (largest + 3 + 3), 1, 4
    assert Centroids(design).latency == sums + products + shifts + rounding + decision


@pytest.mark.parametrize("name", ["cos", "sin", "sweep_y", "negative", "vanishing"])
def test_a_corrupted_word_is_noticed(monkeypatch, name):
    design = make(3, 3)
    frames = random_frames(design, 3, 1)
    golden = expected(design, frames)
    golden[1][name] ^= 1
    monkeypatch.setattr(f"{__name__}.expected", lambda *_: golden)
    with pytest.raises(AssertionError, match="directions differ"):
        compare(design, frames)
