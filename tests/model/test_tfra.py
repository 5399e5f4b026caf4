"""Float TFRA against the paper taken literally, published numbers and its own symmetries."""

import numpy as np
import pytest

from tfra.model.boussinesq import operators
from tfra.model.cover.contact import Contact
from tfra.model.cover.layer import frames
from tfra.model.cover.scenes import SENSORS, random_contacts
from tfra.model.sensor import SensorArray
from tfra.model.tfra import Status, Tfra, check_frames


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
        pinv = np.vstack([ops.pinv1, ops.pinv2, ops.pinv3])
        np.testing.assert_allclose(ops.a @ pinv, np.eye(m), atol=1e-10)
        np.testing.assert_allclose(ops.c33 @ ops.c33_inv, np.eye(m), atol=1e-10)
        np.testing.assert_allclose(pinv, np.linalg.pinv(ops.a), atol=1e-10 * np.abs(pinv).max())


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

    @pytest.mark.parametrize(
        ("name", "value"), [("contact_threshold", -1e-9), ("contact_threshold", np.nan), ("plateau_tolerance", -1)]
    )
    def test_choices_outside_their_range_are_refused(self, name, value):
        with pytest.raises(ValueError, match=f"^{name}: .* is needed, got"):
            Tfra(self.sensor, **{name: value})

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


def test_nothing_is_divided_in_a_frame_at_rest() -> None:
    tfra = Tfra(SensorArray(3, 4, 4e-3, 2e-3, 3e-3))
    with np.errstate(all="raise"):
        result = tfra(np.zeros((2, 3, 4)))
    assert not result.forces.any()
