"""Combine against its model: designs, corners, real frames, stalls, late facts, latencies."""

from dataclasses import dataclass

import numpy as np
import pytest

from tests.hdl.parallel.designs import VECTORS, label
from tests.marks import long
from tfra.hdl.parallel.tfra.combine.store import FRAMES, MEASURE
from tfra.hdl.parallel.tfra.combine.unit import Combine
from tfra.model.arrays import Ints
from tfra.model.fixed.combine import combine
from tfra.model.fixed.widths import scalar_fraction
from tfra.sim.harness import PATTERNS, apart, bursts, flowing, random_stalls, run

RUNS = [
    *((d, bursts) for d in VECTORS[1::2]),
    *long(*((d, bursts) for d in VECTORS[::2]), *((d, random_stalls) for d in VECTORS)),
]


@dataclass
class Frames:
    """Operands of frames: vectors ``(n, Q, 4)``, scalars ``(n,)``."""

    b: Ints
    n: Ints
    g: Ints
    d1: Ints
    d2: Ints
    products: Ints
    sweep_y: Ints
    alpha: Ints
    beta: Ints
    mu_ind: Ints
    mu_x: Ints
    mu_y: Ints

    def inputs(self):
        """Payloads by port."""

        def quads(*vectors):
            return np.concatenate(vectors, axis=1).reshape(-1, 4).tolist()

        zero = {"cos": 0, "sin": 0, "negative": 0, "vanishing": 0}
        rest = {"vanishing": 0, "sums": [0] * 9, "significant": 0}
        return {
            "b": quads(self.b),
            "n": quads(self.n),
            "residual": quads(self.g, self.d1, self.d2),
            "direction": [zero | {"sweep_y": int(y)} for y in self.sweep_y],
            "affine": [rest | {"alpha": int(a), "beta": int(b)} for a, b in zip(self.alpha, self.beta, strict=True)],
            "chosen": [{"index": 0, "mu_ind": int(i), "mu_x": 0, "mu_y": 0, "out_of_range": 0} for i in self.mu_ind],
            "forced": [
                {"index": 0, "mu_ind": 0, "mu_x": int(x), "mu_y": int(y), "out_of_range": 0}
                for x, y in zip(self.mu_x, self.mu_y, strict=True)
            ],
            "products": quads(self.products),
            "bank_token": [0] * (3 * len(self.n)),
        }

    def expected(self, design):
        """``vector`` and ``forces`` as the model has them, shapes ``(n, 3 Q, 4)``."""
        swap = self.sweep_y[:, None, None].astype(bool)
        d_ind, d_dep = np.where(swap, self.d2, self.d1), np.where(swap, self.d1, self.d2)
        e0 = combine(design, (self.b << design.formats.vector_fraction) + self.g, self.alpha, d_dep)
        e1 = combine(design, d_ind, self.beta, d_dep)
        d = combine(design, e0, self.mu_ind, e1)
        minus_one = np.full(len(self.n), -1 << scalar_fraction(design))
        scalars = (self.mu_x, self.mu_y, minus_one)
        planes = np.split(self.products, 3, axis=1)
        forces = [combine(design, z, s, self.n) for z, s in zip(planes, scalars, strict=True)]
        seen = {"vector": np.concatenate([e0, e1, d], axis=1), "forces": np.concatenate(forces, axis=1)}
        limit = 1 << (design.widths.vector - 1)
        assert all(np.all((v >= -limit) & (v < limit)) for v in seen.values()), "a test vector leaves its word"
        return seen


