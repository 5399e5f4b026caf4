"""Records: the header of every contact before the words of its window."""

import numpy as np
import pytest

from tests.hdl.skin.skins import skin_of
from tests.marks import STALLS
from tfra.hdl.skin.records import Records
from tfra.model.skin.records import header_bits
from tfra.sim.harness import run

SKIN = skin_of(12, 20)
COUNT, WORDS = 14, 5


@pytest.mark.parametrize(("stall_in", "stall_out"), STALLS)
def test_headers_and_words_alternate(stall_in, stall_out):
    rng, bits = np.random.default_rng(5), header_bits(SKIN)
    fields = {name: rng.integers(0, 1 << size, COUNT) for name, size in bits.items()}
    fields["last"][-1] = 1
    words = rng.integers(-(1 << 15), 1 << 15, (COUNT, WORDS))
    ends = np.flatnonzero(fields["last"])
    fields["frame"] = np.searchsorted(ends, np.arange(COUNT))
    starts = np.concatenate([[0], ends + 1])
    fields["contact"] = np.arange(COUNT) - starts[fields["frame"]]
    want = np.concatenate([np.stack([fields[name] for name in bits], axis=1), words], axis=1)

    def payloads(*names, **others):
        return [{name: int(fields[name][k]) for name in names} | others for k in range(COUNT)]

    inputs = {
        "contact": payloads("row", "column", "taxels", "marks", top=0, left=0),
        "ending": payloads("last", "dropped"),
        "words": [{"data": int(word), "last": k == WORDS - 1} for each in words for k, word in enumerate(each)],
    }
    seen = run(Records(SKIN), inputs, {"result": want.size}, stall_in=stall_in, stall_out=stall_out)
    assert [word["data"] for word in seen.values["result"]] == want.ravel().tolist()
    assert np.flatnonzero([word["last"] for word in seen.values["result"]]).tolist() == list(
        range(want.shape[1] - 1, want.size, want.shape[1])
    )
