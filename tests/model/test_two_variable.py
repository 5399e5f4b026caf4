"""The two-variable search: what its functionals mean, that it finds their optimum, and how exact it is."""

import numpy as np
import pytest

from tests.marks import long
from tfra.model.boussinesq import operators
from tfra.model.cover.contact import Contact
from tfra.model.cover.layer import frames
from tfra.model.cover.scenes import SENSORS, random_contacts
from tfra.model.metrics import error_force
from tfra.model.sensor import SensorArray
from tfra.model.tfra import Status, Tfra, check_frames
from tfra.model.two_variable import Conditions, TwoVariable

SMALL = SENSORS["4×6, 5×3 mm, h 2 mm"]
EMPTY = np.zeros((4, 6))


def scenes(sensor: SensorArray, count: int, seed: int) -> np.ndarray:
    """Frames of random contacts with compression and traction."""
    stress = frames(sensor, random_contacts(sensor, count, np.random.default_rng(seed)))
    return stress[(stress > 0).any(axis=(1, 2))]


def conditions(sensor: SensorArray, frame: np.ndarray) -> Conditions:
    return Conditions.of(sensor, *TwoVariable(sensor).coefficients(frame.ravel()))


def dense(sensor: SensorArray, frame: np.ndarray, mu_x: float, mu_y: float) -> tuple[np.ndarray, np.ndarray]:
    """Forces (3, m) of Eq. 7 by the pseudo-inverse's SVD, and |w_z|."""
    ops, b = operators(sensor), frame.ravel()
    pinv = np.linalg.pinv(ops.a)
    n = np.abs(np.minimum(np.linalg.solve(ops.c33, b), 0))
    w = np.concatenate([mu_x * n, mu_y * n, -n])
    return (pinv @ b + w - pinv @ (ops.a @ w)).reshape(3, -1), n


def printed(sensor: SensorArray, forces: np.ndarray, n: np.ndarray, mu_x: float, mu_y: float) -> list[float]:
    """The three functionals as docs/studies/two_variable.md prints them, taxel by taxel."""
    total = sum(n)
    place = [(j * sensor.pitch_x, i * sensor.pitch_y) for i in range(sensor.rows) for j in range(sensor.columns)]
    x_c = sum(k * x for k, (x, _) in zip(n, place, strict=True)) / total
    y_c = sum(k * y for k, (_, y) in zip(n, place, strict=True)) / total
    traction = misfit = spread = moment_x = moment_y = 0.0
    for k, (x, y), (f_x, f_y, f_z) in zip(n, place, forces.T, strict=True):
        traction += max(0.0, f_z) ** 2
        misfit += (f_x - mu_x * k) ** 2 + (f_y - mu_y * k) ** 2
        spread += k * ((x - x_c) ** 2 + (y - y_c) ** 2)
        moment_x += f_x * (x - x_c)
        moment_y += f_y * (y - y_c)
    lever2 = spread / total + (sensor.pitch_x**2 + sensor.pitch_y**2) / 12
    squares = sum(k**2 for k in n)
    defects = traction / squares, misfit / squares, (moment_x**2 + moment_y**2) / (total**2 * lever2)
    return [1 / (1 + d) for d in defects]


@pytest.mark.parametrize("name", list(SENSORS)[:5])
def test_functionals_as_printed(name: str) -> None:
    sensor, rng = SENSORS[name], np.random.default_rng(4)
    for frame in scenes(sensor, 8, 3):
        mu = rng.uniform(-1, 1, 2)
        found = conditions(sensor, frame).functionals(*mu)
        forces, n = dense(sensor, frame, *mu)
        np.testing.assert_allclose(found, printed(sensor, forces, n, *mu), rtol=1e-9)
        assert ((found > 0) & (found <= 1)).all()
        forces[rng.integers(2), n.argmax()] += 0.05 * n.max()  # the comparison notices one wrong force
        assert not np.allclose(found, printed(sensor, forces, n, *mu), rtol=1e-9)


