"""Stacks whose operands differ in length, in any order, as a plan of another estimator may have them."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import pytest

from tests.hdl.parallel.designs import label
from tests.marks import long
from tfra.hdl.parallel.matvec.passes import FULL, Passes, full
from tfra.hdl.parallel.matvec.plan import Plan, Source
from tfra.hdl.parallel.matvec.schedule import spacing
from tfra.hdl.parallel.matvec.unit import MatVec
from tfra.model.choices import Architecture
from tfra.model.fixed.coefficients import Operator, Stack
from tfra.model.fixed.matvec import matvec
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.fixed.widths import Widths
from tfra.model.sensor import SensorArray
from tfra.sim.harness import Recording, bursts, flowing, random_stalls, run

SIZES = {"codes": (6, 5), "long": (9, 4), "short": (1, 3), "mid": (3, 2), "other": (3, 7)}
"""Quads of a stack's operand, and of its results."""

OPERATORS = {name: f"op_{name}" for name in SIZES}

PLAN = Plan(
    (
        Source("pair", ("mid", "other"), 2, "pair_token"),
        Source("short", ("short",), 1, "short_token"),
        Source("long", ("long",), 2, "long_token"),
        Source("codes", ("codes",), 1),
    ),
    {"mid": ("place",), "other": ("room", "begun"), "codes": ("frame", "long_token")},
    {"begun": "short"},
)


@dataclass(frozen=True)
class Mixed(TfraDesign):
    """Products of random coefficients."""

    products = tuple(SIZES)

    @cached_property
    def stacks(self) -> dict[str, Stack]:
        rng = np.random.default_rng(5)
        found = {}
        for number, (name, (columns, quads)) in enumerate(SIZES.items()):
            rows = rng.integers(-(1 << 17), 1 << 17, (quads, 4, columns))
            found[name] = Stack(name, (Operator(OPERATORS[name], rows, number % 4, 16 + number, 0.0, 0.0),))
        return found

    @cached_property
    def widths(self) -> Widths:
        plain = TfraDesign(self.sensor, architecture=self.architecture).widths
        return replace(plain, vector=30, accumulator=44, alignment=0)


def make(lanes: int, words: int = 4) -> Mixed:
    return Mixed(SensorArray(4, 6, 4e-3, 2e-3, 3e-3), architecture=Architecture(lanes, words))


DESIGNS = [make(4), make(8, 2), make(12), make(24, 1)]


def draw(design: Mixed, count: int, seed: int) -> dict[str, np.ndarray]:
    """Operands ``(count, K, 4)`` of every stack, of random lengths."""
    rng = np.random.default_rng(seed)
    found = {}
    for name, (columns, _) in SIZES.items():
        bits = design.adc.bits + 2 if name == "codes" else 27
        words = rng.integers(-(1 << (bits - 1)), 1 << (bits - 1), (count, columns, 4))
        found[name] = words >> rng.integers(0, bits, (count, 1, 4))
    return found


