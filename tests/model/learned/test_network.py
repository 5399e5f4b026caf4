"""The folded network against the plain sums over the group of mirrors, and the estimator around it."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.model.learned.plain import plain
from tests.model.learned.random_weights import random_weights
from tfra.model.arrays import Floats
from tfra.model.learned.field import influence
from tfra.model.learned.network import NAMES, Learned, Network, Weights
from tfra.model.sensor import SensorArray
from tfra.model.tfra import Status, Tfra

GOOD = random_weights(np.random.default_rng(0), 6, 3, 2)
SENSOR = SensorArray(5, 4, 4e-3, 3e-3, 2e-3)

sizes = st.integers(2, 9)
seeds = st.integers(0, 2**32 - 1)


def array(rows: int, columns: int) -> SensorArray:
    return SensorArray(rows, columns, 4e-3, 2e-3, 3e-3)


def scale(sensor: SensorArray, weights: Weights, n: Floats) -> Floats:
    """The sum of the magnitudes of all terms of F: what rounding is relative to, ``(frames, 1)``."""
    signless = Weights(**{name: np.abs(getattr(weights, name)) for name in NAMES})
    return np.abs(plain(sensor, signless, np.abs(n), signed=False)).max(axis=1, keepdims=True)


@given(sizes, sizes, st.integers(1, 5), st.integers(1, 5), seeds)
@settings(deadline=None, max_examples=60)
def test_both_forms_agree(rows: int, columns: int, c1: int, c2: int, seed: int) -> None:
    sensor, rng = array(rows, columns), np.random.default_rng(seed)
    weights, n = random_weights(rng, sensor.taxels, c1, c2), rng.normal(size=(3, sensor.taxels))
    difference = np.abs(Network(sensor, weights)(n) - plain(sensor, weights, n))
    assert (difference <= 1e-12 * scale(sensor, weights, n)).all()


def test_the_number_of_products() -> None:
    rng = np.random.default_rng(0)
    assert Network(array(10, 10), random_weights(rng, 100, 48, 24)).products == 4800 + 4608 + 4 * (24 + 48 + 25)
    assert Network(array(5, 7), random_weights(rng, 35, 2, 1)).products == 4 * 12 * 2 + 4 * 2 + 4 * (1 + 2 + 12)


def test_weights_of_another_array() -> None:
    with pytest.raises(ValueError, match="first: 20 taxels are needed, got 6"):
        Network(array(4, 5), random_weights(np.random.default_rng(0), 6, 1, 1))


def test_counts() -> None:
    assert GOOD.counts == (3, 2)
    assert GOOD.taxels == 6
    assert all(getattr(GOOD, name).dtype == np.float64 for name in NAMES)


@pytest.mark.parametrize(
    ("name", "shape"),
    [
        ("first", (3,)),
        ("first", (0, 6)),
        ("second", (2, 3)),
        ("second", (3, 2, 3)),
        ("second", (4, 2, 4)),
        ("read2", (4, 3)),
        ("read1", (3, 3)),
        ("direct", (4, 5)),
    ],
)
def test_another_shape(name: str, shape: tuple[int, ...]) -> None:
    with pytest.raises(ValueError, match=f"^{name}: "):
        Weights(**{key: np.zeros(shape) if key == name else getattr(GOOD, key) for key in NAMES})


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_not_finite(name: str, value: float) -> None:
    arrays = {key: getattr(GOOD, key).copy() for key in NAMES}
    arrays[name].flat[-1] = value
    with pytest.raises(ValueError, match=f"^{name}: a number is not finite"):
        Weights(**arrays)


def sums(sensor: SensorArray, along_x: float = 0.0) -> Weights:
    """F_z is the sum of b over the array; F_x the first moment along x of b, in units of ``along_x``."""
    m = sensor.taxels
    direct = np.zeros((4, m))
    direct[2] = 0.25
    direct[0] = along_x * np.tile(np.linspace(-1, 1, sensor.columns), sensor.rows)
    return Weights(np.zeros((1, m)), np.zeros((4, 1, 1)), np.zeros((4, 1)), np.zeros((4, 1)), direct)


def even_loads(count: int) -> Floats:
    """Frames of loads without friction that are even on each cell: the forward model explains them."""
    p = np.random.default_rng(0).uniform(0.1, 1, (count, SENSOR.taxels))
    return (-p @ influence(SENSOR).z.T).reshape(count, SENSOR.rows, SENSOR.columns)


def test_direction_and_friction() -> None:
    frames = np.zeros((2, 5, 4))
    frames[0, :, 0], frames[1, :, 3] = -1e5, -2e5  # pressed at one side, at the other
    found = Learned(SENSOR, sums(SENSOR, along_x=0.1), 1e9)(frames)
    assert found.mu == pytest.approx([0.4, 0.4])
    assert found.phi_deg == pytest.approx([0, 180])
    assert found.mu_x == pytest.approx([0.4, -0.4])
    assert found.mu_y == pytest.approx([0, 0], abs=1e-12)
    assert found.resultant[:, 2] == pytest.approx([-5 * 1e5 * 12e-6, -5 * 2e5 * 12e-6])
    assert (found.status == 0).all()


@given(st.integers(0, 2**32 - 1), st.integers(-300, 300))
@settings(deadline=None, max_examples=25)
def test_the_resultant_is_the_networks_at_any_scale(seed: int, exponent: int) -> None:
    rng = np.random.default_rng(seed)
    weights, b = random_weights(rng, SENSOR.taxels, 3, 2), rng.normal(size=(4, 5, 4))
    estimator = Learned(SENSOR, weights, 0.3)
    found, scaled = estimator(b), estimator(np.ldexp(b, exponent))
    expected = plain(SENSOR, weights, b.reshape(4, -1) * SENSOR.taxel_area)
    assert np.allclose(found.resultant, expected[:, :3], rtol=0, atol=1e-9 * np.abs(expected).max())
    assert found.uncertainty is not None
    assert scaled.uncertainty is not None
    assert np.allclose(found.uncertainty, np.maximum(expected[:, 3], 0), rtol=0, atol=1e-9 * np.abs(expected).max())
    assert np.array_equal(scaled.uncertainty, np.ldexp(found.uncertainty, exponent))
    assert np.allclose(found.forces.sum(axis=(2, 3)), found.resultant)
    assert np.array_equal(scaled.resultant, np.ldexp(found.resultant, exponent))
    for key in ("phi_deg", "mu", "status", "residual"):
        assert np.array_equal(getattr(scaled, key), getattr(found, key)), key


def test_no_contact_as_tfra_has_it() -> None:
    rng = np.random.default_rng(3)
    b = np.concatenate([rng.normal(size=(30, 5, 4)) * 10 ** rng.uniform(-2, 1, (30, 1, 1)), np.zeros((1, 5, 4))])
    weights = random_weights(rng, SENSOR.taxels, 3, 2)
    for threshold in (0.0, 1.0):
        found = Learned(SENSOR, weights, 1e9, threshold)(b)
        none = found.status & Status.NO_CONTACT != 0
        expected = Tfra(SENSOR, contact_threshold=threshold)(b).status & Status.NO_CONTACT != 0
        assert np.array_equal(none, expected)
        assert 0 < none.sum() < len(b)
        assert (found.status[none] == Status.NO_CONTACT).all()
        for key in ("forces", "resultant", "phi_deg", "mu", "mu_x", "mu_y", "uncertainty", "residual"):
            assert (getattr(found, key)[none] == 0).all(), key


def test_implausible() -> None:
    explained, weights = even_loads(3), sums(SENSOR)
    weights.direct[3] = -0.1 * weights.direct[2]  # the uncertainty is a tenth of the normal force
    for threshold, implausible in ((0.099, True), (0.101, False)):
        found = Learned(SENSOR, weights, threshold)(explained)
        assert ((found.status & Status.IMPLAUSIBLE != 0) == implausible).all()
        assert found.uncertainty == pytest.approx(-0.1 * found.resultant[:, 2])
        assert (found.status & Status.NO_DIRECTION != 0).all()
        assert not found.phi_deg.any()
    noise = np.random.default_rng(1).normal(size=(3, 5, 4)) * np.abs(explained).max()
    found = Learned(SENSOR, sums(SENSOR), 0.3)(noise)
    assert found.residual is not None
    assert (found.residual > 0.3).all()
    lifted = Weights(*(np.negative(value) for value in vars(sums(SENSOR)).values()))
    assert (Learned(SENSOR, lifted, 1e9)(explained).status & Status.IMPLAUSIBLE != 0).all()  # forces that pull


def test_compression_alone_is_estimated_as_well() -> None:
    pressed = -np.abs(np.random.default_rng(2).normal(size=(3, 5, 4)))
    assert (Learned(SENSOR, sums(SENSOR, 0.1), 1e9)(pressed).status & Status.COMPRESSION_ONLY == 0).all()


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [((0.0,), "^threshold: more than zero"), ((np.nan,), "^threshold: "), ((0.3, -1.0), "^contact_threshold: zero")],
)
def test_bad_choices(arguments: tuple[float, ...], reason: str) -> None:
    with pytest.raises(ValueError, match=reason):
        Learned(SENSOR, sums(SENSOR), *arguments)


def test_bad_frames() -> None:
    estimator = Learned(SENSOR, sums(SENSOR), 0.3)
    with pytest.raises(ValueError, match=r"frames: shape \(n, 5, 4\) is needed"):
        estimator(np.zeros((1, 4, 5)))
    with pytest.raises(ValueError, match="frame 0, row 1, column 2 is not finite"):
        estimator(np.where(np.arange(20).reshape(1, 5, 4) == 6, np.nan, 1.0))
    assert len(estimator(np.zeros((0, 5, 4))).mu) == 0
