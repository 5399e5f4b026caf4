"""The layer's stress against Navier's equations solved by collocation, equilibrium and symmetry."""

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tfra.model.cover import layer as module
from tfra.model.cover.contact import Contact, ContactShape
from tfra.model.cover.layer import ElasticLayer, frames
from tfra.model.sensor import SensorArray

Floats = npt.NDArray[np.float64]

SENSOR = SensorArray(rows=10, columns=10, pitch_x=4e-3, pitch_y=2e-3, thickness=3e-3)
SQUARE = SensorArray(rows=8, columns=8, pitch_x=4e-3, pitch_y=4e-3, thickness=3e-3)
HERTZ = Contact(ContactShape.HERTZ, 18e-3, 9e-3, 8e-3, 4e-3, -5.73, 0.5, 0.0)

SHAPES = list(ContactShape)

contacts_on_square = st.builds(
    Contact,
    shape=st.sampled_from(SHAPES),
    center_x=st.floats(5e-3, 23e-3),
    center_y=st.floats(5e-3, 23e-3),
    half_x=st.floats(1e-3, 7e-3),
    half_y=st.floats(1e-3, 7e-3),
    normal_force=st.floats(-10, -0.1),
    mu=st.floats(0, 1),
    phi=st.floats(-math.pi, math.pi),
)


def chebyshev(order: int) -> tuple[Floats, Floats]:
    """Chebyshev points on [-1, 1], first at +1, and their differentiation matrix."""
    x = np.cos(np.pi * np.arange(order + 1) / order)
    c = np.where((np.arange(order + 1) % order) == 0, 2.0, 1.0) * (-1.0) ** np.arange(order + 1)
    difference = x[:, None] - x + np.eye(order + 1)
    matrix = np.outer(c, 1 / c) / difference
    return x, matrix - np.diag(matrix.sum(axis=1))


def collocated(kx: float, ky: float, height: float, poisson: float, load: tuple[float, float, float]) -> float:
    """sigma_zz at the base by collocating Navier's equations of all three displacements through the depth.

    u = (U sin cos, V cos sin, W cos cos) with shear modulus 1, U = V = W = 0 at z = 0 and the tractions
    ``load`` = (q_x, q_y, q_z) at z = height.  Needs poisson < 0.5.
    """
    lame = 2 * poisson / (1 - 2 * poisson)
    _, d = chebyshev(40)
    d = d * (2 / height)
    size = d.shape[0]
    one, zero = np.eye(size), np.zeros((size, size))
    divergence = np.hstack([kx * one, ky * one, d])
    laplacian = d @ d - (kx * kx + ky * ky) * one
    parts = [np.hstack([laplacian if i == j else zero for j in range(3)]) for i in range(3)]
    gradients = [-kx * one, -ky * one, d]
    system = np.vstack([p + (lame + 1) * g @ divergence for p, g in zip(parts, gradients, strict=True)])
    stresses = [
        np.hstack([d, zero, -kx * one]),
        np.hstack([zero, d, -ky * one]),
        lame * divergence + np.hstack([zero, zero, 2 * d]),
    ]
    right = np.zeros(3 * size)
    for i in range(3):
        top, base = i * size, (i + 1) * size - 1
        system[top], right[top] = stresses[i][0], load[i]
        system[base], right[base] = np.eye(3 * size)[base], 0.0
    scale = np.abs(system).max(axis=1)
    solution = np.linalg.solve(system / scale[:, None], right / scale)
    return float((stresses[2] @ solution)[size - 1])


@pytest.mark.parametrize("poisson", [0.0, 0.3, 0.48, -0.4])
@pytest.mark.parametrize("wave", [(0.05, 0.0), (0.3, 0.4), (0.0, 1.2), (2.0, 1.0), (-1.0, 3.0), (6.0, 5.0)])
def test_transfer_solves_the_equations_of_elasticity(poisson: float, wave: tuple[float, float]) -> None:
    height = 3e-3
    kx, ky = wave[0] / height, wave[1] / height
    load = (0.7, -0.4, -1.3)
    layer = ElasticLayer(40e-3, 20e-3, height, poisson, 0.0, 0.0)
    normal, tangential = layer.transfer(math.hypot(kx, ky))
    ours = normal * load[2] + tangential * (kx * load[0] + ky * load[1]) / math.hypot(kx, ky)
    assert ours == pytest.approx(collocated(kx, ky, height, poisson, load), rel=1e-8, abs=1e-11)


@pytest.mark.parametrize("poisson", [0.0, 0.3, 0.5])
def test_transfer_limits(poisson: float) -> None:
    layer = ElasticLayer(40e-3, 20e-3, 3e-3, poisson, 0.0, 0.0)
    with np.errstate(all="raise", under="ignore"):
        normal, tangential = layer.transfer(
            np.array([0.0, 1e-4, 2e3, 1e4, 1e7]) / 3e-3 * np.array([1, 1, 0.01, 0.01, 1])
        )
    np.testing.assert_allclose(normal[:2], 1, atol=1e-7)
    np.testing.assert_allclose(tangential[:2], [0, 1e-4], rtol=1e-6)
    assert (np.diff(normal) <= 0).all()
    assert normal[-1] == tangential[-1] == 0
    assert 0 < normal[3] < 1e-40
    assert np.isfinite(normal).all()
    assert np.isfinite(tangential).all()