def send(design: Mixed, drawn: dict[str, np.ndarray], **stalls) -> Recording:
    """Every operand once, as soon as there is a bank for it; ``long`` are not before a product of codes."""
    count = len(drawn["codes"])
    pairs = [
        {"words": quad, "other": int(name == "other")}
        for number in range(count)
        for name in ("mid", "other")
        for quad in drawn[name][number].tolist()
    ]
    plain = {name: drawn[name].reshape(-1, 4).tolist() for name in ("codes", "long", "short")}
    tokens = {name: [0] * count for name in ("place", "room", "frame")}
    products = design.stacks["codes"].quads

    def banked(token: str, quads: int):
        return lambda quad, record, cycle: len(record.cycles[token]) > quad // quads

    def after_codes(quad, record, cycle):
        kinds = [value["kind"] for value in record.values["result"]]
        return kinds.count(1) > products * (quad // SIZES["long"][0])

    return run(
        MatVec(design, PLAN),
        {"pair": pairs, **plain, **tokens},
        {
            "result": count * sum(quads for _, quads in SIZES.values()),
            "pair_token": 2 * count,
            "short_token": count,
        },
        steady={"codes"},
        leave={"pair": banked("pair_token", 3), "short": banked("short_token", 1), "long": after_codes},
        **stalls,
    )


@pytest.mark.parametrize(
    ("design", "stall"),
    [
        (DESIGNS[0], random_stalls),
        (DESIGNS[3], bursts),
        *long((DESIGNS[0], flowing), (DESIGNS[1], bursts), (DESIGNS[2], random_stalls)),
    ],
)
def test_every_product_of_every_length_is_the_models(design, stall):
    drawn = draw(design, 2, 7)
    seen = send(design, drawn, stall_in=stall, stall_out=stall, seed=3)
    half = 1 << (design.widths.vector - 1)
    for number, name in enumerate(SIZES):
        shift = design.formats.vector_fraction if name == "codes" else 0
        want = (matvec(design, name, drawn[name] << shift).reshape(-1, 4) + half) % (2 * half) - half
        found = [value["words"] for value in seen.values["result"] if value["kind"] == 1 << number]
        assert found == want.tolist(), name


def test_a_product_follows_another():
    """The operand of ``other`` waits until a product of ``short`` has begun."""
    design = DESIGNS[0]
    drawn = draw(design, 1, 8)
    late = {"words": [0] * 4, "other": 1}

    def offer(count, **more):
        inputs = {"pair": [late] * 3, "room": [0], "short": drawn["short"][0].tolist() * count}
        return run(MatVec(design, PLAN), inputs, {"result": design.stacks["other"].quads + 3 * count}, **more)

    kinds = [value["kind"].bit_length() - 1 for value in offer(1).values["result"]]
    assert kinds == [list(SIZES).index("short")] * 3 + [list(SIZES).index("other")] * design.stacks["other"].quads
    with pytest.raises(AssertionError, match="no end"):
        offer(0, limit=300)


def test_a_wrong_bit_is_noticed():
    design = DESIGNS[0]
    drawn = draw(design, 1, 9)
    seen = send(design, drawn)
    found = [value["words"] for value in seen.values["result"] if value["kind"] == 1 << 3]
    drawn["mid"][0, 1, 2] ^= 1 << 20
    assert found != matvec(design, "mid", drawn["mid"]).reshape(-1, 4).tolist()


@pytest.mark.parametrize("design", [DESIGNS[0], DESIGNS[3]], ids=label)
@pytest.mark.parametrize("name", ["codes", "short", *long("long", "mid")])
def test_latency_duration_and_passes_are_as_told(design, name):
    """Of one product alone."""
    drawn = draw(design, 1, 11)
    port = "pair" if name == "mid" else name
    quads = drawn[name][0].tolist()
    payloads = [{"words": quad, "other": 0} for quad in quads] if name == "mid" else quads
    late = max(spacing(design, stack) for stack in SIZES)
    seen = run(
        MatVec(design, PLAN),
        {port: payloads, "place": [0], "frame": [0]},
        {"result": design.stacks[name].quads},
        leave={port: lambda quad, record, cycle: cycle > late},
    )
    cycles = np.array(seen.cycles["result"]) - seen.cycles[port][-1]
    _, stated = Passes(design).product(name, full(design, PLAN, name))
    assert (cycles[0], cycles[-1]) == (stated[0], stated[-1])


def test_a_product_of_codes_begins_with_the_first_quad():
    design = make(4)
    assert full(design, PLAN, "codes") == 2 - SIZES["codes"][0]
    assert full(design, PLAN, "long") == FULL


def test_tokens_in_and_out():
    assert PLAN.tokens_out == ("pair_token", "short_token")
    assert PLAN.tokens_in == ("place", "room", "frame")
