"""Scaling against its model: words, order, status, stalls and latency."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from tests.hdl.parallel.designs import make
from tests.hdl.parallel.facts import transfers
from tests.marks import STALLS
from tfra.hdl.parallel.scaling import FACTS, Scaling
from tfra.model.choices import Formats
from tfra.model.fixed.design import Design
from tfra.model.fixed.gain import Gain, Resultant
from tfra.model.fixed.normaliser import Normalised
from tfra.model.fixed.scaling import scaling
from tfra.model.fixed.tfra.friction import Friction
from tfra.model.fixed.words import encode
from tfra.model.tfra import Status
from tfra.sim.harness import Recording, run

DESIGNS = {
    "4x4": make(4, 4, threshold=0),
    "3x5 wide": make(3, 5, "wide", threshold=0),
    "2x2 long": make(2, 2, Formats("long", 27, 27, 0, 16), bits=6, threshold=0),
    "3x2 short": make(3, 2, Formats("short", 10, 10, 16, 0), bits=10, threshold=0),
}


def facts(d: Design, n: int, seed: int) -> SimpleNamespace:
    """Random facts of ``n`` frames: words within their formats, the last ones at their ends."""
    rng, w, operand = np.random.default_rng(seed), d.widths, d.formats.operand

    def word(bits: int, *shape: int) -> np.ndarray:
        top = (1 << (bits - 1)) - 1
        x = rng.integers(-top - 1, top + 1, (n, *shape)) >> rng.integers(0, bits, (n, *shape))
        ends = rng.choice([0, 1, -1, top, -top - 1], (n, *shape))
        return np.where(rng.random((n, *shape)) < 0.3, ends, x)

    def flag() -> np.ndarray:
        return rng.random(n) < 0.5

    contact = rng.random(n) < 0.8
    frame = Normalised(
        np.zeros((n, d.sensor.taxels), dtype=np.int64),
        rng.integers(0, d.adc.bits, n),
        rng.integers(0, 1 << w.magnitude, n),
        contact,
        rng.random(n) < 0.8,
        flag(),
    )
    near = w.force + operand - w.output
    shifts = rng.integers(max(0, near - 6), near + 6, (2, n))
    shifts = np.where(rng.random((2, n)) < 0.3, rng.choice([0, 1, 62, 127], (2, n)), shifts)
    mantissa = rng.choice([0, 1, (1 << operand) - 1, (1 << (operand - 1)) + 5], n)
    return SimpleNamespace(
        frame=frame,
        gain=Gain(mantissa, *shifts, word(operand), rng.random(n) < 0.2),
        unscaled=word(w.force, 3, d.sensor.taxels),
        total=Resultant(word(w.division, 3), rng.integers(-40, 40, n)),
        chosen=Friction(rng.integers(0, d.candidates, n), *(word(operand) for _ in range(3)), flag()),
        no_direction=flag(),
        no_denominator=flag(),
        phi=rng.integers(0, 1 << operand, n),
    )


def send(d: Design, dut: Scaling, f: SimpleNamespace, **stalls: Any) -> Recording:
    """Every input port has a transfer a frame; forces have one a word."""
    inputs = {
        "taxel": f.unscaled.ravel().tolist(),
        "affine": [{"vanishing": int(flag)} for flag in f.no_denominator],
        "direction": [{"vanishing": int(flag)} for flag in f.no_direction],
        "phi": f.phi.tolist(),
        **{name: transfers(getattr(f, name)) for name in ("gain", "total", "chosen", "frame")},
    }
    return run(dut, inputs, {"result": len(f.phi) * d.frame_words}, **stalls)


def expected(d: Design, f: SimpleNamespace) -> np.ndarray:
    """Result words of the frames."""
    scaled = scaling(d, f.frame, f.gain, f.unscaled, f.total)
    regular = f.frame.regular
    flags = {
        Status.NO_CONTACT: ~f.frame.contact,
        Status.COMPRESSION_ONLY: f.frame.contact & ~f.frame.traction,
        Status.NO_DIRECTION: regular & f.no_direction,
        Status.VANISHING_DENOMINATOR: regular & f.no_denominator,
        Status.DEPENDENT_OUT_OF_RANGE: regular & f.chosen.out_of_range,
        Status.INPUT_SATURATED: f.frame.saturated,
        Status.OUTPUT_SATURATED: scaled.saturated,
    }
    values = {
        "frame": np.arange(len(f.phi)),
        "exponent": f.frame.exponent,
        "sweep_index": f.chosen.index,
        "phi": np.where(regular, f.phi, 0),
        "mu": f.gain.mu,
        "mu_x": f.chosen.mu_x,
        "mu_y": f.chosen.mu_y,
        "resultant": scaled.resultant,
        "forces": scaled.forces.reshape(len(f.phi), -1),
        "status": sum(np.where(on, int(flag), 0) for flag, on in flags.items()),
    }
    return encode(d, values)


def marked(words: np.ndarray) -> list[dict[str, int]]:
    """Result words ``(n, words)``, the last one of each frame marked."""
    end = words.shape[1] - 1
    return [{"data": int(word), "last": int(k == end)} for row in words for k, word in enumerate(row)]


def check(d: Design, f: SimpleNamespace, **stalls: Any) -> None:
    """Words, and the cycles when nothing stalls."""
    dut = Scaling(d)
    seen = send(d, dut, f, **stalls)
    assert seen.values["result"] == marked(expected(d, f))
    if not stalls:
        check_cycles(d, dut, seen.cycles)


def check_cycles(d: Design, dut: Scaling, cycles: dict[str, list[int]]) -> None:
    taxels = 3 * d.sensor.taxels
    by_frame = np.reshape(cycles["result"], (-1, d.frame_words))
    # Facts are valid in the first cycle, number 1, and the gain before its turn.
    assert by_frame[0, 0] == 2 + dut.latency
    assert (np.diff(by_frame) == 1).all()
    assert (by_frame[1:, 0] - by_frame[:-1, -1] == 3).all()
    assert (by_frame[:, 10:-1].ravel() - cycles["taxel"] == dut.force_latency).all()
    ends = np.array(cycles["taxel"])[taxels - 1 :: taxels]
    assert (by_frame[:, -1] - ends == dut.latency + 1).all()
    assert all(cycles[fact] == (ends + 2).tolist() for fact in FACTS)


@pytest.mark.parametrize("name", DESIGNS)
def test_equals_the_model(name):
    check(DESIGNS[name], facts(DESIGNS[name], 16, 1))


@pytest.mark.parametrize(("stall_in", "stall_out"), STALLS)
def test_survives_stalls(stall_in, stall_out):
    d = DESIGNS["3x2 short"]
    check(d, facts(d, 5, 3), stall_in=stall_in, stall_out=stall_out, seed=3)


@pytest.mark.parametrize("first", [False, True])
def test_saturation_of_one_word_reaches_its_status_only(first):
    """The very first resultant, or the very last force, is limited; the frames around it are clean."""
    d = DESIGNS["3x2 short"]
    f = facts(d, 3, 4)
    f.unscaled[:], f.total.words[:] = 0, 0
    f.gain.overflow[:], f.gain.mantissa[:], f.gain.force_shift[:], f.gain.resultant_shift[:] = False, 1, 0, 0
    f.frame.contact[:], f.frame.traction[:] = True, True
    f.unscaled[:, 2, -1] = -1 << (d.widths.output - 1)
    if first:
        f.gain.mantissa[1] = (1 << d.formats.operand) - 1
        f.total.words[1, 0] = (1 << (d.widths.division - 1)) - 1
        f.unscaled[1, 2, -1] = 0
    else:
        f.unscaled[1, 2, -1] -= 1
    words = expected(d, f)
    assert (words[:, -1] & Status.OUTPUT_SATURATED).tolist() == [0, Status.OUTPUT_SATURATED, 0]
    check(d, f)


def test_a_wrong_word_is_noticed():
    d = DESIGNS["3x2 short"]
    f = facts(d, 2, 7)
    wrong = expected(d, f)
    wrong[1, -3] ^= 1
    assert send(d, Scaling(d), f).values["result"] != marked(wrong)
