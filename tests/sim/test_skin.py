"""The Verilog of skins in simulators: records of the model, whatever the stalls are."""

import numpy as np
import pytest

from tests.hdl.skin.skins import frames_of, learned_window, skin_of, small_window
from tests.marks import long
from tests.model.fixed.learned.cases import learned_design
from tfra.model.choices import Architecture
from tfra.model.fixed.design import Design
from tfra.model.skin.records import records
from tfra.model.skin.skin import Skin
from tfra.sim.run import simulate

SERIAL = Architecture(kind="serial", mac_lanes=0, vector_words=0)
TINY = learned_design(2, 2, counts=(1, 1), architecture=SERIAL)
LOADED = learned_design(2, 3, (2, 1), 8, images="load", lanes=8)


def words(skin: Skin, codes: np.ndarray) -> np.ndarray:
    return records(skin, codes, lambda windows: skin.window.model(windows).words)


@pytest.mark.parametrize(
    ("window", "shape", "count", "simulator", "stalls"),
    [
        (TINY, (6, 9), 6, "icarus", ("random", "bursts")),
        *long(
            (small_window(4, 4), (12, 20), 12, "icarus", ("bursts", "random")),
            (LOADED, (12, 20), 12, "icarus", ("none", "none")),
            (learned_window(), (127, 65), 6, "verilator", ("none", "random")),
        ),
    ],
)
def test_every_word_is_that_of_the_model(
    window: Design, shape: tuple[int, int], count: int, simulator: str, stalls: tuple[str, str]
) -> None:
    skin = skin_of(*shape, window, most=8)
    codes = frames_of(skin, 0, count)
    want = words(skin, codes)
    run = simulate(skin, codes, simulator, seed=3, stall_in=stalls[0], stall_out=stalls[1], expected=want)
    np.testing.assert_array_equal(run.words, want)
    assert (run.compared, run.mismatches) == (want.size, 0)
    assert len(run.latency) == len(run.interval) + 1 == count


def test_a_wrong_word_is_noticed() -> None:
    skin = skin_of(6, 9, TINY, most=8)
    codes = frames_of(skin, 0, 2)
    wrong = words(skin, codes)
    wrong[1, 5] ^= 1
    assert simulate(skin, codes, "icarus", expected=wrong).mismatches == 1
