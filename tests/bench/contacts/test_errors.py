"""The scenes of the error study are what they say, and its measure is zero for a perfect estimate alone."""

import json
from types import SimpleNamespace

import numpy as np
import pytest

from bench.contacts import errors, scenes
from bench.contacts.scenes import STUDIES, half_space, nodes
from bench.publish import ROOT, stored
from tfra.model.boussinesq import boussinesq
from tfra.model.cover.contact import Contact, Contacts, ContactShape
from tfra.model.cover.scenes import random_contacts
from tfra.model.sensor import SensorArray
from tfra.model.truth import medians, sentence

SENSOR = SensorArray(10, 10, 4e-3, 4e-3, 3e-3)
CONTACTS = random_contacts(SENSOR, 6, np.random.default_rng(1))


@pytest.fixture
def group():
    return scenes.Group(SENSOR, Contacts.of(CONTACTS))


def test_a_perfect_estimate_has_no_error_and_a_corrupted_one_has(group):
    forces = group.contacts.force
    mu, phi = np.array([c.mu for c in CONTACTS]), np.degrees([c.phi for c in CONTACTS])
    found = SimpleNamespace(resultant=forces.copy(), mu=mu, phi_deg=phi)  # of an estimator that knows the answer
    for values in errors.errors(forces, found).values():
        np.testing.assert_allclose(values, 0, atol=1e-9)
    found.resultant[0, 2] += 0.5
    found.mu[1] += 0.1
    found.phi_deg[2] += 36
    seen = errors.errors(forces, found)
    assert [int(values.argmax()) for values in seen.values()] == [0, 1, 2]
    np.testing.assert_allclose([seen["mu"][1], seen["phi"][2]], 10)
    np.testing.assert_allclose(seen["force"][0], 50 / np.linalg.norm(found.resultant[0]))


@pytest.mark.parametrize("shape", list(ContactShape))
def test_quadrature_has_the_transform_of_the_shape(shape):
    u, v, weight = nodes(shape, 24)
    for s_x, s_y in ((0, 0), (2, 1), (5, 7)):
        np.testing.assert_allclose(weight @ (np.cos(s_x * u) * np.cos(s_y * v)), shape.transform(s_x, s_y), atol=1e-12)


def test_half_space_of_a_point_is_the_kernel(group):
    contact = Contact("hertz", 12e-3, 20e-3, 1e-6, 1e-6, -5, 0.4, 0.7)
    c31, c32, c33 = (c[:, 5 * 10 + 3] for c in boussinesq(SENSOR))
    f_x, f_y, f_z = contact.force
    found = half_space(SENSOR, Contacts.of([contact])).ravel()
    np.testing.assert_allclose(found, c31 * f_x + c32 * f_y + c33 * f_z, rtol=1e-6)
    fine, finer = (half_space(SENSOR, group.contacts, order) for order in (48, 96))
    np.testing.assert_allclose(fine, finer, atol=1e-5 * np.abs(finer).max())


@pytest.mark.parametrize("name", list(STUDIES))
def test_every_study_measures(name, group):
    results = {label: errors.measure(scene) for label, scene in STUDIES[name][1](group)}
    assert len(results) > 3
    values = [row[key][part] for row in results.values() for key in errors.MEASURES for part in ("median", "p95")]
    assert np.isfinite(values).all()
    assert len(set(values)) > 3


def test_flagged_frames_have_no_say_in_the_friction_found(group):
    rows = {label: errors.measure(scene) for label, scene in scenes.frictions(group, True)}
    assert rows["0.05"]["mu_found"] is None  # nothing is under traction
    assert rows["0.05"]["flagged"] == len(group.contacts)
    assert "| 0.05 | – | 100% |" in errors.friction_table({"random": rows})


def test_neutral_settings_are_the_plain_scene(group):
    plain = scenes.scene(group).stress
    for name, label in (("kernel", "layer"), ("resolution", "10×10"), ("noise", "0 %"), ("search", "0.01")):
        found = dict(STUDIES[name][1](group))[label]
        np.testing.assert_allclose(found.stress, plain, atol=1e-9 * np.abs(plain).max(), err_msg=name)


def test_noise_and_codes_are_as_large_as_stated(group):
    plain = scenes.scene(group).stress
    peak = np.abs(plain).max()
    noisy = dict(scenes.noises(group))["1 %"].stress
    relative = (noisy - plain) / np.abs(plain).max(axis=(1, 2), keepdims=True)
    assert relative.std() == pytest.approx(0.01, rel=0.1)
    coarse = dict(scenes.converters(group))["8"].stress
    lsb = 1.05 * peak / 128
    assert lsb / 4 < np.abs(coarse - plain).max() <= lsb / 2


def test_a_pair_in_one_place_and_direction_is_one_contact(group):
    pair = dict(scenes.pairs(group, False))["0"]
    one = scenes.scene(group.changed(half=np.minimum(group.contacts.half, group.pitch), center=group.middle))
    np.testing.assert_allclose(pair.stress, one.stress, atol=1e-9 * np.abs(one.stress).max())
    np.testing.assert_allclose(pair.forces, one.forces)
    apart = dict(scenes.pairs(group, True))["4"]
    np.testing.assert_allclose(apart.forces[:, 2], one.forces[:, 2])
    assert (np.hypot(*apart.forces[:, :2].T) < np.hypot(*one.forces[:, :2].T)).all()


def block(name, page="README.md"):
    """What stands between the marks of a page."""
    _, _, rest = (ROOT / page).read_text().partition(f"<!-- {name} -->\n")
    text, mark, _ = rest.partition(f"\n<!-- end {name} -->")
    assert mark, f"<!-- {name} --> is missing in {page}"
    return text


def test_pages_and_package_say_what_the_study_found():
    friction = stored("errors")["results"]["friction"]["random"]
    assert medians() == {mu: friction[mu]["mu_found"][1] for mu in errors.TOLD}
    assert medians() == {"0.3": 0.046, "0.5": 0.438, "0.7": 0.902}
    assert " ".join(block("truth").split()) == f"- {sentence()}"
    assert block("right", "docs/measured.md") == errors.truth_table(friction)


def test_other_results_change_every_place(tmp_path, monkeypatch):
    for name in ("README.md", "docs/measured.md", "model/truth.json"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_bytes((ROOT / name).read_bytes())
    friction = stored("errors")["results"]["friction"]["random"]
    friction["0.3"]["mu_found"] = [0.1, 0.22, 0.31]
    monkeypatch.setattr(errors, "ROOT", tmp_path)
    monkeypatch.setattr("bench.publish.ROOT", tmp_path)
    errors.publish_truth(friction)
    assert json.loads((tmp_path / "model" / "truth.json").read_text())["mu_found"]["0.3"] == 0.22
    assert "| 0.22 (0.10–0.31) |" in (tmp_path / "docs" / "measured.md").read_text()
    with pytest.raises(AssertionError, match="nowhere"):
        block("nowhere")
