"""Tracks against the best of all assignments, and what a track is by the letter."""

from itertools import permutations
from types import SimpleNamespace
from typing import Any

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from tfra.model.skin.result import SkinResult
from tfra.model.skin.tracking import Tracker, tracks


def test_a_contact_keeps_its_number_while_it_moves_little() -> None:
    tracker = Tracker(3.0)
    assert tracker(np.array([[0.0, 0.0], [10.0, 0.0]])).tolist() == [0, 1]
    assert tracker(np.array([[10.0, 2.9], [0.0, 0.0]])).tolist() == [1, 0]
    assert tracker(np.array([[10.0, 6.0], [2.0, 2.0]])).tolist() == [2, 0]  # the first moved by 3.1
    assert tracker(np.empty((0, 2))).tolist() == []
    assert tracker(np.array([[2.0, 2.0]])).tolist() == [3]  # it was away for a frame


def test_contacts_that_pass_each_other_are_not_confused() -> None:
    """The nearest pair first would leave the other one alone."""
    tracker = Tracker(3.0)
    tracker(np.array([[0.0, 0.0], [2.0, 0.0]]))
    assert tracker(np.array([[1.6, 0.0], [4.4, 0.0]])).tolist() == [0, 1]


def test_frames_without_contacts_are_counted() -> None:
    places = np.array([[0.0, 0.0], [0.0, 1.0], [0.0, 2.0]])
    assert tracks(np.array([0, 1, 1, 0, 1, 0]), places, 2.0).tolist() == [0, 0, 1]
    assert tracks(np.array([0, 0]), np.empty((0, 2)), 2.0).tolist() == []


def test_a_contact_is_followed_over_two_pitches_unless_told_otherwise() -> None:
    places: Any = SimpleNamespace(x=np.array([0.0, 5.9]), y=np.array([0.0, 0.0]), found=np.array([1, 1]), pitch=3.0)
    assert SkinResult.tracks(places).tolist() == [0, 0]
    assert SkinResult.tracks(places, 5.8).tolist() == [0, 1]
    places.pitch = 2.9
    assert SkinResult.tracks(places).tolist() == [0, 1]


_PLACES = st.lists(st.tuples(st.integers(0, 12), st.integers(0, 12)), max_size=4, unique=True)


@settings(deadline=None, max_examples=100)
@given(_PLACES, _PLACES)
def test_as_many_as_possible_keep_their_numbers(before: list[tuple[int, int]], after: list[tuple[int, int]]) -> None:
    tracker = Tracker(4.5)
    tracker(np.array(before, dtype=float).reshape(-1, 2))
    numbers = tracker(np.array(after, dtype=float).reshape(-1, 2)).tolist()
    pairs = [(before[number], place) for number, place in zip(numbers, after, strict=True) if number < len(before)]
    shortest, longest = sorted((before, after), key=len)
    lengths = [
        [d for a, b in zip(way, shortest, strict=True) if (d := (a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2) < 4.5**2]
        for way in permutations(longest, len(shortest))
    ]
    best = min((-len(each), sum(each)) for each in lengths)
    assert (-len(pairs), sum((a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2 for a, b in pairs)) == best
    assert len(set(numbers)) == len(numbers)
