"""Float TFRA against the paper taken literally, published numbers and its own symmetries."""

import numpy as np
import pytest

from tfra.model.boussinesq import operators
from tfra.model.cover.contact import Contact
from tfra.model.cover.layer import frames
from tfra.model.cover.scenes import SENSORS, random_contacts
from tfra.model.sensor import SensorArray
from tfra.model.tfra import Status, Tfra, check_frames


def literal(sensor: SensorArray, b: np.ndarray, steps: int) -> dict[str, object]:
    """One frame, Eqs. 7-31 as printed: tan phi, one full reconstruction for each candidate, explicit loops."""
    ops = operators(sensor)
    pinv = np.linalg.pinv(ops.a)  # Eq. 6 by SVD, not by the normal equations
    x, y = sensor.positions()
    comp, trac = np.where(b < 0, b, 0), np.where(b >= 0, b, 0)
    cx, cy = (comp @ x) / comp.sum(), (comp @ y) / comp.sum()
    tx, ty = (trac @ x) / trac.sum(), (trac @ y) / trac.sum()
    phi = np.arctan((cy - ty) / (cx - tx)) + (np.pi if tx >= cx else 0.0)  # Eq. 11
    w_z = np.linalg.solve(ops.c33, b)
    w_z = np.where(w_z < 0, w_z, 0.0)
    m = sensor.taxels

    def reconstruct(mu_x: float, mu_y: float) -> np.ndarray:
        w = np.concatenate([mu_x * np.abs(w_z), mu_y * np.abs(w_z), w_z])
        return pinv @ b + w - pinv @ (ops.a @ w)  # Eq. 7

    sums = [reconstruct(*mu).reshape(3, m).sum(axis=1) for mu in ((0, 0), (1, 0), (0, 1))]
    a0, a1, a2 = sums[0], sums[1] - sums[0], sums[2] - sums[0]  # Eq. 12
    tan = np.tan(phi)
    along_x = abs(np.cos(phi)) >= abs(np.sin(phi))
    start = 0.0 if (np.cos(phi) if along_x else np.sin(phi)) >= 0 else -1.0
    best = None
    for k in range(steps + 1):
        mu = start + k / steps
        if along_x:
            mu_x, mu_y = mu, (a0[0] * tan - a0[1] + mu * (a1[0] * tan - a1[1])) / (a2[1] - a2[0] * tan)  # Eq. 18
        else:
            mu_x, mu_y = (a0[1] - a0[0] * tan + mu * (a2[1] - a2[0] * tan)) / (a1[0] * tan - a1[1]), mu  # Eq. 17
        f = reconstruct(mu_x, mu_y)
        normal = ops.c33 @ f[2 * m :]
        tangential = ops.c31 @ f[:m] + ops.c32 @ f[m : 2 * m]
        b_z = normal[normal > 0].sum()  # Eq. 23
        b_xy = abs(tangential[tangential > 0].sum() - b[b > 0].sum())  # Eq. 25
        if best is None or (b_z, b_xy) < best[0]:
            best = (b_z, b_xy), k, f, mu_x, mu_y
    _, index, f, mu_x, mu_y = best
    total = f.reshape(3, m).sum(axis=1)
    f_sens = np.abs(b).sum() * sensor.pitch_x * sensor.pitch_y  # Eq. 29
    f = f * f_sens / np.sqrt((total**2).sum())  # Eqs. 30, 31
    return {"index": index, "phi": np.degrees(phi) % 360, "forces": f, "mu_x": mu_x, "mu_y": mu_y}


@pytest.mark.parametrize("name", list(SENSORS)[:5])
def test_equals_the_paper_taken_literally(name):
    sensor = SENSORS[name]
    contacts = random_contacts(sensor, 40, np.random.default_rng(1))
    stress = frames(sensor, contacts)
    result = Tfra(sensor, 20)(stress)
    checked = 0
    for i in np.flatnonzero(result.status == 0)[:12]:
        expected = literal(sensor, stress[i].ravel(), 20)
        assert result.sweep_index[i] == expected["index"]
        assert result.phi_deg[i] == pytest.approx(expected["phi"], abs=1e-9)
        assert (result.mu_x[i], result.mu_y[i]) == pytest.approx((expected["mu_x"], expected["mu_y"]), abs=1e-9)
        np.testing.assert_allclose(result.forces[i].ravel(), expected["forces"], atol=1e-9)
        checked += 1
    assert checked >= 8


