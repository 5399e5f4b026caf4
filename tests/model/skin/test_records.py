"""Records: headers, windows of the estimator, empty frames, and back to contacts."""

from dataclasses import fields, replace

import numpy as np
import pytest

from tfra.model.choices import Architecture
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.fixed.words import decode
from tfra.model.sensor import SensorArray
from tfra.model.skin.finding import Finding, Mark
from tfra.model.skin.records import decode_records, header_bits, records
from tfra.model.skin.result import estimate
from tfra.model.skin.skin import Skin
from tfra.model.tfra import Status

WINDOW = TfraDesign(SensorArray(4, 5, 3e-3, 2e-3, 3e-3), architecture=Architecture(4, 4))
SKIN = Skin(replace(WINDOW.sensor, rows=11, columns=13), WINDOW, Finding(most=3))


def pressed(*taxels, code=-3000):
    frame = np.zeros((SKIN.sensor.rows, SKIN.sensor.columns), dtype=np.int64)
    for row, column in taxels:
        frame[row, column] = code
    return frame


CODES = np.array([
    pressed((2, 2), (8, 9)),
    pressed(),
    pressed((0, 12), (5, 5), (10, 0), (10, 12)),
    pressed(*((row, column) for row in range(3, 9) for column in range(2, 4))),
])  # fmt: skip


def header(words):
    return dict(zip(header_bits(SKIN), words[:, : len(header_bits(SKIN))].T.tolist(), strict=True))


def test_headers_tell_frame_contact_and_place():
    made = header(records(SKIN, CODES, WINDOW.model.words))
    assert made["frame"] == [0, 0, 1, 2, 2, 2, 3]
    assert made["contact"] == [0, 1, 0, 0, 1, 2, 0]
    assert made["last"] == [0, 1, 1, 0, 0, 1, 1]
    assert made["dropped"] == [0, 0, 0, 0, 0, 1, 0]
    assert [row // 16 for row in made["row"]] == [2, 8, 0, 0, 5, 9, 5]
    assert made["marks"][-1] & (Mark.LARGE >> 8)
    assert all(max(values) < 1 << bits for values, bits in zip(made.values(), header_bits(SKIN).values(), strict=True))


def test_an_empty_frame_has_a_record_without_contact():
    made = records(SKIN, CODES[1:2], WINDOW.model.words)
    result = decode(WINDOW, made[:, len(header_bits(SKIN)) :])
    assert result.status.tolist() == [Status.NO_CONTACT]
    assert header(made) == {name: [int(name == "last")] for name in header_bits(SKIN)}


def test_decoded_records_are_the_estimate():
    direct = estimate(SKIN, CODES, lambda cut: decode(WINDOW, WINDOW.model.words(cut)))
    decoded = decode_records(SKIN, records(SKIN, CODES, WINDOW.model.words))
    for field in fields(direct):
        if field.name != "windows":
            np.testing.assert_array_equal(getattr(direct, field.name), getattr(decoded, field.name), field.name)
    for name in ("forces", "resultant", "status"):
        np.testing.assert_array_equal(getattr(direct.windows, name), getattr(decoded.windows, name), name)
    assert direct.windows.forces.any()


def test_a_status_has_the_marks_beside_the_windows_bits():
    found, cut = SKIN.find(CODES)
    windows = decode(WINDOW, WINDOW.model.words(cut))
    result = estimate(SKIN, CODES, lambda cut: windows)
    assert found.marks.any()
    assert windows.status.any()
    np.testing.assert_array_equal(result.windows.status, windows.status + found.marks)


def test_frames_without_any_contact_give_empty_results():
    for engine, frames in (
        (lambda cut: decode(WINDOW, WINDOW.model.words(cut)), CODES[1:2]),
        (WINDOW.float_model, CODES[1:2] * 1.0),
    ):
        result = estimate(SKIN, frames, engine)
        assert (result.windows.resultant.shape, result.found.tolist()) == ((0, 3), [0])


def test_stress_and_codes_have_the_same_contacts():
    lsb = WINDOW.adc.lsb
    stress, codes = SKIN.find(CODES * lsb), SKIN.find(CODES)
    np.testing.assert_array_equal(stress[0].taxels, codes[0].taxels)
    np.testing.assert_array_equal(stress[1], codes[1] * lsb)


@pytest.mark.parametrize(
    ("changes", "reason"), [({"rows": 3}, "window.rows: at most the array's 3"), ({"columns": 4}, "window.columns: ")]
)
def test_a_window_larger_than_the_array_is_refused(changes, reason):
    with pytest.raises(ValueError, match="^" + reason):
        replace(SKIN, sensor=replace(SKIN.sensor, **changes))
