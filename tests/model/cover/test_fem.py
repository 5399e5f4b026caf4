"""Finite elements of the cover against exact states, a generic solve by scikit-fem and the Fourier series."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import skfem
from skfem.models.elasticity import linear_elasticity

from tests.marks import long
from tfra.model.arrays import Floats
from tfra.model.cover import fem
from tfra.model.cover.contact import Contact, ContactShape
from tfra.model.cover.fem import Mesh, fem_frames
from tfra.model.cover.layer import frames
from tfra.model.sensor import SensorArray

SENSOR = SensorArray(rows=5, columns=6, pitch_x=3e-3, pitch_y=3e-3, thickness=3e-3)
CONTACT = Contact(ContactShape.HERTZ, 7e-3, 6.5e-3, 4e-3, 3e-3, -2.0, 0.5, 0.6)
COARSE = Mesh(size=1.5e-3, layers=3, growth=1.5)
THIN = replace(COARSE, layers=2)
FINE = Mesh(size=0.75e-3, layers=3, growth=1.3)


@pytest.fixture(autouse=True)
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A cache of the test's own."""
    monkeypatch.setenv("TFRA_CACHE", str(tmp_path))
    return tmp_path


def worst(found: Floats, expected: Floats) -> float:
    """Largest difference over the largest magnitude expected."""
    return float(np.abs(found - expected).max() / np.abs(expected).max())


@pytest.mark.parametrize("poisson", [0.0, 0.499])
def test_uniform_compression_is_exact(poisson: float) -> None:
    x, y = SENSOR.size_x, SENSOR.size_y
    everywhere = Contact(ContactShape.UNIFORM, (x - 3e-3) / 2, (y - 3e-3) / 2, x / 2, y / 2, -2.0, 0.0, 0.0)
    found = fem_frames(SENSOR, [everywhere], THIN, poisson)
    np.testing.assert_allclose(found, -2.0 / (x * y), rtol=1e-7)


def test_stress_at_the_base_carries_the_load() -> None:
    block = fem._Block(THIN.planes(SENSOR, CONTACT), 0.48)
    (x, over_x), (y, over_y) = (line.quadrature() for line in block._lines[:2])
    for axis in range(3):
        stress = block.base_stress(block.solve(block.load(CONTACT.pressure), axis), x, y)
        assert (over_y @ stress @ over_x.T).sum() == pytest.approx(float(axis == 2), abs=1e-6)


def generic(sensor: SensorArray, contact: Contact, mesh: Mesh, poisson: float) -> Floats:
    """Reaction along z of every node at the base by scikit-fem's own elasticity, loads, constraints and direct solver.

    Full integration, no projection: equal to the module's for poisson = 0, where lambda vanishes.
    """
    grid = skfem.MeshHex.init_tensor(*mesh.planes(sensor, contact))
    basis = skfem.Basis(grid, skfem.ElementVector(skfem.ElementHex2()), intorder=5)
    stiffness = linear_elasticity(2 * poisson / (1 - 2 * poisson), 1.0).assemble(basis)

    @skfem.LinearForm
    def traction(v, w):
        q = contact.tractions(w.x[0], w.x[1])
        return sum(q[i] * v[i] for i in range(3))

    def at(axis, end):
        return grid.facets_satisfying(lambda p: np.isclose(p[axis], end(grid.p[axis])), boundaries_only=True)

    top = skfem.FacetBasis(grid, basis.elem, facets=at(2, max), intorder=12)
    sides = [basis.get_dofs(at(axis, end)).all(f"u^{axis + 1}") for axis in range(2) for end in (min, max)]
    base = basis.get_dofs(at(2, min))
    fixed = np.concatenate([*sides, base.all()])
    reactions = stiffness @ skfem.solve(*skfem.condense(stiffness, traction.assemble(top), D=fixed))
    vertical = base.all("u^3")
    return np.asarray(reactions[vertical][np.lexsort(np.rint(basis.doflocs[1::-1, vertical] * 1e9))])


@pytest.mark.long
def test_agrees_with_the_generic_solve() -> None:
    contact = replace(CONTACT, shape=ContactShape.UNIFORM)  # its load is integrated exactly
    expected = generic(SENSOR, contact, THIN, 0.0)
    block = fem._Block(THIN.planes(SENSOR, contact), 0.0)
    load = block.load(contact.pressure)
    held = [force * block._held(block.solve(load, axis).ravel()) for axis, force in enumerate(contact.force)]
    assert worst(np.sum(held, axis=0).reshape(block._free.shape)[2, :, :, 0].ravel(), expected) < 1e-7


@pytest.mark.parametrize(
    ("shape", "poisson", "size", "bound"),
    [
        ("hertz", 0.48, 1.5e-3, 0.02),
        *long(("hertz", 0.48, 0.75e-3, 0.01), ("uniform", 0.48, 0.75e-3, 0.01), ("rounded", 0.3, 0.75e-3, 0.005)),
    ],
)
def test_agrees_with_the_series(shape: str, poisson: float, size: float, bound: float) -> None:
    directions = ((0.0, 0.0), (0.5, 0.0), (1.0, 2.2))
    contacts = [replace(CONTACT, shape=ContactShape(shape), mu=mu, phi=phi) for mu, phi in directions]
    expected = frames(SENSOR, contacts, poisson=poisson)
    found = fem_frames(SENSOR, contacts, replace(FINE, size=size), poisson)
    assert worst(found, expected) < bound
    wrong = expected.copy()
    wrong[0][np.unravel_index(np.abs(wrong[0]).argmax(), wrong[0].shape)] *= 1.03
    assert worst(found, wrong) > bound