@pytest.mark.parametrize(
    ("phi_ref", "phi", "mu", "force"),
    [
        (0, 0.0, 0.417, (2.26, 0.00, -5.41)),
        (45, 40.4, 0.460, (1.88, 1.60, -5.37)),
        (90, 90.0, 0.538, (0.00, 2.81, -5.23)),
    ],
)
def test_reference_contact(phi_ref, phi, mu, force):
    """The Hertz ellipse of 8 x 4 mm on the 40 x 20 mm sensor, to the printed digits."""
    sensor = SENSORS["10×10, 4×2 mm, h 3 mm"]
    contact = Contact("hertz", 18e-3, 9e-3, 8e-3, 4e-3, -5.73, 0.5, np.radians(phi_ref))
    result = Tfra(sensor)(frames(sensor, [contact]))
    assert result.phi_deg[0] == pytest.approx(phi, abs=0.05)
    assert result.mu[0] == pytest.approx(mu, abs=5e-4)
    np.testing.assert_allclose(result.resultant[0], force, atol=5.1e-3)


def test_operators_satisfy_their_definitions():
    for sensor in SENSORS.values():
        ops, m = operators(sensor), sensor.taxels
        np.testing.assert_allclose(ops.a @ ops.pinv, np.eye(m), atol=1e-10)
        np.testing.assert_allclose(ops.c33 @ ops.c33_inv, np.eye(m), atol=1e-10)
        np.testing.assert_allclose(ops.pinv, np.linalg.pinv(ops.a), atol=1e-10 * np.abs(ops.pinv).max())


def test_boussinesq_entry_by_hand():
    """A force one pitch to the right of the taxel, h = 3 mm, s_x = 4 mm: r = 4 mm, C0 = 3 h^2 / (2 pi 5^5) mm^-3."""
    ops = operators(SENSORS["10×10, 4×2 mm, h 3 mm"])
    c0 = 3 * 9 / (2 * np.pi * 5**5) * 1e9
    assert ops.c31[0, 1] == pytest.approx(c0 * 4e-3)  # positive: traction behind a force to the right
    assert ops.c31[1, 0] == pytest.approx(-c0 * 4e-3)
    assert ops.c33[0, 1] == pytest.approx(c0 * 3e-3)
    assert ops.c32[0, 1] == 0.0


def test_every_result_reproduces_the_measured_stress():
    sensor = SENSORS["5×7, 3×3 mm, h 2 mm"]
    stress = frames(sensor, random_contacts(sensor, 50, np.random.default_rng(3)))
    result = Tfra(sensor)(stress)
    regular = result.status == 0
    assert regular.sum() > 10
    flat = result.forces.reshape(len(stress), -1)[regular]
    measured = stress.reshape(len(stress), -1)[regular]
    rebuilt = flat @ operators(sensor).a.T
    scale = (rebuilt * measured).sum(axis=1) / (rebuilt**2).sum(axis=1)  # undo Eq. 31
    np.testing.assert_allclose(rebuilt * scale[:, None], measured, atol=1e-9 * np.abs(measured).max())


def test_mirrors_and_scales():
    sensor = SENSORS["10×10, 4×2 mm, h 3 mm"]
    stress = frames(sensor, random_contacts(sensor, 60, np.random.default_rng(5)))
    plain = Tfra(sensor)(stress)
    ok = (plain.status == 0) & (np.abs(np.abs(np.sin(2 * np.radians(plain.phi_deg)))) > 1e-3)
    assert ok.sum() > 20
    cases = [(stress[:, :, ::-1], (-1, 1, 1), np.s_[:, :, :, ::-1]), (stress[:, ::-1], (1, -1, 1), np.s_[:, :, ::-1])]
    for mirrored, signs, back in cases:
        seen = Tfra(sensor)(mirrored)
        expected = plain.forces * np.array(signs)[None, :, None, None]
        np.testing.assert_allclose(seen.forces[back][ok], expected[ok], atol=1e-9)
    scaled = Tfra(sensor)(stress * 8.0)
    np.testing.assert_allclose(scaled.forces, plain.forces * 8.0, rtol=1e-12, atol=1e-12)


def test_turning_a_square_sensor_turns_the_forces():
    sensor = SENSORS["10×10, 4×4 mm, h 3 mm"]
    stress = frames(sensor, random_contacts(sensor, 60, np.random.default_rng(6)))
    plain, turned = Tfra(sensor)(stress), Tfra(sensor)(stress.transpose(0, 2, 1))
    ok = plain.status == 0
    swapped = turned.forces.transpose(0, 1, 3, 2)[:, [1, 0, 2]]
    steady = ok & (np.abs(plain.mu - turned.mu) < 1e-9)  # a sweep from -1 upwards breaks ties the other way round
    assert steady.sum() > 0.9 * ok.sum()
    np.testing.assert_allclose(swapped[steady], plain.forces[steady], atol=1e-9)