def _random(design, seed, number=6):
    """Every parity of every vector has its own size; the first frames are corners: extremes, zeros, small words."""
    rng = np.random.default_rng(seed)
    q, bits, operand = design.quads, design.widths.vector, design.formats.operand

    def vector(top, quads=q):
        limit = np.int64(1) << rng.integers(0, top, (number, 1, 4), endpoint=True)
        return rng.integers(-limit, limit, (number, quads, 4))

    def scalars():
        low, high = -(1 << (operand - 1)), (1 << (operand - 1)) - 1
        values = rng.integers(low, high, number, endpoint=True)
        values[: min(number, 2)] = [low, high][:number]
        return values

    g, d1, d2, n = (vector(bits - 7) for _ in range(4))
    products, b = vector(bits - 7, 3 * q), vector(min(design.adc.bits, bits - 4 - design.formats.vector_fraction))
    frames = Frames(b, n, g, d1, d2, products, np.arange(number) & 1, *(scalars() for _ in range(5)))
    if number > 2:  # nothing but zeros
        for v in (b, n, g, d1, d2, products):
            v[2] = 0
        top = 1 << (bits - 1)  # n without any headroom; the rounded operand saturates
        n[3] = np.array([top - 1, -(top // 2) - 1, top - 1, top // 2])
        frames.mu_x[3], frames.mu_y[3] = 1 << (operand - 4), -1 << (operand - 4)
        products[3, 2 * q :] = 0
    if number > 4:  # one LSB either side of zero
        for v in (n, d1, d2):
            v[4] = rng.integers(-1, 1, (q, 4), endpoint=True)
    return frames


def _send(design, frames, stall_in=flowing, late=None):
    """Frames as the core sends them: with its token, g behind b, products behind d; ``late``: see :data:`LATE`."""
    q, number = design.quads, len(frames.b)

    def behind(**quads):
        """What of a frame, and of those before it, must have been seen: so many quads a frame of each port."""
        own = quads.pop("own")
        return lambda quad, record, cycle: all(
            len(record.cycles[port]) >= (quad // own + 1) * each for port, each in quads.items()
        )

    def after_d(quad, record, cycle):
        return sum(v["force"] for v in record.values["vector"]) >= (quad // (3 * q) + 1) * q

    leave = {
        "b": behind(own=q, frame_token=1),
        "n": behind(own=q, frame_token=1),
        "residual": behind(own=3 * q, frame_token=1, b=q, n=q),
        "products": after_d,
    }
    if late:
        usual = leave.get(late, lambda *_: True)
        leave[late] = lambda quad, record, cycle: cycle >= LATE - 1 and usual(quad, record, cycle)
    outputs = {"vector": 3 * q * number, "forces": 3 * q * number, "frame_token": number + FRAMES}
    return run(Combine(design), frames.inputs(), outputs, stall_in=apart(stall_in, design.cycles_per_quad), leave=leave)


def _check(design, frames, stall_in=flowing):
    """A token is taken for each vector, before it enters."""
    expected = {port: v.reshape(-1, 4).tolist() for port, v in frames.expected(design).items()}
    seen = _send(design, frames, stall_in)
    tokens, starts = seen.cycles["bank_token"], seen.cycles["vector"][:: design.quads]
    entries = np.array(starts) - _figures(design).force_latency - design.cycles_per_quad + 1
    assert len(tokens) == len(entries)
    assert (tokens <= entries).all()
    return seen, words(design, seen, len(frames.b)) == expected


def _figures(design):
    unit = Combine(design)
    unit._MustUse__silence = True  # figures alone are wanted
    return unit


def words(design, seen, number):
    """``vector`` as e0, e1, d of every frame, whatever order the unit chose; ``forces``."""
    rows = seen.values["vector"]
    d = np.array([v["words"] for v in rows if v["force"]]).reshape(number, design.quads, 4)
    e = np.array([v["words"] for v in rows if not v["force"]]).reshape(number, 2 * design.quads, 4)
    return {"vector": np.concatenate([e, d], axis=1).reshape(-1, 4).tolist(), "forces": seen.values["forces"]}


@pytest.mark.parametrize(("design", "stall_in"), RUNS, ids=lambda part: None if part in PATTERNS else label(part))
def test_equals_the_model(design, stall_in):
    _, same = _check(design, _random(design, seed=7), stall_in)
    assert same, "seed 7"


@pytest.mark.long
@pytest.mark.parametrize("design", VECTORS[:2], ids=label)
@pytest.mark.parametrize("seed", [0, 1])
def test_equals_the_model_for_more_seeds(design, seed):
    _, same = _check(design, _random(design, seed, number=8))
    assert same, f"seed {seed}"


def test_a_corrupted_word_is_noticed():
    design = VECTORS[0]
    frames = _random(design, seed=8)
    wrong = frames.expected(design)["vector"].reshape(-1, 4)
    wrong[-1, 0] += 1
    seen, same = _check(design, frames)
    assert same
    assert words(design, seen, len(frames.b))["vector"] != wrong.tolist()


LATE = 250
"""A clock edge by which a small design waits for nothing but the late port; it sees nothing valid before."""


def _late(design, port, number=1):
    frames = _random(design, seed=9, number=number)
    seen = _send(design, frames, late=port)
    expected = {port: v.reshape(-1, 4).tolist() for port, v in frames.expected(design).items()}
    assert words(design, seen, number) == expected
    return _figures(design), seen.cycles


@pytest.mark.parametrize("design", [*VECTORS[:1], *long(*VECTORS[1:])], ids=label)
@pytest.mark.parametrize(("port", "less"), [("residual", 0), ("affine", 3), ("direction", 3), ("bank_token", 4)])
def test_latency(design, port, less):
    dut, cycles = _late(design, port)
    start = cycles["residual"][-1] + design.cycles_per_quad - 1 if port == "residual" else LATE
    assert cycles["vector"][0] - start == MEASURE + design.cycles_per_quad + dut.force_latency - less
    assert cycles["bank_token"][0] == cycles["vector"][0] - dut.force_latency - design.cycles_per_quad + 1


@pytest.mark.parametrize("design", [*VECTORS[:1], *long(*VECTORS[1:])], ids=label)
def test_update_latency(design):
    dut, cycles = _late(design, "chosen")
    latency = design.cycles_per_quad + 1 + dut.force_latency
    assert cycles["vector"][2 * design.quads] - LATE == latency
    dut, cycles = _late(design, "products")
    assert cycles["vector"][2 * design.quads] - cycles["vector"][2 * design.quads - 1] == latency + 2


@pytest.mark.parametrize("design", [*VECTORS[:1], *long(*VECTORS[1:])], ids=label)
def test_force_latency_and_jobs(design):
    dut, cycles = _late(design, "products")
    q = design.quads
    assert cycles["products"][0] == LATE
    assert cycles["frame_token"][-1] == cycles["products"][-1] + design.cycles_per_quad + 1
    latency = design.cycles_per_quad - 1 + dut.force_latency
    assert all(f - p == latency for p, f in zip(cycles["products"], cycles["forces"], strict=True))
    assert cycles["vector"][q] - cycles["vector"][q - 1] == design.cycles_per_quad + 1
    assert np.all(np.diff(cycles["forces"]) == design.cycles_per_quad)


def test_the_next_stress_is_taken_while_the_search_runs():
    design = VECTORS[0]
    _, cycles = _late(design, "chosen", number=2)
    assert cycles["b"][-1] < LATE


def test_facts_are_taken_when_they_are_no_longer_needed():
    design = VECTORS[0]
    q = design.quads
    dut, cycles = _late(design, "chosen")
    behind = 1 - dut.force_latency  # a cycle behind the entry, which is so long before the sum leaves
    assert cycles["affine"] == cycles["direction"] == [cycles["vector"][2 * q - 1] + behind]
    assert cycles["chosen"] == [cycles["vector"][-1] + behind]
    assert cycles["forced"][0] < cycles["forces"][0]