@pytest.mark.long
def test_does_not_lock() -> None:
    """Nearly incompressible is as good as nu = 0.48 on the same mesh."""
    soft, stiff = (
        worst(fem_frames(SENSOR, [CONTACT], THIN, nu), frames(SENSOR, [CONTACT], poisson=nu)) for nu in (0.48, 0.499)
    )
    assert stiff < 1.2 * soft < 0.03


@pytest.fixture
def computed(monkeypatch: pytest.MonkeyPatch) -> list[Contact]:
    """The footprints whose response was computed, by a cheap substitute."""
    calls: list[Contact] = []

    def substitute(sensor: SensorArray, contact: Contact, mesh: Mesh, poisson: float) -> Floats:
        calls.append(contact)
        return np.random.default_rng(1).normal(size=(3, sensor.rows, sensor.columns))

    monkeypatch.setattr(fem, "response", substitute)
    return calls


def test_directions_and_forces_share_one_response(cache: Path, computed: list[Contact]) -> None:
    contacts = [replace(CONTACT, phi=phi, mu=0.1 + phi / 10, normal_force=-1 - phi) for phi in range(4)]
    found = fem_frames(SENSOR, contacts, COARSE)
    files = list(cache.iterdir())  # temporary ones included
    np.testing.assert_array_equal(fem_frames(SENSOR, contacts[::-1], COARSE), found[::-1])
    assert len(computed) == len(files) == 1
    assert list(cache.iterdir()) == files


@pytest.mark.parametrize("change", ["sensor", "contacts", "mesh", "poisson"])
def test_other_inputs_have_other_entries(change: str, computed: list[Contact]) -> None:
    inputs = {"sensor": SENSOR, "contacts": [CONTACT], "mesh": COARSE, "poisson": 0.48}
    other = {
        "sensor": replace(SENSOR, thickness=3.1e-3),
        "contacts": [replace(CONTACT, center_x=7.1e-3)],
        "mesh": replace(COARSE, layers=4),
        "poisson": 0.47,
    }
    fem_frames(**inputs)
    fem_frames(**inputs | {change: other[change]})
    assert len(computed) == 2


def test_planes_follow_block_and_footprint() -> None:
    x, y, z = FINE.planes(SENSOR, CONTACT)
    for planes, center, half, low, size in (
        (x, CONTACT.center_x, CONTACT.half_x, -1.5e-3, SENSOR.size_x),
        (y, CONTACT.center_y, CONTACT.half_y, -1.5e-3, SENSOR.size_y),
    ):
        assert planes[[0, -1]] == pytest.approx([low, low + size])
        for edge in (center - half, center + half):
            assert np.abs(planes - edge).min() < 1e-12
        inside = np.diff(planes)[np.abs((planes[1:] + planes[:-1]) / 2 - center) < half]
        assert 0 < inside.max() <= FINE.size * (1 + 1e-9)
        assert np.diff(planes).min() > 0
        assert np.diff(planes).max() <= SENSOR.thickness / 2
    assert z[[0, -1]] == pytest.approx([0.0, SENSOR.thickness])
    assert len(z) == FINE.layers + 1
    assert FINE.elements(SENSOR, CONTACT) == (len(x) - 1) * (len(y) - 1) * FINE.layers


def test_too_coarse_a_mesh_is_an_error() -> None:
    small = replace(CONTACT, half_y=1e-3)
    with pytest.raises(ValueError, match=r"contact 1: elements of 0\.0015 m are too coarse for half_y = 0\.001 m"):
        fem_frames(SENSOR, [CONTACT, small], COARSE)
    with pytest.raises(ValueError, match=r"contact 0: elements of 0\.0015 m are too coarse for thickness = 0\.002 m"):
        fem_frames(replace(SENSOR, thickness=2e-3), [CONTACT], COARSE)


def test_a_footprint_off_the_block_is_an_error() -> None:
    with pytest.raises(ValueError, match=r"contact 0: center_x: the footprint 0 .* leaves the block"):
        fem_frames(SENSOR, [replace(CONTACT, center_x=0.0)], COARSE)


@pytest.mark.parametrize("poisson", [-0.1, 0.5, math.nan])
def test_poisson_is_checked(poisson: float) -> None:
    with pytest.raises(ValueError, match="poisson"):
        fem_frames(SENSOR, [CONTACT], COARSE, poisson)


@pytest.mark.parametrize(("field", "value"), [("size", 0.0), ("size", math.inf), ("layers", 1), ("growth", 0.9)])
def test_mesh_is_checked(field: str, value: float) -> None:
    with pytest.raises(ValueError, match=field):
        replace(FINE, **{field: value})
