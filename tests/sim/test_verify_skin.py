"""Verification of a skin: it passes what is right, and names what is wrong."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rich.console import Console

from tests.hdl.skin.skins import frames_of, skin_of
from tests.sim.test_skin import TINY, words
from tfra.model.skin.records import header_bits
from tfra.sim import verify_skin as module
from tfra.sim.protocol import Outcome
from tfra.sim.render import page, render
from tfra.sim.run import ProtocolError, Run
from tfra.sim.run import simulate as really
from tfra.sim.verify_skin import verify_skin

SKIN = skin_of(6, 9, TINY, most=8)
FRAMES = frames_of(SKIN, 0, 4) * SKIN.adc.lsb


@pytest.fixture(autouse=True)
def cache(builds: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("TFRA_CACHE", str(builds))
    return builds


@pytest.mark.long
def test_a_good_core_passes() -> None:
    progress: list[tuple[int, int]] = []
    report = verify_skin(SKIN, FRAMES, "icarus", random=3, progress=lambda *now: progress.append(now))
    assert report.passed
    assert report.kinds == {"given": 4, "random": 3, "directed": 7}
    assert sum(done for done, _ in progress) == report.frames == 14
    assert report.words == report.compared > 14 * len(header_bits(SKIN))
    assert report.cycles is not None
    assert 54 <= report.cycles[0] <= report.cycles[1]
    assert {"EDGE", "LARGE", "TOUCHING"} <= set(report.marks)
    assert report.against_float is not None
    assert report.against_float["mu against double precision, median"] < 0.05
    assert json.loads(json.dumps(report.as_dict(), allow_nan=False))["passed"]
    console = Console(record=True, width=80)
    render(report, console)
    assert "every bit equals the model" in console.export_text()
    assert "4 given, 3 random, 7 directed" in page(report)


def wrong_in(frame: int, contact: int, word: int) -> Any:
    """A simulation whose core flips the lowest bit of a word of a contact, counted over the frames of a run."""
    names = list(header_bits(SKIN))

    def simulated(skin: Any, codes: Any, *stated: Any, **options: Any) -> Run:
        run = really(skin, codes, *stated, **options)
        numbers = [run.words[:, names.index(name)] for name in ("frame", "contact")]
        place = np.flatnonzero((numbers[0] == frame) & (numbers[1] == contact))
        changed = run.words.copy()
        changed[place, word] ^= 1
        return replace(run, words=changed)

    return simulated


@pytest.mark.long
def test_a_wrong_word_is_named(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """By its frame among all, of which the first run has every third."""
    monkeypatch.setattr(module, "simulate", wrong_in(1, 0, 4))
    report = verify_skin(SKIN, FRAMES, "icarus", random=3, waves=tmp_path / "waves.vcd")
    assert not report.passed
    assert report.mismatches == 3  # one of each run
    expected = int(words(SKIN, frames_of(SKIN, 0, 4)[3:])[0, 4])
    assert report.first == (
        f"frame 3 (stalls: none), contact 0, field row, word 4: {expected} expected, {expected ^ 1} observed"
    )
    assert report.recorded == 3
    assert (tmp_path / "waves.vcd").stat().st_size > 1000
    assert "first mismatch: frame 3" in page(report)


def test_a_broken_stream_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    def breaks(*_: Any, **options: Any) -> Run:
        raise ProtocolError(Outcome(violations=["last is missing"]))

    monkeypatch.setattr(module, "simulate", breaks)
    report = verify_skin(SKIN, FRAMES, "icarus", random=0)
    assert not report.passed
    assert report.violations[0] == "stalls none: last is missing"
    assert (report.compared, report.mismatches, report.against_float, report.cycles) == (0, 0, None, None)
