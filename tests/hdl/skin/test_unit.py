"""The unit gives every word of the model's records, whatever the frames are and however they come."""

import random
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from amaranth import Module, ResetInserter, Signal
from amaranth.lib import wiring

from tests.hdl.skin.memories import played
from tests.hdl.skin.skins import bumps, frames_of, grid, learned_window, skin_of, small_window
from tests.hdl.skin.stub import Stub, stub_words
from tests.marks import long
from tests.model.fixed.learned.cases import learned_design
from tfra.hdl.cores import microarchitecture
from tfra.hdl.skin.timing import SkinTiming
from tfra.hdl.skin.unit import SkinUnit
from tfra.model.choices import Architecture
from tfra.model.skin.records import header_bits, records
from tfra.sim.harness import bursts, flowing, random_stalls, run

WINDOW = small_window(4, 5)


@pytest.fixture
def stubbed(monkeypatch):
    """The core is a stub, which is simulated many times faster."""
    monkeypatch.setattr(
        "tfra.hdl.skin.unit.microarchitecture", lambda design: SimpleNamespace(build=lambda: Stub(design))
    )


def check(skin, codes, want, *, coefficients=None, limit=400_000, **stalls):
    """The unit's words are those of ``want``; cycles of the taxels and of the words."""
    inputs = {"taxel": codes.ravel().tolist()} | ({} if coefficients is None else {"load": coefficients.tolist()})
    seen = run(SkinUnit(skin), inputs, {"result": want.size}, limit=limit, **stalls)
    words = np.array([word["data"] for word in seen.values["result"]]).reshape(want.shape)
    last = np.array([word["last"] for word in seen.values["result"]]).reshape(want.shape)
    wrong = np.argwhere(words != want)
    assert not len(wrong), f"{len(wrong)} words differ, the first at {wrong[0]}"
    assert last[:, -1].all()
    assert last.sum() == len(last)
    return np.array(seen.cycles["taxel"]).reshape(len(codes), -1), np.array(seen.cycles["result"]).reshape(want.shape)


@pytest.mark.usefixtures("stubbed")
@pytest.mark.parametrize(
    ("shape", "choices", "seed", "count", "stall_in", "stall_out"),
    [
        ((12, 20), {"most": 4}, 0, 10, flowing, flowing),
        ((12, 20), {"most": 16, "gap": 1}, 4, 6, random_stalls, bursts),
        ((5, 7), {"most": 64, "gap": 0, "threshold": 1 / 256}, 1, 10, bursts, random_stalls),
        ((7, 5), {"most": 1, "gap": 4, "threshold": 1.0}, 7, 10, flowing, bursts),
        *long(
            ((32, 32), {"most": 16}, 3, 3, flowing, flowing),
            ((32, 32), {"most": 64, "gap": 3}, 0, 10, bursts, random_stalls),
        ),
    ],
)
def test_records_are_those_of_the_model(shape, choices, seed, count, stall_in, stall_out):
    skin = skin_of(*shape, WINDOW, **choices)
    codes = frames_of(skin, seed, count)
    check(skin, codes, records(skin, codes, stub_words), stall_in=stall_in, stall_out=stall_out, seed=seed)


SERIAL = Architecture(kind="serial", mac_lanes=0, vector_words=0)


@pytest.mark.parametrize(
    ("window", "shape", "count"),
    long(
        (small_window(), (6, 9), 2),
        (learned_design(2, 2, counts=(1, 1), architecture=SERIAL), (6, 9), 3),
    ),
    ids=lambda value: value.name if hasattr(value, "name") else None,
)
def test_any_core_reads_the_windows(window, shape, count):
    skin = skin_of(*shape, window, most=4)
    codes = frames_of(skin, 0, count)
    check(skin, codes, records(skin, codes, window.model.words), coefficients=microarchitecture(window).loaded)


@pytest.mark.usefixtures("stubbed")
@pytest.mark.parametrize(
    ("shape", "most", "counts", "budget"), [((32, 32), 4, (2, 2), 5_000), *long(((64, 64), 16, (4, 4), 20_000))]
)
def test_cycles_of_a_frame(shape, most, counts, budget):
    """Frames of contacts of 37 taxels; the intake alone is never in the way."""
    skin = skin_of(*shape, learned_window(), most=most)
    codes = np.stack([grid(shape, counts, 4.2)] * 4)
    found, _ = skin.find(codes)
    assert found.found.tolist() == [most] * len(codes)
    assert 30 <= found.taxels.min() <= found.taxels.max() <= 40
    want = records(skin, codes, stub_words)
    taken, given = check(skin, codes, want)
    ends = given[want[:, list(header_bits(skin)).index("last")] == 1, -1]
    taxels = codes[0].size
    assert taken[1, -1] - taken[0, 0] == 2 * taxels - 1  # as many frames as there are pages come without a pause
    assert ends[0] - taken[0, 0] < budget
    assert np.diff(ends).max() < budget
    stated = replace(SkinTiming.of(skin), taxels=int(found.taxels.max()))
    assert given[0, 0] - taken[0, -1] <= stated.latency
    assert ends[0] - taken[0, -1] <= stated.frame_latency
    assert np.diff(ends).max() <= max(taxels, stated.finding) <= stated.interval


@pytest.mark.long
@pytest.mark.usefixtures("stubbed")
def test_small_contacts_never_stop_the_intake():
    skin = skin_of(32, 32, WINDOW)
    codes = np.stack([grid((32, 32), (2, 2), 3.0)] * 5)
    taken, _ = check(skin, codes, records(skin, codes, stub_words))
    assert (np.diff(taken.ravel()) == 1).all()