def test_loss_and_its_gradient() -> None:
    sensor = SENSORS["8×8, 2×2 mm, h 3 mm"]
    rng, step = np.random.default_rng(8), 1e-6
    for frame in scenes(sensor, 10, 2):
        found, mu = conditions(sensor, frame), rng.uniform(-1, 1, 2)
        value, gradient = found.loss(mu)
        assert value == pytest.approx(-np.log(found.functionals(*mu)).sum())
        for axis, shift in enumerate(np.eye(2) * step):
            slope = (found.loss(mu + shift)[0] - found.loss(mu - shift)[0]) / (2 * step)
            assert gradient[axis] == pytest.approx(slope, abs=1e-6)


@pytest.mark.parametrize("name", [list(SENSORS)[3], *long(*list(SENSORS)[:3], list(SENSORS)[4])])
def test_optimum_against_a_fine_grid(name: str) -> None:
    """No point of 401 x 401 is better; 0.05 away from the optimum, one is."""
    sensor = SENSORS[name]
    stress = scenes(sensor, 7, 5)
    result = TwoVariable(sensor)(stress)
    axis = np.linspace(-1, 1, 401)
    for i, frame in enumerate(stress):
        found = conditions(sensor, frame)
        grid = found.functionals(axis[:, None], axis[None, :]).prod(axis=0)
        best = found.functionals(result.mu_x[i], result.mu_y[i]).prod()
        assert best >= grid.max() * (1 - 1e-12)
        for away_x, away_y in ((0.05, 0), (0, 0.05)):  # towards zero, inside the range
            mu_x = result.mu_x[i] - np.copysign(away_x, result.mu_x[i])
            mu_y = result.mu_y[i] - np.copysign(away_y, result.mu_y[i])
            assert found.functionals(mu_x, mu_y).prod() < grid.max()
    assert (np.abs([result.mu_x, result.mu_y]) <= 1).all()


def test_the_higher_of_two_peaks() -> None:
    """Peaks at mu_x = -0.6, on a point of the first grid, and at 0.65, between two: the second is the higher one."""
    normal, similar = np.zeros((3, SMALL.taxels)), np.zeros((3, 2 * SMALL.taxels))
    normal[:, 0] = 0.065, -0.1, 0
    similar[:, 0], similar[:, 1] = (-6.5, 10, 0), (0, 0, 1)
    pinch = np.array([[6.0, 0], [10, 0], [0, 0]])
    both = Conditions(normal, similar, pinch)
    assert both.functionals(-0.6, 0).prod() > max(both.functionals(0.6, 0).prod(), both.functionals(0.7, 0).prod())
    found = both.best()
    fine = np.linspace(-1, 1, 20001)
    assert found[0] == pytest.approx(fine[both.functionals(fine, 0.0).prod(axis=0).argmax()], abs=1e-4)
    assert 0.6 < found[0] < 0.65
    assert found[1] == pytest.approx(0, abs=1e-6)


@pytest.mark.parametrize("name", ["10×10, 4×2 mm, h 3 mm", "5×7, 3×3 mm, h 2 mm"])
def test_results_follow_from_the_optimum(name: str) -> None:
    sensor = SENSORS[name]
    stress = scenes(sensor, 12, 7)
    result = TwoVariable(sensor)(stress)
    assert not result.status.any()
    assert (result.sweep_index == -1).all()
    for i, frame in enumerate(stress):
        forces, _ = dense(sensor, frame, result.mu_x[i], result.mu_y[i])
        f_sens = np.abs(frame).sum() * sensor.pitch_x * sensor.pitch_y
        forces *= f_sens / np.linalg.norm(forces.sum(axis=1))
        np.testing.assert_allclose(result.forces[i].reshape(3, -1), forces, atol=1e-9)
        f_x, f_y, f_z = forces.sum(axis=1)
        np.testing.assert_allclose(result.resultant[i], (f_x, f_y, f_z), atol=1e-9)
        assert result.mu[i] == pytest.approx(np.hypot(f_x, f_y) / abs(f_z))
        assert result.phi_deg[i] == pytest.approx(np.degrees(np.arctan2(f_y, f_x)) % 360)


