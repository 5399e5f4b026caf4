"""Resultant against its model: forces of all sizes, limits of the result words, both sides of the threshold."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from amaranth import Module, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out, connect, flipped
from hypothesis import given
from hypothesis import strategies as st

from tests.hdl.parallel.designs import random_words
from tests.hdl.parallel.learned.designs import CASES, few
from tests.model.fixed.learned.cases import learned_design
from tfra.hdl.lib.pipeline import delayed
from tfra.hdl.lib.streams import always_ready_stream
from tfra.hdl.parallel import payloads
from tfra.hdl.parallel.learned.payloads import judged as judged_shape
from tfra.hdl.parallel.learned.resultant import Resultant
from tfra.model.choices import Formats
from tfra.model.fixed.butterfly import EE, OX, OY
from tfra.model.fixed.learned.resultant import judged, resultant
from tfra.sim.harness import run


class Observed(wiring.Component):
    """Resultant with a stream of its verdicts, each when it is said to be complete."""

    def __init__(self, design: Any) -> None:
        self.inner = Resultant(design)
        super().__init__(
            {
                "total": In(always_ready_stream(payloads.vector_quad(design))),
                "force": Out(always_ready_stream(payloads.total(design))),
                "verdict": Out(always_ready_stream(judged_shape(design))),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.inner = inner = self.inner
        connect(m, flipped(self.total), inner.total)
        connect(m, inner.force, flipped(self.force))
        second = Signal()
        m.d.sync += second.eq(second ^ self.total.valid)
        complete = delayed(m, self.total.valid & second, inner.judged_latency, "complete", control=True)
        m.d.comb += [self.verdict.valid.eq(complete), self.verdict.payload.eq(inner.judged)]
        return m


def send(design, outputs, gap=0):
    """``outputs (n, 4)``: F_x, F_y, F_z and u, a frame at a time; the second quad ``gap`` cycles later."""
    quads = np.zeros((len(outputs), 2, 4), dtype=np.int64)
    quads[:, 0, [OX, OY, EE]] = outputs[:, :3]
    quads[:, 1, EE] = outputs[:, 3]

    def free(number, record, cycle):
        if number % 2:
            return cycle > record.cycles["total"][-1] + gap
        return len(record.cycles["verdict"]) >= number // 2

    return run(
        Observed(design),
        {"total": quads.reshape(-1, 4).tolist()},
        {"force": len(outputs), "verdict": len(outputs)},
        leave={"total": free},
    )


def check(design, outputs, gap=0):
    seen = send(design, outputs, gap)
    total, verdict = resultant(design, outputs[:, :3]), judged(design, outputs, design.threshold_word)
    found = seen.values["force"]
    assert [force["words"] for force in found] == total.words.tolist()
    assert [force["exponent"] for force in found] == total.exponent.tolist()
    for key, name in (("words", "words"), ("uncertainty", "uncertainty")):
        assert [one[key] for one in seen.values["verdict"]] == getattr(verdict, name).tolist(), key
    for key in ("limited", "implausible"):
        assert [bool(one[key]) for one in seen.values["verdict"]] == getattr(verdict, key).tolist(), key
    first = seen.cycles["total"][::2]
    assert [b - a for a, b in zip(first, seen.cycles["force"], strict=True)] == [Resultant.latency] * len(outputs)


@few
@given(st.integers(0, 1 << 32), st.sampled_from(CASES), st.integers(0, 5))
def test_equals_the_model(seed, design, gap):
    rng = np.random.default_rng(seed)
    outputs = random_words(rng, design.widths.vector, (12, 4))
    outputs[:6] >>= rng.integers(0, design.widths.vector, (6, 1))
    check(design, outputs, gap)


@pytest.mark.parametrize("threshold", [0.0, 1 / 256, 0.25, 1.0, 255.0, 1e9])
def test_both_sides_of_the_threshold(threshold):
    design = replace(learned_design(2, 2), threshold=threshold)
    word = design.threshold_word
    rows = []
    for size in (0, 1, 255, 256, 1000):
        edge = word * size >> 8
        rows += [[3, -4, -size, u] for u in (edge - 1, edge, edge + 1, -5)] + [[0, 0, size, 0]]
    check(design, np.clip(np.array(rows), -(1 << 24), 1 << 24))


@pytest.mark.parametrize(("vector", "force"), [(4, 4), (5, 4), (4, 5), (3, 6)])
def test_result_words_on_the_vector_grid_and_beside_it(vector, force):
    """Without a shift nothing is rounded; a half goes up."""
    design = learned_design(2, 2, formats=Formats("grids", 16, 16, vector, force))
    top = (1 << (design.widths.vector - 1)) - 1
    check(design, np.array([[1, -1, -3, 3], [2, -2, -500, 5], [-top, top, -1, top]]))


def test_a_wrong_bit_is_noticed():
    design = learned_design(2, 2)
    outputs = np.array([[100, -50, -700, 20]])
    seen = send(design, outputs)
    assert seen.values["force"][0]["words"] != resultant(design, outputs[:, :3] ^ 1).words[0].tolist()
