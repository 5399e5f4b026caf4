"""Results that are kept until there is no more room."""

import warnings

import numpy as np
import pytest

from tfra.recordings import record
from tfra.runtime.errors import Notice


def test_a_record_has_no_room_for_ever(monkeypatch: pytest.MonkeyPatch) -> None:
    """Here for three frames: what was estimated together is kept together, the rest is told once."""
    monkeypatch.setattr(record, "MOST_BYTES", 3 * 8 * 6)
    kept = record.Record(lambda stress: stress.sum(axis=(1, 2)), np.concatenate)
    assert kept.kept() is None
    stress = np.arange(7 * 6.0).reshape(7, 2, 3)
    kept(np.zeros((1, 2, 3)))  # nobody keeps this
    with warnings.catch_warnings(record=True, category=Notice, action="always") as told:
        for part in (slice(0, 2), slice(2, 4), slice(4, 7)):
            kept(stress[part])
            kept.keep(0.1 * np.arange(7)[part])
    line = "--out: 4 frames are all that there is room for: later ones are shown alone"
    assert [str(each.message) for each in told] == [line]
    found = kept.kept()
    assert found is not None
    recording, result = found
    np.testing.assert_array_equal(recording.frames, stress[:4])
    np.testing.assert_array_equal(recording.time, 0.1 * np.arange(4))
    np.testing.assert_array_equal(result, stress[:4].sum(axis=(1, 2)))
