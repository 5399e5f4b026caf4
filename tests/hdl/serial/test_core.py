"""The gateware executes the program as the interpreter does: bit-exact words, exact cycles, any stalls."""

from itertools import chain, repeat

import numpy as np
import pytest

from tests.hdl.serial.designs import DESIGNS, LEARNED
from tests.marks import long
from tfra.hdl.cores import as_serial
from tfra.hdl.serial.program.memory import store_image
from tfra.model.cover.scenes import contact_codes, directed_codes
from tfra.model.tfra import Status
from tfra.sim.harness import bursts, random_stalls, run


def stream(design, codes, **stalls):
    want = design.model(codes).words
    inputs = {"load": store_image(design).ravel().tolist(), "taxel": codes.ravel().tolist()}
    seen = run(as_serial(design).build(), inputs, {"result": want.size}, **stalls)
    words = np.array([word["data"] for word in seen.values["result"]]).reshape(want.shape)
    last = np.array([word["last"] for word in seen.values["result"]]).reshape(want.shape)
    taken = np.array(seen.cycles["taxel"]).reshape(len(codes), -1)
    return as_serial(design), words, want, last, np.array(seen.cycles["result"]).reshape(want.shape), taken


CORES = [DESIGNS["2×3"], LEARNED["2×3, forces"], *long(LEARNED["3×5"])]


@pytest.mark.parametrize("design", CORES, ids=["TFRA", "learned", "learned, no forces"])
def test_words_and_cycles(design):
    """Of a core that is loaded before the first taxel comes."""
    codes = np.concatenate([contact_codes(design, 1, seed=1), directed_codes(design)[[-3]]])
    loading = [True] * (store_image(design).size + 50)
    late = {"steady": ["load"], "stall_in": lambda _: chain(loading, repeat(False))}
    timing, words, want, last, cycles, taken = stream(design, codes, **late)
    assert (words == want).all()
    assert (want[:, -1] & Status.NO_CONTACT).tolist() == [0, 1]
    assert last[:, -1].all()
    assert last.sum() == len(want)
    assert taken[0, -1] - taken[0, 0] == timing.intake
    assert cycles[0, 0] - taken[0, -1] == timing.latency
    assert cycles[0, -1] - taken[0, -1] == timing.frame_latency
    assert tuple(cycles[1, [0, -1]] - taken[0, -1]) == timing.queued(1)
    assert (np.diff(cycles[:, -1]) == timing.initiation_interval).all()


@pytest.mark.parametrize(
    ("design", "stall_in", "stall_out"),
    [
        (DESIGNS["2×3"], random_stalls, bursts),
        *long((DESIGNS["short"], bursts, random_stalls)),
        (LEARNED["2×2"], bursts, random_stalls),
    ],
)
def test_stalls_change_nothing(design, stall_in, stall_out):
    codes = contact_codes(design, 1, seed=4)
    _, words, want, *_ = stream(design, codes, stall_in=stall_in, stall_out=stall_out, seed=5)
    assert (words == want).all()


@pytest.mark.parametrize("design", long(DESIGNS["wide"], *LEARNED.values()))
def test_any_words(design):
    codes = np.concatenate([contact_codes(design, 1, seed=2), directed_codes(design)[:1]])
    _, words, want, *_ = stream(design, codes)
    assert (words == want).all()
