"""What a page's script reads is what the arrays are, as exact as was said."""

import base64
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from tests.view.made import unpacked, write
from tfra.view.chosen import Chosen, frame_bytes, sweep_bytes
from tfra.view.pack import packed, result, scaled, times
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
    del content["forces"]
    alone = replace(held, forces=np.full((24, 3, 4, 6), np.nan))
    assert result(replace(plain, found=alone, swept=False), chosen) == content | {"threshold": 25}
    assert size(content) + size(clock) == 24 * frame_bytes(24, resultant_alone=True)
