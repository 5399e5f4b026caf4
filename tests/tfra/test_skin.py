"""Skins from Python: the same contacts as the models and the command, and mistakes told in one line."""

import csv
from dataclasses import replace
from io import StringIO
from pathlib import Path

import numpy as np
import pytest

import tfra
from tests.cli.test_skin import SKIN
from tfra.model.converter import quantise
from tfra.model.skin.records import decode_records, records
from tfra.runtime.errors import InputError


@pytest.fixture
def skin(tmp_path: Path) -> tfra.Skin:
    (tmp_path / "skin.toml").write_text(SKIN)
    return tfra.load_skin(tmp_path / "skin.toml")


def test_what_it_is(skin: tfra.Skin) -> None:
    assert (skin.shape, skin.window) == ((16, 20), (6, 6))
    assert repr(skin) == (
        "<tfra.Skin skin: 16×20 taxels, 3 × 3 mm apart, under 3 mm; 14 bits for ±200000 Pa; standard formats; "
        "6 contacts; windows of 6×6>"
    )


def test_contacts_of_a_frame_act_together(skin: tfra.Skin) -> None:
    one, other = skin.contacts[:2]
    frames, truth = skin.simulate([[one, other], [one], [], [other]])
    assert truth.frame is not None
    assert truth.frame.tolist() == [0, 0, 1, 3]
    np.testing.assert_allclose(frames[0], frames[1] + frames[3], atol=1e-9)
    assert len(frames) == 4
    assert not frames[2].any()


def test_frames_of_config(skin: tfra.Skin) -> None:
    frames, truth = skin.simulate()
    assert frames.shape == (3, 16, 20)
    assert truth.frame is not None
    assert truth.frame.tolist() == [0, 0, 1, 1, 2, 2]


def test_contacts_are_those_of_the_model(skin: tfra.Skin) -> None:
    frames, _ = skin.simulate()
    found = skin.estimate(frames, engine="fixed")
    model = skin.skin.window.model
    wanted = decode_records(skin.skin, records(skin.skin, quantise(skin.skin, frames), lambda c: model(c).words))
    np.testing.assert_array_equal(found.windows.resultant, wanted.windows.resultant)
    np.testing.assert_array_equal(found.x, wanted.x)
    np.testing.assert_array_equal(found.stress, frames)
    assert len(found) == 6
    assert repr(found).startswith("<tfra.Contacts of the fixed engine\n  6 contacts in 3 frames, at most 2 in one\n")


def test_tracks_follow_contacts(skin: tfra.Skin) -> None:
    """One moves by a taxel in each frame, the other comes a frame later."""
    one, other = skin.contacts[:2]
    moved = [replace(one, center_x=one.center_x + 3e-3 * step) for step in range(4)]
    frames, _ = skin.simulate([[moved[0]], *([each, other] for each in moved[1:])])
    found = skin.estimate(frames)
    first = found.tracks() == 0
    assert found.frame[first].tolist() == [0, 1, 2, 3]
    assert (np.diff(found.x[first]) > 2e-3).all()
    assert set(found.tracks()) == {0, 1}
    assert len(set(found.tracks(1e-6))) == len(set(map(tuple, np.round([found.x, found.y], 6).T)))


def test_errors_are_of_contacts_that_belong_together(skin: tfra.Skin) -> None:
    """A contact that is not there is invented, one that is too weak is missed; the others keep their errors."""
    frames, truth = skin.simulate()
    found = skin.estimate(frames)
    errors = found.errors(truth)
    assert (errors.missed, errors.invented, errors["mu_abs"].shape) == (0, 0, (6,))
    force = errors["force_percent_of_resultant"]
    far = np.linalg.norm(found.windows.resultant - truth.resultant, axis=1)
    np.testing.assert_allclose(force, 100 * far / np.linalg.norm(truth.resultant, axis=1))
    assert "missed 0, invented 0" in repr(errors)
    some = tfra.Truth(truth.contacts[1:], np.array([0, 1, 1, 2, 2]))
    less = found.errors(some)
    assert (less.missed, less.invented, len(less["mu_abs"])) == (0, 1, 5)
    np.testing.assert_allclose(less["mu_abs"], np.delete(errors["mu_abs"], 0))
    away = replace(truth.contacts[0], center_x=30e-3)
    moved = found.errors(tfra.Truth((away, *truth.contacts[1:]), truth.frame))
    assert (moved.missed, moved.invented) == (1, 1)
    with pytest.raises(InputError, match=r"Contacts.errors: truth: is of 9 frames, there are 3"):
        found.errors(tfra.Truth(truth.contacts[:1], np.array([8])))


def test_files_have_the_table(skin: tfra.Skin, tmp_path: Path) -> None:
    frames, _ = skin.simulate()
    found = skin.estimate(frames)
    found.save(tmp_path / "r.csv")
    rows = list(csv.DictReader(StringIO((tmp_path / "r.csv" / "contacts.csv").read_text())))
    table = found.table
    assert list(rows[0]) == list(table)
    for name, values in table.items():
        np.testing.assert_array_equal([float(row[name]) for row in rows], values)
    assert found._repr_html_().count("<tr>") == 7
    assert found.to_dataframe()["mu"].to_list() == found.windows.mu.tolist()
    found.save(tmp_path / "r.npz")
    with np.load(tmp_path / "r.npz") as archive:
        np.testing.assert_array_equal(archive["track"], found.tracks())


def test_mistakes(skin: tfra.Skin, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"skin.toml: window: tfra.load takes no skins"):
        tfra.load(tmp_path / "skin.toml")
    (tmp_path / "array.toml").write_text(SKIN.partition("[window]")[0])
    with pytest.raises(InputError, match=r"array.toml: window: is missing: tfra.load_skin is for skins"):
        tfra.load_skin(tmp_path / "array.toml")
    with pytest.raises(InputError, match=r"Skin.estimate: frames: shape \(n, 16, 20\) with n >= 1 is needed"):
        skin.estimate(np.zeros((3, 6, 6)))
    with pytest.raises(InputError, match=r"Skin.estimate: engine: one of float, "):
        skin.estimate(np.zeros((3, 16, 20)), engine="exact")  # type: ignore[arg-type]
    with pytest.raises(InputError, match=r"Skin.simulate: frames: lists of tfra.Contact are needed"):
        skin.simulate([[1]])  # type: ignore[list-item]
    with pytest.warns(tfra.Notice, match=r"Skin.estimate.*no contact|have no contact"):
        skin.estimate(np.zeros((3, 16, 20)))
