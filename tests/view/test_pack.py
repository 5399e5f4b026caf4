"""What a page's script reads is what the arrays are, as exact as was said."""

import base64
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from tests.view.made import project, unpacked, write
from tfra.model.choices import Search
from tfra.model.fixed.design import Design
from tfra.model.learned.field import influence
from tfra.model.tfra import Tfra
from tfra.view.pack import MOST_BYTES, MOST_SWEEP_BYTES, Chosen, frame_bytes, packed, result, scaled, sweep_bytes, times
from tfra.view.resultfile import Recorded, References, read_all


@pytest.fixture(scope="module")
def read(tmp_path_factory: pytest.TempPathFactory) -> tuple[list[Recorded], list[References]]:
    folder = tmp_path_factory.mktemp("results")
    write(folder)
    return read_all([folder / f"{name}.npz" for name in ("float", "fixed", "frames")])


@given(arrays(np.float64, (3, 5), elements=st.floats(-1e12, 1e12)))
def test_codes_are_as_exact_as_16_bits(planes: np.ndarray) -> None:
    found = {key: unpacked(value) for key, value in scaled(planes).items()}
    again = found["codes"].reshape(3, 5) * found["scale"].astype(np.float64)[:, None]
    largest = np.abs(planes).max(axis=1, keepdims=True)
    assert (np.abs(again - planes) <= 2e-5 * largest + 1e-37).all()
    assert ((again >= 0) | (planes <= 0)).all()


def test_bytes_are_little_endian() -> None:
    assert packed(np.array([1, -2]), "int16") == {"type": "int16", "data": base64.b64encode(b"\1\0\xfe\xff").decode()}


def test_a_frame_has_the_bytes_that_were_counted(read: tuple[list[Recorded], list[References]]) -> None:
    plain, chosen = read[0][0], Chosen(range(24), 24, 1, False)
    held = replace(plain.found, uncertainty=np.ones(24), threshold=0.25, residual=np.ones(24))
    content = result(replace(plain, found=held), chosen)
    sweep = sum(unpacked(part).nbytes for part in content.pop("sweep").values())
    assert sweep == 24 * sweep_bytes(100)

    def size(of: Any) -> int:
        if isinstance(of, dict) and "data" in of:
            return unpacked(of).nbytes
        return sum(map(size, of.values() if isinstance(of, dict) else of))

    clock = times(read[0], chosen)
    assert clock is not None
    assert content.pop("threshold") == 25
    assert size(content) + size(clock) == 24 * frame_bytes(24)
    del content["forces"], content["left"]
    alone = replace(held, forces=np.full((24, 3, 4, 6), np.nan))
    assert result(replace(plain, found=alone, swept=False), chosen) == content | {"threshold": 25}
    assert size(content) + size(clock) == 24 * frame_bytes(24, resultant_alone=True)


def test_what_forces_leave_unexplained(read: tuple[list[Recorded], list[References]]) -> None:
    """The layer's own stress of the very forces is explained; what is added to it is left, with its sign."""
    plain = read[0][0]
    g = influence(plain.design.sensor)
    under = sum(plain.found.forces[:, axis].reshape(24, -1) @ matrix.T for axis, matrix in enumerate((g.x, g.y, g.z)))
    added = np.zeros((24, 24))
    added[:, 7] = np.linspace(-9e3, 9e3, 24)
    content = result(replace(plain, stress=(under + added).reshape(24, 4, 6)), Chosen(range(24), 24, 1, False))
    left = unpacked(content["left"]["codes"]).reshape(24, 24) * unpacked(content["left"]["scale"])[:, None]
    np.testing.assert_allclose(left, added, atol=0.5)
    share = np.linalg.norm(added, axis=1) / np.linalg.norm(under + added, axis=1)
    np.testing.assert_allclose(unpacked(content["values"]["residual"]), 100 * share, atol=1e-4)


# The frames of a page


@pytest.fixture
def design(tmp_path: Path) -> Design:
    return project(tmp_path).design


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
