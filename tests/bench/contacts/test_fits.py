"""The calibration finds contacts that the model itself made, and notices what doesn't fit."""

import csv
from dataclasses import replace

import numpy as np
import pytest

from bench import publish
from bench.contacts import fits
from bench.contacts.fits import CASES, estimates, misfit, placed, residuals, score, zoom
from tfra.model.cover.contact import ContactShape
from tfra.model.cover.layer import frames
from tfra.model.tfra import Tfra

PHI = np.arange(0, 91, 15.0)
HERTZ, POINT = ContactShape.HERTZ, "point"


def made(tmp_path, place):
    """The Hertz case with a table of the model's own estimates at ``place``."""
    case = CASES["hertz"]
    found = estimates(case.sensor, placed(case, HERTZ, np.array([place])), PHI, POINT)[0]
    path = tmp_path / "made.csv"
    with path.open("w") as file:
        writer = csv.writer(file)
        writer.writerow(["method", "phi_ref", "phi_alg", "mu_alg", "Fx_alg", "Fy_alg", "Fz_alg"])
        writer.writerows(["tfra", angle, *row[:2], 0, 0, row[2]] for angle, row in zip(PHI, found, strict=True))
    return replace(case, table=str(path))


def test_published_tables():
    phi_ref, values = CASES["hertz"].published
    assert phi_ref.tolist() == [0, 15, 30, 45, 60, 75, 90, 65]
    np.testing.assert_allclose(values[0], [-1.81, 0.47, np.sqrt(2.51**2 + 0.08**2 + 5.35**2)])
    assert len(CASES["rectangle"].fitted[0]) == 7  # without 65 degrees
    assert CASES["rectangle"].contact.normal_force == -6.78


@pytest.mark.parametrize("sampling", fits.SAMPLINGS)
def test_superposed_loads_are_the_contact(sampling):
    case, phi_ref = CASES["rectangle"], np.array([20.0, 200.0])
    contact = placed(case, ContactShape.ROUNDED, np.array([[5, 3, 1, -2.0]]))[0]
    turned = [replace(contact, phi=np.radians(angle)) for angle in phi_ref]
    found = Tfra(case.sensor)(frames(case.sensor, turned, sampling))
    direct = np.stack([found.phi_deg, found.mu, np.linalg.norm(found.resultant, axis=1)], axis=1)
    np.testing.assert_allclose(estimates(case.sensor, [contact], phi_ref, sampling)[0], direct, rtol=1e-9)


def test_residuals_have_units_and_wrap():
    published = np.array([[1.0, 0.5, 4.0]])
    np.testing.assert_allclose(residuals(np.array([[359.0, 0.52, 3.96]]), published), [[-2, 2, -1]])
    assert misfit(published.copy(), published) == 0


def test_misfit_of_own_data_is_zero_at_the_true_size_alone(tmp_path):
    case = made(tmp_path, [6, 3, 0, 0])
    scores = score(case, HERTZ, POINT, np.array([[6, 3, 0, 0], [6.5, 3, 0, 0], [6, 3.25, 0, 0], [6, 3, 0.3, 0]]))
    assert scores[0] < 1e-9
    assert (scores[1:] > 0.1).all()


def test_misfit_notices_one_corrupted_value(tmp_path):
    case = made(tmp_path, [6, 3, 0, 0])
    case.published[1][2, 1] += 0.01  # one step of mu in 7 directions of 3 quantities
    np.testing.assert_allclose(score(case, HERTZ, POINT, np.array([[6, 3, 0, 0.0]])), np.sqrt(1 / 21))


def test_zoom_recovers_a_shifted_centre(tmp_path):
    true = np.array([6, 3, -0.4, 0.5])
    case = made(tmp_path, true)
    start, spread = np.array([6, 3, 0, 0.0]), np.array([0, 0, 0.3, 0.3])
    place, least = zoom(case, HERTZ, POINT, start, spread)
    assert least < 0.2 < score(case, HERTZ, POINT, start[None])[0]
    np.testing.assert_allclose(place, true, atol=0.02)
    assert place[:2].tolist() == [6, 3]


def test_draws_stay_on_the_block():
    case = CASES["hertz"]
    places = fits.draw(case, 500)
    assert len(places) > 300
    assert (places[:, 1] + np.abs(places[:, 3]) < 10).all()
    assert (np.abs(places[:, 2:]) <= [2, 1]).all()
    frames(case.sensor, placed(case, HERTZ, places[:20]))  # raises off the block


def test_the_nine_centres_include_the_middle():
    case, place = CASES["hertz"], np.array([6, 3, 0, 0.0])
    nine = fits.displaced(case, {"shape": HERTZ, "sampling": POINT, "place": place})
    middle = estimates(case.sensor, placed(case, HERTZ, place[None]), np.array([45.0]), POINT)[0, 0, :2]
    assert nine.shape == (9, 2)
    np.testing.assert_allclose(nine[4], middle)
    assert np.ptp(nine[:, 0]) > 0.1


def test_tables_go_between_their_marks(tmp_path, monkeypatch):
    monkeypatch.setattr(publish, "ROOT", tmp_path)
    page = tmp_path / "page.md"
    page.write_text("a\n<!-- x -->\nold\n<!-- end x -->\nb\n")
    publish.insert("x", "| new |", "page.md")
    assert page.read_text() == "a\n<!-- x -->\n| new |\n<!-- end x -->\nb\n"
    with pytest.raises(ValueError, match=r"page\.md: one pair of marks"):
        publish.insert("y", "| new |", "page.md")
