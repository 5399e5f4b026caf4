"""The matrix-vector unit gives the model's integers, on time, however its operands come."""

import numpy as np
import pytest

from tests.hdl.parallel.designs import label, make
from tests.marks import long
from tfra.hdl.parallel.matvec.images import depth, passes
from tfra.hdl.parallel.matvec.passes import Passes, full
from tfra.hdl.parallel.matvec.unit import MatVec
from tfra.hdl.parallel.tfra.blocks import PLAN
from tfra.model.choices import Formats
from tfra.model.fixed.design import Design
from tfra.model.fixed.matvec import matvec
from tfra.model.fixed.tfra.operators import PRODUCTS
from tfra.sim.harness import Recording, bursts, random_stalls, run

SHORT = Formats("short", coefficient=12, operand=27, vector_fraction=0, force_fraction=0)
LONG = Formats("long", coefficient=10, operand=10, vector_fraction=16, force_fraction=0)

SMALL = [
    make(2, 2),
    make(2, 3, SHORT, lanes=8, bits=6),
    make(4, 4, "wide"),
    make(4, 4, lanes=16),
    make(4, 4, LONG, lanes=12, bits=10),
    make(4, 6, "wide", lanes=8),
    make(4, 6, lanes=24),
    make(2, 2, words=1),
    make(2, 3, lanes=8, words=1),
    make(4, 4, LONG, lanes=12, bits=10, words=2),
    make(3, 5),
    make(5, 3, "wide", lanes=20),
    make(5, 5, lanes=36),
]


def draw(design: Design, frames: int, seed: int) -> np.ndarray:
    """Operands ``(frames, 5, Q, 4)``: random words of random lengths, one length for each parity of a vector."""
    rng = np.random.default_rng(seed)
    limit = 1 << (design.widths.vector - 1)
    length = rng.integers(0, design.widths.vector, (frames, len(PRODUCTS), 1, 4))
    return with_codes(design, rng.integers(-limit, limit, (frames, len(PRODUCTS), design.quads, 4)) >> length)


def with_codes(design: Design, frames: np.ndarray) -> np.ndarray:
    """The same with contact operands cut to what folded converter codes can be."""
    half = 1 << (design.adc.bits + 1)
    codes = (frames[:, 0] + half) % (2 * half) - half
    frames[:, 0] = codes << design.formats.vector_fraction
    return frames


def corners(design: Design) -> np.ndarray:
    """Six frames of extremes: zeros, ones, both ends of the word, and sign patterns that line up with nothing."""
    top = (1 << (design.widths.vector - 1)) - 1
    shape = (len(PRODUCTS), design.quads, 4)
    alternating = np.where(np.indices(shape).sum(axis=0) % 2, top, -top - 1)
    one = np.zeros(shape, dtype=np.int64)
    one[:, -1, :] = [1, -1, 2, -2]
    constant = [np.full(shape, value, dtype=np.int64) for value in (0, -1, top, -top - 1)]
    return with_codes(design, np.stack([*constant, alternating, one]))


def expected(design: Design, frames: np.ndarray) -> dict[str, list[list[int]]]:
    """The model's results by operator, each in the order of frames.

    Operands that no frame can lead to may have results longer than a vector's word; those wrap.
    """
    half = 1 << (design.widths.vector - 1)
    results: dict[str, list[list[int]]] = {name: [] for name in design.kinds}
    for frame in frames:
        for number, name in enumerate(PRODUCTS):
            rows = (matvec(design, name, frame[number][None])[0] + half) % (2 * half) - half
            for op in design.stacks[name].operators:
                results[op.name] += rows[: op.quads].tolist()
                rows = rows[op.quads :]
    return results


def operands(design: Design, frames: np.ndarray) -> dict[str, list]:
    """Payloads by port, and tokens enough."""
    vectors = [{"words": row, "force": n == 4} for frame in frames for n in (2, 3, 4) for row in frame[n].tolist()]
    return {
        "b": (frames[:, 0] >> design.formats.vector_fraction).reshape(-1, 4).tolist(),
        "n": frames[:, 1].reshape(-1, 4).tolist(),
        "vector": vectors,
        "frame_token": [0] * len(frames),
        "plane_token": [0] * len(frames),
    }


def send(design: Design, frames: np.ndarray, unit: MatVec | None = None, **stalls) -> Recording:
    number = len(frames) * sum(design.stacks[name].quads for name in PRODUCTS)
    return offer(design, operands(design, frames), {"result": number}, unit, **stalls)