def test_incompressible_is_the_limit_of_nearly_incompressible() -> None:
    k = np.linspace(0, 5000, 50)
    exact = ElasticLayer(40e-3, 20e-3, 3e-3, 0.5, 0.0, 0.0).transfer(k)
    near = ElasticLayer(40e-3, 20e-3, 3e-3, 0.5 - 1e-9, 0.0, 0.0).transfer(k)
    np.testing.assert_allclose(near, exact, atol=1e-8)


def spectrum(load: Contact, low: tuple[float, float], kx: float, ky: float) -> tuple[float, float, float]:
    """Integrals of q_x sin cos, q_y cos sin, q_z cos cos over the block by quadrature of the tractions."""
    nodes, weights = np.polynomial.legendre.leggauss(40)
    t, w = nodes * math.pi / 2, weights * math.pi / 2
    u, du = np.sin(t)[:, None], (w * np.cos(t))[:, None]
    chord = np.sqrt(1 - u * u) if load.shape is ContactShape.HERTZ else np.ones_like(u)
    x, y = load.center_x + load.half_x * u, load.center_y + load.half_y * chord * np.sin(t)
    area = du * chord * w * np.cos(t) * load.half_x * load.half_y
    q = load.tractions(x, y) * area
    px, py = kx * (x - low[0]), ky * (y - low[1])
    waves = (np.sin(px) * np.cos(py), np.cos(px) * np.sin(py), np.cos(px) * np.cos(py))
    return tuple(float((q[i] * waves[i]).sum()) for i in range(3))


def summed(layer: ElasticLayer, load: Contact, x: float, y: float, cutoff: float) -> float:
    """b_z at one point, one mode at a time."""
    low, total = (layer.origin_x, layer.origin_y), 0.0
    for p in range(int(cutoff * layer.size_x / (math.pi * layer.thickness)) + 1):
        for q in range(int(cutoff * layer.size_y / (math.pi * layer.thickness)) + 1):
            kx, ky = p * math.pi / layer.size_x, q * math.pi / layer.size_y
            weight = (2 if p else 1) * (2 if q else 1) / (layer.size_x * layer.size_y)
            amplitude = collocated(kx, ky, layer.thickness, layer.poisson, spectrum(load, low, kx, ky))
            total += weight * amplitude * math.cos(kx * (x - low[0])) * math.cos(ky * (y - low[1]))
    return total


@pytest.mark.parametrize("shape", SHAPES)
def test_base_stress_against_collocation_and_quadrature(shape: ContactShape) -> None:
    layer = ElasticLayer(6e-3, 4e-3, 5e-3, 0.4, -1e-3, -0.5e-3)
    load = Contact(shape, 1.5e-3, 1.2e-3, 1.7e-3, 1.1e-3, -2.0, 0.6, math.radians(35))
    ours = layer.base_stress([load], [0.4e-3, 3.7e-3], [2.9e-3])[0, 0]
    slow = [summed(layer, load, x, 2.9e-3, 16.0) for x in (0.4e-3, 3.7e-3)]
    np.testing.assert_allclose(ours, slow, rtol=2e-6)


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("poisson", [0.0, 0.48, 0.5])
def test_base_carries_the_whole_normal_force(shape: ContactShape, poisson: float) -> None:
    """Averages over cells that tile the block, for a contact right in a corner."""
    load = Contact(shape, 3e-3, 1e-3, 5e-3, 2e-3, -3.3, 0.8, 2.5)
    layer = ElasticLayer.under(SENSOR, poisson)
    x, y = (np.arange(16) + 0.5) * 2.5e-3 - 2e-3, (np.arange(25) + 0.5) * 0.8e-3 - 1e-3
    mean = layer.base_stress([load], x, y, window=(2.5e-3, 0.8e-3))[0]
    assert mean.sum() * 2.5e-3 * 0.8e-3 == pytest.approx(-3.3, rel=1e-12)


@pytest.mark.parametrize("shape", SHAPES)
def test_base_carries_the_moment_of_the_load(shape: ContactShape) -> None:
    """Far from the sides: integral of x b_z = x_c F_z - h F_x, and the same along y."""
    height = 1e-3
    layer = ElasticLayer(30e-3, 26e-3, height, 0.3, 0.0, 0.0)
    load = Contact(shape, 14.2e-3, 12.6e-3, 2e-3, 1.5e-3, -2.0, 0.7, math.radians(125))
    nodes, weights = np.polynomial.legendre.leggauss(160)
    x, y = (nodes + 1) * 15e-3, (nodes + 1) * 13e-3
    share = np.outer(weights * 13e-3, weights * 15e-3) * layer.base_stress([load], x, y)[0]
    fx, fy, fz = load.force
    assert share.sum() == pytest.approx(fz, rel=1e-8)
    assert (share * x).sum() == pytest.approx(14.2e-3 * fz - height * fx, rel=1e-6)
    assert (share * y[:, None]).sum() == pytest.approx(12.6e-3 * fz - height * fy, rel=1e-6)