class TestDegenerate:
    sensor = SENSORS["4×6, 5×3 mm, h 2 mm"]

    def run(self, frame):
        return Tfra(self.sensor)(np.asarray(frame, dtype=float)[None])

    def test_no_contact(self):
        result = self.run(np.ones((4, 6)))
        assert result.status[0] == Status.NO_CONTACT
        assert not result.forces.any()
        assert result.mu[0] == result.phi_deg[0] == 0

    def test_below_the_contact_threshold(self):
        """Frames within [-3, 3) Pa are no contact; above, the threshold changes nothing."""
        stress = np.random.default_rng(1).uniform(-3, 3, (4, 4, 6))
        stress[1:, 1, 1] = -3, 3, np.nextafter(-3, -4)
        found, plain = Tfra(self.sensor, contact_threshold=3)(stress), Tfra(self.sensor)(stress)
        assert found.status[:2].tolist() == [Status.NO_CONTACT] * 2
        assert not (plain.status & Status.NO_CONTACT).any()
        for name in ("forces", "resultant", "phi_deg", "mu", "mu_x", "mu_y", "sweep_index", "status"):
            assert name == "status" or not getattr(found, name)[:2].any()
            np.testing.assert_array_equal(getattr(found, name)[2:], getattr(plain, name)[2:])

    @pytest.mark.parametrize("value", [-1e-9, np.nan])
    def test_a_negative_threshold_is_refused(self, value):
        with pytest.raises(ValueError, match="contact_threshold: zero or more is needed, got"):
            Tfra(self.sensor, contact_threshold=value)

    def test_compression_only_is_solved_by_normal_forces(self):
        frame = -np.arange(24.0).reshape(4, 6)
        result = self.run(frame)
        assert result.status[0] == Status.COMPRESSION_ONLY
        assert not result.forces[0, :2].any()
        expected = np.linalg.solve(operators(self.sensor).c33, frame.ravel())
        np.testing.assert_allclose(result.forces[0, 2].ravel(), expected)

    def test_coinciding_centroids(self):
        frame = np.full((4, 6), 0.1)
        frame[1:3, 2:4] = -1
        result = self.run(frame)
        assert result.status[0] & Status.NO_DIRECTION
        assert result.phi_deg[0] == 0

    def test_no_frames(self):
        assert Tfra(self.sensor)(np.empty((0, 4, 6))).forces.shape == (0, 3, 4, 6)


@pytest.mark.parametrize(
    ("value", "reason"),
    [
        (np.zeros((4, 6)), "shape (n, 4, 6) is needed, got (4, 6)"),
        (np.zeros((1, 6, 4)), "shape (n, 4, 6) is needed, got (1, 6, 4)"),
        (np.where(np.arange(48).reshape(2, 4, 6) == 31, np.nan, 1.0), "frame 1, row 1, column 1 is not finite"),
        (np.where(np.arange(24).reshape(1, 4, 6) == 5, -np.inf, 1.0), "frame 0, row 0, column 5 is not finite"),
    ],
)
def test_bad_frames(value, reason):
    with pytest.raises(ValueError, match="frames: ") as caught:
        check_frames(SENSORS["4×6, 5×3 mm, h 2 mm"], value)
    assert str(caught.value) == f"frames: {reason}"


@pytest.mark.parametrize("exponent", [-960, -700, -300, 40, 500])
def test_any_scale_gives_the_same_bits(exponent: int) -> None:
    """Stress times a power of two: forces times it, all else unchanged, nothing vanishes or overflows."""
    sensor = SensorArray(5, 6, 4e-3, 4e-3, 3e-3)
    b = frames(sensor, random_contacts(sensor, 5, np.random.default_rng(0)))
    with np.errstate(all="raise", under="ignore"):
        plain, scaled = Tfra(sensor)(b), Tfra(sensor)(np.ldexp(b, exponent))
    np.testing.assert_array_equal(np.ldexp(scaled.resultant, -exponent), plain.resultant)
    for key in ("phi_deg", "mu", "mu_x", "mu_y", "sweep_index", "status"):
        np.testing.assert_array_equal(getattr(scaled, key), getattr(plain, key))