def offer(design: Design, inputs: dict[str, list], outputs: dict[str, int], unit=None, **how) -> Recording:
    """Vectors come with a token each; b, once it has begun, in every cycle."""
    if PLAN.source("contact").flowing(design):
        how["steady"] = {"b"}
    if vectors := len(inputs.get("vector", ())) // design.quads:
        outputs = {"bank_token": vectors} | outputs
        token = {"vector": lambda quad, record, cycle: len(record.cycles["bank_token"]) > quad // design.quads}
        how["leave"] = how.get("leave", {}) | token
    return run(unit or MatVec(design, PLAN), inputs, outputs, **how)


def by_operator(design: Design, seen: Recording) -> dict[str, list[list[int]]]:
    results: dict[str, list[list[int]]] = {name: [] for name in design.kinds}
    for quad in seen.values["result"]:
        results[design.kinds[quad["kind"].bit_length() - 1]].append(quad["words"])
    return results


def latency(design: Design, stack: str) -> int:
    """Cycles from the last operand quad to the first result of an otherwise idle unit."""
    return Passes(design).product(stack, full(design, PLAN, stack))[1][0]


def check(design: Design, frames: np.ndarray, seed: int = 0, **stalls) -> None:
    """Two frames at a time: n does not come from the contact product here, and the unit keeps room for two."""
    for pair in range(0, len(frames), 2):
        some = frames[pair : pair + 2]
        seen = send(design, some, seed=seed, **stalls)
        assert by_operator(design, seen) == expected(design, some), f"{label(design)}, seed {seed}"


@pytest.mark.parametrize("design", [SMALL[1], *long(SMALL[0], *SMALL[2::3])], ids=label)
def test_extreme_operands(design):
    check(design, corners(design))


@pytest.mark.parametrize("design", [*SMALL[1:3], *long(SMALL[0], *SMALL[3:])], ids=label)
def test_random_operands_with_stalls(design):
    check(design, draw(design, 2, 5), seed=5, stall_in=random_stalls, stall_out=bursts)


@pytest.mark.parametrize("lanes", long(64, 100))
def test_ten_by_ten(lanes):
    check(make(10, 10, lanes=lanes), draw(make(10, 10, lanes=lanes), 1, 8), seed=8, stall_in=bursts)


@pytest.mark.parametrize("design", [SMALL[3], make(3, 5, lanes=24)], ids=label)
def test_lanes_are_never_idle_while_operands_are_there(design):
    q = design.quads
    vectors = operands(design, draw(design, 4, 10))["vector"]
    force = [v for v in vectors if v["force"]]
    seen = offer(design, {"vector": force, "plane_token": [0] * 4}, {"result": 12 * q})
    ends = np.array(seen.cycles["result"])[3 * q - 1 :: 3 * q]
    timing = Passes(design)
    stated = [timing.product("force", 0)[1][-1] for _ in range(4)]
    assert ends[3] - ends[1] == stated[3] - stated[1]


@pytest.mark.parametrize("bits", [16, 17])
def test_a_contact_begins_with_its_first_quad_where_codes_fit_an_operand(bits):
    design = make(4, 4, bits=bits)
    assert PLAN.source("contact").flowing(design) == (bits == 16)
    frames = corners(design)[:2]
    seen = send(design, frames)
    assert by_operator(design, seen) == expected(design, frames)
    assert (latency(design, "contact") < latency(design, "residual")) == (bits == 16)


def test_a_contact_waits_for_its_frame_and_for_room_for_its_weights():
    """Without a third n taken, no more than two contacts are multiplied; without a token, none."""
    design = make(2, 2)
    everything = operands(design, draw(design, 4, 12))
    both = 2 * design.stacks["contact"].quads
    seen = run(MatVec(design, PLAN), {"b": everything["b"], "frame_token": [0] * 4}, {"result": both})
    assert len(seen.values["result"]) == both
    with pytest.raises(AssertionError, match="no end"):
        run(MatVec(design, PLAN), {"b": everything["b"], "frame_token": [0] * 4}, {"result": both + 1}, limit=200)
    with pytest.raises(AssertionError, match="no end"):
        run(MatVec(design, PLAN), {"b": everything["b"]}, {"result": 1}, limit=200)
    d = everything["vector"][2 * design.quads : 3 * design.quads]
    with pytest.raises(AssertionError, match="no end"):
        run(MatVec(design, PLAN), {"vector": d}, {"result": 1}, limit=200)


def test_there_are_banks_for_two_vectors_and_again_when_one_is_multiplied():
    design = make(4, 4)
    quads = operands(design, draw(design, 1, 13))["vector"]
    seen = run(MatVec(design, PLAN), {"vector": quads[: design.quads]}, {"bank_token": 3})
    assert seen.cycles["bank_token"][1] < seen.cycles["vector"][-1] < seen.cycles["bank_token"][2]
    with pytest.raises(AssertionError, match="no end"):
        run(MatVec(design, PLAN), {"vector": quads[: design.quads]}, {"bank_token": 4}, limit=200)


def test_closed_forms_of_a_ten_by_ten_array():
    design = make(10, 10, lanes=16)
    assert [passes(design, name) for name in PRODUCTS] == [7, 20, 7, 7, 19]
    assert depth(design) == (7 + 20 + 7 + 19) * 25
    assert design.multiplications == 4 * 25 * (26 + 78 + 25 + 25 + 75)
    assert latency(design, "normal") == 25 + 20


def test_a_wrong_bit_is_noticed():
    design = make(2, 2)
    frames = draw(design, 1, 11)
    wrong = expected(design, frames)
    wrong["c33"][0][2] ^= 1
    assert by_operator(design, send(design, frames)) != wrong
