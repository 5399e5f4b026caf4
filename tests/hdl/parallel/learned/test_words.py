"""Words against the layout: header, forces and status of frames, whatever stalls."""

import random

import numpy as np
import pytest

from tests.marks import STALLS
from tests.model.fixed.learned.cases import learned_design
from tfra.hdl.parallel.learned.words import Words
from tfra.model.fixed.words import encode
from tfra.model.tfra import Status
from tfra.sim.harness import run

NUMBER = 5
SCALARS = ("mu", "mu_x", "mu_y")


def draw(design, seed):
    """Facts and forces of frames, and the result words that they make."""
    rng, formats, w = random.Random(seed), design.formats, design.widths

    def word(bits):
        return rng.randrange(-1 << (bits - 1), 1 << (bits - 1))

    def bit():
        return rng.randrange(2)

    frames, headers, taxels, values = [], [], [], {name: [] for name in (f.name for f in design.layout)}
    for number in range(NUMBER):
        contact, saturated, still, implausible, limited, overflow = (bit() for _ in range(6))
        exponent = rng.randrange(8)
        phi, scalars = rng.randrange(1 << formats.bits("cordic")), {n: word(formats.bits("scalar")) for n in SCALARS}
        outputs = [word(w.output) for _ in range(4)]
        forces = [word(w.output) for _ in range(3 * design.sensor.taxels)]
        over = rng.randrange(len(forces)) if bit() else None
        frames.append({"exponent": exponent, "contact": contact, "saturated": saturated, "magnitude": 0, "traction": 0})
        judged = {"words": outputs[:3], "uncertainty": outputs[3], "limited": limited, "implausible": implausible}
        angle, friction = {"phi": phi, "still": still}, scalars | {"overflow": overflow}
        headers.append({"judged": judged, "angle": angle, "friction": friction})
        taxels += [
            {"word": force, "limited": int(n == over), "last": int(n == len(forces) - 1)}
            for n, force in enumerate(forces)
        ]
        status = Status.NO_CONTACT * (1 - contact) | Status.INPUT_SATURATED * saturated
        status |= (Status.NO_DIRECTION * still | Status.IMPLAUSIBLE * implausible) * contact
        some = limited or overflow or (design.taxel_forces and over is not None)
        status |= Status.OUTPUT_SATURATED * bool(some)
        found = {"frame": number, "exponent": exponent, "phi": phi, **scalars, "resultant": outputs[:3]}
        found |= {"uncertainty": outputs[3], "forces": forces, "status": int(status)}
        for name in values:
            values[name].append(found[name])
    words = encode(design, {name: np.array(found) for name, found in values.items()})
    return frames, headers, taxels, words


def check(design, seed=0, **stalls):
    frames, headers, taxels, want = draw(design, seed)
    inputs = {"frame": frames, "header": headers} | ({"taxel": taxels} if design.taxel_forces else {})
    outputs = {"result": want.size, "frame_token": NUMBER}
    seen = run(Words(design), inputs, outputs, seed=seed, steady=("frame",), **stalls)
    assert [word["data"] for word in seen.values["result"]] == want.ravel().tolist()
    ends = [word["last"] for word in seen.values["result"]]
    assert np.flatnonzero(ends).tolist() == [design.frame_words * (n + 1) - 1 for n in range(NUMBER)]
    return seen


@pytest.mark.parametrize("forces", [True, False])
@pytest.mark.parametrize(("stall_in", "stall_out"), STALLS)
def test_words_are_those_of_the_layout(forces, stall_in, stall_out):
    check(learned_design(2, 3, taxel_forces=forces), 3, stall_in=stall_in, stall_out=stall_out)


def test_latency_is_as_stated_and_words_follow_in_every_cycle():
    design = learned_design(2, 2)
    seen = check(design)
    assert seen.cycles["result"][0] == Words.latency + 1  # facts are offered from the second cycle on
    assert np.diff(seen.cycles["result"][: design.frame_words]).tolist() == [1] * (design.frame_words - 1)


def test_a_token_is_given_back_with_each_status():
    """Four at first; the fifth when a frame has left."""
    design = learned_design(2, 2, taxel_forces=False)
    frames, headers, *_ = draw(design, 1)
    seen = run(Words(design), {"frame": frames[:1], "header": headers[:1]}, {"frame_token": 5, "result": 11})
    # The status enters the output register; its token is given in the next cycle, and seen in the one after that.
    assert seen.cycles["frame_token"][3] < seen.cycles["result"][-1] == seen.cycles["frame_token"][4] - 1
    with pytest.raises(AssertionError, match="no end"):
        run(Words(design), {"frame": frames[:1], "header": headers[:1]}, {"frame_token": 6, "result": 11}, limit=500)


def test_a_wrong_bit_is_noticed():
    design = learned_design(2, 2, taxel_forces=False)
    frames, headers, _, want = draw(design, 4)
    headers[2]["judged"]["implausible"] ^= 1
    frames[2]["contact"] = 1
    seen = run(Words(design), {"frame": frames, "header": headers}, {"result": want.size})
    assert [word["data"] for word in seen.values["result"]] != want.ravel().tolist()