@pytest.mark.usefixtures("stubbed")
@pytest.mark.parametrize("changes", [{"gap": 1}, {"threshold": 0.9}, {"most": 3}])
def test_other_words_are_noticed(changes):
    skin, other = (skin_of(12, 20, WINDOW, **choices) for choices in ({}, changes))
    codes = frames_of(skin, 4, 2)
    want = records(other, codes, stub_words)
    if want.shape == (same := records(skin, codes, stub_words)).shape:
        assert (want != same).any()
    with pytest.raises(AssertionError, match=r"words differ|no end"):
        check(skin, codes, want, limit=5_000)


@pytest.mark.usefixtures("stubbed")
@pytest.mark.parametrize("word", [0, 9, *long(4, 6)])
def test_a_single_wrong_bit_is_noticed(word):
    skin = skin_of(6, 9, WINDOW)
    codes = frames_of(skin, 0, 1)
    want = records(skin, codes, stub_words)
    check(skin, codes, want)
    want[-1, word] ^= 1
    with pytest.raises(AssertionError, match="1 words differ"):
        check(skin, codes, want)


def reset_run(skin, codes, words, coefficients, interrupted, seed):
    """The words after resets that come so many cycles after random taxels began."""
    rng, reset, unit, got = random.Random(seed), Signal(), SkinUnit(skin), []
    load = getattr(unit, "load", None)

    async def feed(ctx, port, values, stop=0):
        """Offer values, for ``stop`` cycles or until all are taken; the words that leave meanwhile."""
        left, seen, cycles = list(values), [], 0
        while (cycles < stop) if stop else left:
            ctx.set(port.valid, 1)
            ctx.set(port.payload, left[0] if left else rng.randrange(-2000, 500))
            _, _, taken, valid, word = await ctx.tick().sample(port.ready, unit.result.valid, unit.result.payload)
            cycles += 1
            if taken and left:
                left.pop(0)
            if valid and ctx.get(unit.result.ready):
                seen.append(int(word["data"]))
        ctx.set(port.valid, 0)
        return seen

    async def bench(ctx):
        ctx.set(unit.result.ready, 1)
        for cycles in interrupted:
            if load is not None:
                await feed(ctx, load, coefficients)
            await feed(ctx, unit.taxel, [], stop=cycles)
            ctx.set(reset, 1)
            await ctx.tick().repeat(rng.randrange(1, 3))
            ctx.set(reset, 0)
        if load is not None:
            await feed(ctx, load, coefficients)
        got.extend(await feed(ctx, unit.taxel, codes.ravel().tolist()))
        for _ in range(20_000):
            if len(got) >= words.size:
                break
            _, _, valid, word = await ctx.tick().sample(unit.result.valid, unit.result.payload)
            if valid:
                got.append(int(word["data"]))

    played(ResetInserter(reset)(unit), bench)
    return got


@pytest.mark.usefixtures("stubbed")
@pytest.mark.parametrize(
    "interrupted", [(1, 240, 251), *long(((300, 480, 700),), *(((k, 3 * k),) for k in range(250, 900, 67)))]
)
def test_a_reset_leaves_nothing_behind(interrupted):
    skin = skin_of(12, 20, WINDOW, most=4)
    codes = np.concatenate([frames_of(skin, 0, 1), frames_of(skin, 5, 2)])
    want = records(skin, codes, stub_words)
    assert reset_run(skin, codes, want, None, interrupted, seed=1) == want.ravel().tolist()


def test_a_core_is_loaded_again_after_a_reset():
    window = learned_design(2, 2, counts=(1, 1), architecture=SERIAL)
    skin = skin_of(6, 9, window, most=4)
    codes = bumps(np.random.default_rng(1), (6, 9), 1)[None]
    want = records(skin, codes, window.model.words)
    loaded = microarchitecture(window).loaded.tolist()
    assert reset_run(skin, codes, want, loaded, (400,), seed=2) == want.ravel().tolist()


class Chosen(wiring.Component):
    """A skin's unit whose settings are driven by those of another."""

    def __init__(self, skin, choices):
        self._unit, self._choices = SkinUnit(skin), choices
        super().__init__({name: self._unit.signature.members[name] for name in ("taxel", "result")})

    def elaborate(self, platform):
        m = Module()
        m.submodules.unit = unit = self._unit
        wiring.connect(m, wiring.flipped(self.taxel), unit.taxel)
        wiring.connect(m, unit.result, wiring.flipped(self.result))
        m.d.comb += [
            unit.contacts.most.eq(self._choices.most),
            unit.contacts.threshold.eq(self._choices.word),
            unit.contacts.gap.eq(self._choices.gap),
        ]
        return m


@pytest.mark.usefixtures("stubbed")
def test_settings_are_those_of_the_ports():
    skin, other = skin_of(12, 20, WINDOW), skin_of(12, 20, WINDOW, most=2, gap=0, threshold=0.5)
    codes = frames_of(skin, 4, 4)
    want = records(other, codes, stub_words)
    assert want.shape != records(skin, codes, stub_words).shape
    seen = run(Chosen(skin, other.choices), {"taxel": codes.ravel().tolist()}, {"result": want.size}, limit=100_000)
    assert [word["data"] for word in seen.values["result"]] == want.ravel().tolist()
