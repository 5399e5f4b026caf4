"""Finding against plain loops and fractions, and in the corners of its input."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from tests.model.skin.plain import contacts
from tfra.model.skin.finding import Finding, Found, Mark, finding, taken
from tfra.model.skin.windows import corners, places, windows

SHAPES = st.tuples(st.integers(2, 9), st.integers(2, 9))
CODES = st.sampled_from((-8192, -4000, -2000, -1000, -300, -64, -1, 0, 0, 0, 0, 5, 800, 8191))


@given(
    codes=SHAPES.flatmap(lambda shape: arrays(np.int64, (2, *shape), elements=CODES)),
    window=st.tuples(st.integers(2, 5), st.integers(2, 5)),
    most=st.integers(1, 4),
    word=st.integers(1, 256),
    gap=st.integers(0, 3),
    least=st.sampled_from((0, 1, 64)),
)
def test_contacts_are_those_of_plain_loops(codes, window, most, word, gap, least):
    found = finding(Finding(most, word / 256, gap), window, least, codes)
    start, owned = 0, taken(Finding(most, word / 256, gap), least, codes)
    for number, grid in enumerate(codes):
        plain, dropped = contacts(grid.tolist(), window, most, Fraction(word, 256), gap, least)
        assert (found.found[number], found.dropped[number]) == (len(plain), dropped)
        for at, each in enumerate(plain, start):
            assert (found.frame[at], found.contact[at]) == (number, at - start)
            assert found.taxels[at] == len(each.region)
            row, column = (int(np.floor(16 * middle + Fraction(1, 2))) for middle in each.middle)
            assert (found.row[at], found.column[at]) == (row, column)
            assert (found.top[at], found.left[at]) == each.corner
            assert found.marks[at] == _marks(each, window, grid.shape)
        about = range(-gap, gap + 1)
        own = {(row + i, column + j) for each in plain for row, column in each.region for i in about for j in about}
        assert {tuple(place) for place in np.argwhere(owned[number]).tolist()} == own & set(np.ndindex(grid.shape))
        start += len(plain)
    assert start == len(found.frame)


def _marks(plain, window, whole):
    (top, left), (rows, columns) = plain.corner, window
    inside = all(top <= row < top + rows and left <= column < left + columns for row, column in plain.region)
    at_edge = min(top, left) < 0 or top + rows > whole[0] or left + columns > whole[1]
    return Mark.EDGE * at_edge | Mark.LARGE * (not inside) | Mark.TOUCHING * plain.touching


def pressed(*taxels, shape=(12, 14), code=-1000):
    frames = np.zeros((1, *shape), dtype=np.int64)
    for row, column in taxels:
        frames[0, row, column] = code
    return frames


def found_in(frames, window=(4, 4), least=0, **choices) -> Found:
    return finding(Finding(**choices), window, least, frames)


def test_a_taxel_is_a_contact_in_the_middle_of_its_window():
    found = found_in(pressed((5, 7)))
    assert (found.row[0], found.column[0], found.taxels[0]) == (80, 112, 5)  # the neighbours are half as high
    assert (found.top[0], found.left[0], found.marks[0]) == (4, 6, 0)


def test_an_empty_frame_has_no_contact_and_traction_is_none():
    for frames in (pressed(), pressed((5, 7), code=1000)):
        found = found_in(frames)
        assert (len(found.frame), found.found.tolist(), found.dropped.tolist()) == (0, [0], [0])


def test_a_frame_that_is_pressed_everywhere_is_one_large_contact():
    found = found_in(np.full((1, 12, 14), -8192))
    assert found.taxels.tolist() == [12 * 14]  # corners have nine sixteenths of the weights
    assert found.marks[0] & Mark.LARGE
    assert found.dropped[0] == 0


def test_peaks_beyond_the_most_are_counted():
    found = found_in(pressed((2, 2), (2, 8), (8, 2), (8, 8)), most=3)
    assert (found.contact.tolist(), found.dropped.tolist()) == ([0, 1, 2], [1])


def test_contacts_come_by_their_height_and_level_ones_in_order_of_taxels():
    frames = pressed((8, 2), (2, 8)) + pressed((9, 9), code=-1001)
    found = found_in(frames)
    assert list(zip(found.row // 16, found.column // 16, strict=True)) == [(9, 9), (2, 8), (8, 2)]


@pytest.mark.parametrize(("share", "count"), [(0.04, 2), (0.05, 1)])
def test_the_threshold_is_a_share_of_the_highest_peak(share, count):
    frames = pressed((3, 3)) + pressed((9, 9), code=-40)
    assert found_in(frames, threshold=share).found.tolist() == [count]


@pytest.mark.parametrize(("least", "count"), [(250, 1), (251, 0)])
def test_the_floor_is_the_mean_compression_of_the_weights(least, count):
    assert found_in(pressed((3, 3)), least=least).found.tolist() == [count]


def test_two_regions_that_grow_together_are_one_and_a_weaker_one_is_marked():
    assert found_in(pressed((5, 5), (5, 6), (5, 7))).found.tolist() == [1]
    slope = pressed((5, 4)) + sum(pressed((5, column), code=-400) for column in (8, 9)) + pressed((5, 7), code=-300)
    found = found_in(slope)
    assert (found.marks & Mark.TOUCHING).tolist() == [0, Mark.TOUCHING]


def test_places_round_halves_up_and_corners_put_a_window_about_them():
    assert places(np.array([1, 1, 5]), np.array([1, 32, 3])).tolist() == [16, 1, 27]
    assert corners(np.array([80, 87, 88]), 4).tolist() == [4, 4, 4]
    assert corners(np.array([80, 87, 88]), 5).tolist() == [3, 3, 4]


def test_windows_are_zero_beyond_the_array():
    frames = np.arange(1, 13).reshape(1, 3, 4)
    cut = windows(frames, np.array([0]), (np.array([-1]), np.array([2])), (3, 3))
    assert cut.tolist() == [[[0, 0, 0], [3, 4, 0], [7, 8, 0]]]


@pytest.mark.parametrize(
    ("choices", "reason"),
    [
        ({"most": 0}, "most: 1 to 64 is supported, got 0"),
        ({"threshold": 0.001}, "threshold: 0.0039 to 1 is supported, got 0.001"),
        ({"threshold": float("nan")}, "threshold: 0.0039 to 1 is supported, got nan"),
        ({"gap": 5}, "gap: 0 to 4 is supported, got 5"),
    ],
)
def test_choices_are_checked(choices, reason):
    with pytest.raises(ValueError, match="^" + reason):
        Finding(**choices)
