"""How many frames a page has, and what it says of those left out."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.view import made
from tfra.model.choices import Search
from tfra.model.fixed.design import Design
from tfra.model.tfra import Tfra
from tfra.view.chosen import MOST_BYTES, MOST_SWEEP_BYTES, Chosen, frame_bytes, sweep_bytes
from tfra.view.resultfile import Recorded


@pytest.fixture
def design(tmp_path: Path) -> Design:
    return made.project(tmp_path).design


def recorded(design: Design, count: int) -> Recorded:
    """A result of ``count`` frames, none of whose values is looked at."""
    found = Tfra.of(design)(np.zeros((1, 4, 6)))
    return Recorded("a.npz", "float", design, found, np.broadcast_to(0.0, (count, 4, 6)), None)


def test_few_frames_are_all_shown(design: Design) -> None:
    chosen = Chosen.of([recorded(design, 24)], range(24))
    assert chosen == Chosen(range(24), 24, 1, False)
    assert str(chosen) == "All 24 frames are shown."


def test_a_part_is_told(design: Design) -> None:
    result = [recorded(design, 24)]
    assert str(Chosen.of(result, range(5, 9))) == "4 of 24 frames are shown: frames 5 to 8."
    assert str(Chosen.of(result, range(0, 24, 3))) == "8 of 24 frames are shown: every 3rd frame from 0 to 21."


@pytest.mark.parametrize("count", [40_000, 60_000, 123_456])
@pytest.mark.parametrize("number", [1, 2])
def test_many_are_thinned_out_evenly_to_what_there_is_room_for(design: Design, count: int, number: int) -> None:
    chosen = Chosen.of([recorded(design, count)] * number, range(1, count, 2))
    step = chosen.shown.step
    assert step % 2 == 0
    size = number * frame_bytes(24)
    assert len(chosen.shown) * size <= MOST_BYTES
    if step > 2:
        assert len(range(1, count, step - 2)) * size > MOST_BYTES
    assert chosen.full == (step > 2)
    assert ("no room for more" in str(chosen)) == chosen.full
    assert -(-len(chosen.shown) // chosen.sweeps) * number * sweep_bytes(100) <= MOST_SWEEP_BYTES


def test_more_frames_have_room_without_forces_at_the_taxels(design: Design) -> None:
    """Frames of the resultant alone are counted by their own size."""
    whole = recorded(design, 200_000)
    short = replace(whole, found=replace(whole.found, forces=np.full((1, 3, 4, 6), np.nan)), swept=False)
    counts = [len(Chosen.of(results, range(200_000)).shown) for results in ([short], [short, whole], [whole])]
    sizes = frame_bytes(24, resultant_alone=True), frame_bytes(24)
    assert counts == [-(-200_000 // -(-200_000 * size // MOST_BYTES)) for size in (sizes[0], sum(sizes), sizes[1])]
    assert counts[0] > counts[2] > counts[1]


def test_long_sweeps_are_those_of_some_frames(design: Design) -> None:
    fine = replace(design, search=Search(4096))
    chosen = Chosen.of([recorded(fine, 500)], range(500))
    assert chosen.shown == range(500)
    assert chosen.sweeps == 3
    assert str(chosen) == "All 500 frames are shown; every 3rd of them has its sweep."
