"""The gateware executes the program as the interpreter does: bit-exact words, exact cycles, any stalls."""

from __future__ import annotations

import random

import numpy as np
import pytest
from amaranth.sim import Simulator

from tests.hdl.harness import bursts, flowing, random_stalls, run
from tests.hdl.serial.designs import DESIGNS
from tfra.hdl.serial.product import DELAY, Product
from tfra.hdl.serial.program.memory import store_image
from tfra.hdl.serial.serial import Serial
from tfra.model.cover.scenes import contact_codes, directed_codes
from tfra.model.fixed.tfra.pipeline import FixedTfra
from tfra.model.tfra import Status


def stream(design, codes, **stalls):
    want = FixedTfra(design)(codes).words
    inputs = {"load": store_image(design).ravel().tolist(), "taxel": codes.ravel().tolist()}
    seen = run(Serial(design).build(), inputs, {"result": want.size}, **stalls)
    words = np.array([word["data"] for word in seen.values["result"]]).reshape(want.shape)
    last = np.array([word["last"] for word in seen.values["result"]]).reshape(want.shape)
    taken = np.array(seen.cycles["taxel"]).reshape(len(codes), -1)[:, -1]
    return Serial(design), words, want, last, np.array(seen.cycles["result"]).reshape(want.shape), taken


def test_words_and_cycles():
    design = DESIGNS["2×3"]
    codes = np.concatenate([contact_codes(design, 1, seed=1), directed_codes(design)[[1, -3]]])
    timing, words, want, last, cycles, _ = stream(design, codes)
    assert (words == want).all()
    assert (want[:, -1] & Status.NO_CONTACT).tolist() == [0, 0, 1]
    assert last[:, -1].all()
    assert last.sum() == len(want)
    assert (np.diff(cycles[:, -1]) == timing.initiation_interval).all()


def test_latency():
    design = DESIGNS["2×3"]
    timing, words, want, _, cycles, taken = stream(design, contact_codes(design, 1, seed=3), stall_in=flowing)
    assert (words == want).all()
    assert cycles[0, 0] - taken[0] == timing.latency
    assert cycles[0, -1] - taken[0] == timing.frame_latency


@pytest.mark.parametrize(
    ("name", "stall_in", "stall_out"), [("2×3", random_stalls, bursts), ("short", bursts, random_stalls)]
)
def test_stalls_change_nothing(name, stall_in, stall_out):
    design = DESIGNS[name]
    codes = contact_codes(design, 1, seed=4)
    _, words, want, *_ = stream(design, codes, stall_in=stall_in, stall_out=stall_out, seed=5)
    assert (words == want).all()


def test_wide_words():
    design = DESIGNS["wide"]
    _, words, want, *_ = stream(design, contact_codes(design, 1, seed=2), stall_in=flowing)
    assert (words == want).all()


@pytest.mark.parametrize(("a_bits", "b_bits"), [(18, 18), (34, 21), (33, 19), (16, 16), (24, 24), (10, 12)])
def test_products_are_exact(a_bits, b_bits):
    dut, rng = Product(a_bits, b_bits, a_bits + b_bits), random.Random(a_bits * b_bits)
    ends = [(a, b) for a in (-1 << (a_bits - 1), (1 << (a_bits - 1)) - 1) for b in (-1 << (b_bits - 1), -1, 0)]
    pairs = ends + [(rng.randrange(-1 << a_bits, 1 << a_bits) >> 1, rng.randrange(-1 << b_bits, 1 << b_bits) >> 1)
                    for _ in range(100)]

    async def bench(ctx):
        for number, (a, b) in enumerate([*pairs, *[(0, 0)] * (DELAY - 1)]):
            ctx.set(dut.a, a)
            ctx.set(dut.b, b)
            await ctx.tick()
            if number >= DELAY - 1:
                want = pairs[number - DELAY + 1]
                assert ctx.get(dut.o) == want[0] * want[1]

    simulator = Simulator(dut)
    simulator.add_clock(1e-6)
    simulator.add_testbench(bench)
    simulator.run()