@settings(max_examples=20)
@given(contacts_on_square, st.sampled_from(["point", "area"]))
def test_a_quarter_turn_turns_the_frame(load: Contact, sampling: module.Sampling) -> None:
    turned = replace(
        load,
        center_x=28e-3 - load.center_y,
        center_y=load.center_x,
        half_x=load.half_y,
        half_y=load.half_x,
        phi=load.phi + math.pi / 2,
    )
    frame, rotated = frames(SQUARE, [load, turned], sampling)
    np.testing.assert_allclose(rotated, np.rot90(frame, -1), rtol=0, atol=1e-9 * np.abs(frame).max())


def test_area_average_is_the_mean_of_dense_points() -> None:
    load = replace(HERTZ, phi=math.radians(40))
    layer = ElasticLayer.under(SENSOR)
    area = frames(SENSOR, [load], "area")[0]
    offset_x, offset_y = ((np.arange(40) + 0.5) / 40 - 0.5) * 4e-3, ((np.arange(40) + 0.5) / 40 - 0.5) * 2e-3
    for i, j in ((0, 0), (4, 4), (5, 2), (9, 9)):
        dense = layer.base_stress([load], j * 4e-3 + offset_x, i * 2e-3 + offset_y)
        assert area[i, j] == pytest.approx(dense.mean(), abs=2e-4 * np.abs(area).max())


def test_a_batch_is_its_contacts_one_by_one() -> None:
    rng = np.random.default_rng(7)
    batch = [
        replace(HERTZ, shape=SHAPES[i % 3], center_x=rng.uniform(14e-3, 22e-3), phi=rng.uniform(0, 6))
        for i in range(40)
    ]
    together = frames(SENSOR, batch)
    assert together.shape == (40, 10, 10)
    np.testing.assert_array_equal(together, np.concatenate([frames(SENSOR, [load]) for load in batch]))
    assert frames(SENSOR, []).shape == (0, 10, 10)


@pytest.fixture
def fresh_modes() -> Iterator[Callable[[], None]]:
    module._modes.cache_clear()
    yield module._modes.cache_clear
    module._modes.cache_clear()


@pytest.mark.parametrize("truncation", [1e-2, 1e-5, 1e-10])
@pytest.mark.parametrize("half", [0.05e-3, 4e-3])
def test_modes_left_out_stay_below_the_bound(
    truncation: float, half: float, monkeypatch: pytest.MonkeyPatch, fresh_modes: Callable[[], None]
) -> None:
    load = Contact(ContactShape.UNIFORM, 17e-3, 8.7e-3, half, half, -1.0, 1.0, 0.7)
    monkeypatch.setattr(module, "TRUNCATION", 1e-14)
    full = frames(SENSOR, [load])
    fresh_modes()
    monkeypatch.setattr(module, "TRUNCATION", truncation)
    short = frames(SENSOR, [load])
    mean = 1.0 / (40e-3 * 20e-3)
    rounding = 1e-12 * np.abs(full).max()
    assert np.abs(short - full).max() <= truncation * mean + rounding
    assert truncation < 1e-9 or np.abs(short - full).max() > rounding


@pytest.mark.parametrize(
    "changes", [{"center_x": 5.9e-3}, {"center_x": 30.1e-3}, {"center_y": 2.9e-3}, {"center_y": 15.1e-3}]
)
def test_footprint_must_stay_on_the_block(changes: dict[str, Any]) -> None:
    (field,) = changes
    with pytest.raises(ValueError, match=rf"^contact 1: {field}:"):
        frames(SENSOR, [HERTZ, replace(HERTZ, **changes)])


@pytest.mark.parametrize(
    ("x", "window", "name"),
    [([-2.1e-3], (0, 0), "x"), ([38.1e-3], (0, 0), "x"), ([-1e-3], (4e-3, 1e-3), "x"), ([0.0], (-1e-3, 0), "window")],
)
def test_points_must_stay_on_the_block(x: list[float], window: tuple[float, float], name: str) -> None:
    with pytest.raises(ValueError, match=rf"^{name}:"):
        ElasticLayer.under(SENSOR).base_stress([HERTZ], x, [0.0], window)


def test_unknown_grid_and_sampling() -> None:
    with pytest.raises(ValueError, match=r"^y: a one-dimensional"):
        ElasticLayer.under(SENSOR).base_stress([HERTZ], [0.0], [[0.0]])
    with pytest.raises(ValueError, match=r"^sampling:"):
        frames(SENSOR, [HERTZ], "mean")


@pytest.mark.parametrize(
    ("field", "value"),
    [("size_x", 0.0), ("size_y", math.nan), ("thickness", -1e-3), ("poisson", 0.51), ("poisson", -1.0),
     ("poisson", math.nan), ("origin_x", math.inf), ("origin_y", math.nan)],
)
def test_bad_layers_name_the_field(field: str, value: float) -> None:
    with pytest.raises(ValueError, match=f"^{field}:"):
        replace(ElasticLayer.under(SENSOR), **{field: value})