class TestDegenerate:
    def test_as_the_sweep_has_it(self) -> None:
        stress = np.stack([np.ones((4, 6)), -np.arange(24.0).reshape(4, 6), EMPTY])
        found, expected = TwoVariable(SMALL)(stress), Tfra(SMALL)(stress)
        assert found.status.tolist() == [Status.NO_CONTACT, Status.COMPRESSION_ONLY, Status.NO_CONTACT]
        for name in ("forces", "resultant", "phi_deg", "mu", "mu_x", "mu_y", "status"):
            np.testing.assert_allclose(getattr(found, name), getattr(expected, name), atol=1e-12)

    def test_no_pressed_taxel(self) -> None:
        a = np.random.default_rng(1).normal(size=(3, 3, SMALL.taxels))
        np.testing.assert_array_equal(Conditions.of(SMALL, a, EMPTY.ravel()).functionals(0.5, 0), 1.0)

    def test_no_direction(self) -> None:
        frame = np.full((4, 6), 0.1)
        frame[1:3, 2:4] = -1
        result = TwoVariable(SMALL)(frame[None])
        assert result.status[0] == Status.NO_DIRECTION
        assert result.phi_deg[0] == 0
        assert result.mu[0] < 1e-6

    def test_no_frames_and_bad_frames(self) -> None:
        assert TwoVariable(SMALL)(np.empty((0, 4, 6))).forces.shape == (0, 3, 4, 6)
        with pytest.raises(ValueError, match="frames: frame 0, row 0, column 0 is not finite"):
            TwoVariable(SMALL)(np.full((1, 4, 6), np.nan))
        with pytest.raises(ValueError, match="frames: shape"):
            check_frames(SMALL, EMPTY)

TABLE = {
    ("10×10, 4×2 mm, h 3 mm", TwoVariable): (13.8, 24.0, 0.161, 0.278, 8.2, 26.6),
    ("10×10, 4×2 mm, h 3 mm", Tfra): (3.7, 5.6, 0.041, 0.083, 5.0, 10.3),
    ("10×10, 4×4 mm, h 3 mm", TwoVariable): (21.6, 36.0, 0.179, 0.382, 8.9, 33.8),
    ("10×10, 4×4 mm, h 3 mm", Tfra): (1.0, 2.7, 0.028, 0.044, 1.4, 3.4),
}
"""Of docs/studies/two_variable.md: mean and worst error of phi in degrees, of mu, and of the forces in percent."""


def paper_contacts(name: str, phi_deg: np.ndarray) -> list[Contact]:
    if name == "10×10, 4×2 mm, h 3 mm":
        return [Contact("hertz", 18e-3, 9e-3, 8e-3, 4e-3, -5.73, 0.5, phi) for phi in np.radians(phi_deg)]
    return [Contact("uniform", 18e-3, 18e-3, 3e-3, 2e-3, -6.78, 0.5, phi) for phi in np.radians(phi_deg)]


@pytest.mark.parametrize(("name", "method"), TABLE)
def test_errors_on_the_contacts_of_the_paper(name: str, method: type[TwoVariable] | type[Tfra]) -> None:
    phi_ref = np.arange(0, 360, 15.0)
    contacts = paper_contacts(name, phi_ref)
    result = method(SENSORS[name])(frames(SENSORS[name], contacts))
    phi = np.abs((result.phi_deg - phi_ref + 180) % 360 - 180)
    mu = np.abs(result.mu - 0.5)
    force = error_force([c.force for c in contacts], result.resultant)
    found = [statistic(error) for error in (phi, mu, force) for statistic in (np.mean, np.max)]
    np.testing.assert_allclose(found, TABLE[name, method], atol=0.051)
    np.testing.assert_allclose(found[2:4], TABLE[name, method][2:4], atol=0.00051)


@pytest.mark.parametrize("exponent", [-900, 500])
def test_any_scale_gives_the_same_bits(exponent: int) -> None:
    sensor = SensorArray(4, 5, 4e-3, 4e-3, 3e-3)
    b = np.random.default_rng(0).normal(size=(2, 4, 5))
    with np.errstate(all="raise", under="ignore"):
        plain, scaled = TwoVariable(sensor)(b), TwoVariable(sensor)(np.ldexp(b, exponent))
    np.testing.assert_array_equal(np.ldexp(scaled.resultant, -exponent), plain.resultant)
    for key in ("phi_deg", "mu", "mu_x", "mu_y", "status"):
        np.testing.assert_array_equal(getattr(scaled, key), getattr(plain, key))
