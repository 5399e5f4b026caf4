"""Weights for dead taxels: exact for planes, the known stencil in the middle, sensible at corners and in clusters."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tfra.model.fixed.repair import HEADER, ONE, PLACE, repaired, repairs, thin_plate


def dead(shape: tuple[int, int], *places: tuple[int, int]) -> np.ndarray:
    mask = np.zeros(shape, dtype=bool)
    for place in places:
        mask[place] = True
    return mask


def test_alone_in_the_middle_it_is_the_biharmonic_stencil():
    found = thin_plate(dead((7, 7), (3, 3)))[0].reshape(7, 7) * 20
    near, diagonal, far = 8.0, -2.0, -1.0
    expected = np.zeros((7, 7))
    expected[[2, 4, 3, 3], [3, 3, 2, 4]] = near
    expected[[2, 2, 4, 4], [2, 4, 2, 4]] = diagonal
    expected[[1, 5, 3, 3], [3, 3, 1, 5]] = far
    assert np.allclose(found, expected, atol=1e-9)


def test_a_corner_goes_on_as_a_plane_with_least_curvature():
    found = thin_plate(dead((4, 4), (0, 0)))[0].reshape(4, 4) * 4
    assert np.allclose(found[:3, :3], [[0, 4, -1], [4, -2, 0], [-1, 0, 0]], atol=1e-9)


@given(st.integers(2, 6), st.integers(2, 6), st.data())
@settings(max_examples=60, deadline=None)
def test_planes_are_repaired_exactly(rows, columns, data):
    taxels = rows * columns
    mask = np.zeros(taxels, dtype=bool)
    mask[list(data.draw(st.sets(st.integers(0, taxels - 1), max_size=max(1, taxels // 8))))] = True
    if (~mask).sum() < 4:
        return
    mask = mask.reshape(rows, columns)
    y, x = np.indices((rows, columns))
    plane = 40 * x - 70 * y + 500
    found, _ = repaired(np.where(mask, 0, plane).reshape(1, -1), repairs(mask), 14)
    assert np.abs(found.reshape(rows, columns) - plane).max() <= 1


@pytest.mark.parametrize("size", [(2, 2), (3, 4)])
def test_an_array_that_is_dead_reads_zero(size):
    words = repairs(np.ones(size, dtype=bool))
    assert words.tolist() == [HEADER | taxel << PLACE for taxel in range(size[0] * size[1])]
    codes, largest = repaired(np.full((1, size[0] * size[1]), 99), words, 14)
    assert not codes.any()
    assert largest.tolist() == [0]


def test_no_dead_taxel_needs_no_word():
    assert len(repairs(np.zeros((3, 3), dtype=bool))) == 0


def test_a_wrong_weight_is_noticed():
    words = repairs(dead((5, 5), (2, 2)))
    plane = np.arange(25)[None] * 40
    assert repaired(plane, words, 14)[0].tolist() == plane.tolist()
    words[1] += ONE // 16
    assert repaired(plane, words, 14)[0].tolist() != plane.tolist()
