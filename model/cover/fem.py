"""Finite-element stress under the loaded elastic cover: a second, independent source of frames.

The problem is that of :mod:`tfra.model.cover.layer`: a linear elastic block, bonded at z = 0, rollers at its sides,
the contact's tractions on top.  Nothing is shared with the series there: scikit-fem assembles Navier's
equations on a graded mesh of 27-node hexahedra, for shear modulus 1 and lambda = 2 nu / (1 - 2 nu); Young's
modulus drops out of the stress.

Locking: the cover is thin, bonded and nearly incompressible; with full integration, quadratic hexahedra of 1 mm
miss b_z by up to 3.5 % of its peak at nu = 0.48.  So the volume change enters by its projection on 1, x, y, z in each
element (B-bar; with quadratic displacements a stable pair, doi:10.1007/978-3-642-36519-5), and the error at
nu = 0.499 is nearly that at 0.48, see the table of ``bench/contacts/fem_convergence.py``.

Stress at the base: not derived from the displacements, which would lose an order, but from the reactions
r = K u of the bonded nodes.  The stress that does the same work as r on every shape function of the base,
M sigma_zz = -r with M the mass matrix of the base, is the conservative flux of Hughes, Engel, Mazzei and Larson
(J. Comput. Phys. 163, 467, 2000): its integral over the base is exactly the applied force.

Solver: conjugate gradients.  All elements are boxes, so without the terms that couple the three displacements
the stiffness is a sum of Kronecker products, which one-dimensional eigenvectors invert exactly.  With this
preconditioner the iterations don't grow when the mesh is refined, and no factor is stored.

The loads q_x, q_y and q_z of a unit resultant are solved once for each footprint and kept on disk; force,
friction and direction of a contact only combine them.
"""

import hashlib
import json
import math
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy import linalg, sparse
from scipy.sparse.linalg import LinearOperator, cg

from tfra.model.arrays import Floats, Ints
from tfra.model.cover import contact as contact_module
from tfra.model.cover.contact import Contact
from tfra.model.sensor import SensorArray
from tfra.runtime.store import cache_directory, cached

try:
    import skfem
except ImportError as error:
    raise ImportError("finite elements need scikit-fem, please run: pip install 'tfra[fem]'") from error

RESIDUAL = 1e-10
"""Conjugate gradients stop at this residual, relative to the load."""

_LOAD_ORDER = 12  # of the quadrature over a loaded facet; the pressure is not smooth at the contact's edge
_SLACK = 1e-9  # share of a length that rounding may cost


@dataclass(frozen=True, slots=True)
class Mesh:
    """A graded mesh of boxes whose planes follow the edges of the footprint.

    Attributes:
        size: Longest side of an element under the contact, m, > 0.
        layers: Elements through the thickness, thinner towards base and top, at least 2.
        growth: Ratio of neighbours' sides away from the contact, >= 1; they grow up to half the thickness.

    Raises ``ValueError`` naming the field for a value outside these ranges or not finite.
    """

    size: float = 0.5e-3
    layers: int = 4
    growth: float = 1.2

    def __post_init__(self) -> None:
        if not (math.isfinite(self.size) and self.size > 0):
            raise ValueError(f"size: a positive, finite length is needed, got {self.size}")
        if self.layers < 2:
            raise ValueError(f"layers: at least 2 are needed, got {self.layers}")
        if not (math.isfinite(self.growth) and self.growth >= 1):
            raise ValueError(f"growth: a finite ratio >= 1 is needed, got {self.growth}")

    def planes(self, sensor: SensorArray, contact: Contact) -> tuple[Floats, Floats, Floats]:
        """Increasing coordinates of the element planes across x, y and z, m; origin in the first taxel, base z = 0."""
        half_height = sensor.thickness / 2
        z = half_height * (1 - np.cos(np.linspace(0.0, np.pi, self.layers + 1)))
        x = self._across(-sensor.pitch_x / 2, sensor.size_x, contact.center_x, contact.half_x, half_height)
        y = self._across(-sensor.pitch_y / 2, sensor.size_y, contact.center_y, contact.half_y, half_height)
        return x, y, z

    def elements(self, sensor: SensorArray, contact: Contact) -> int:
        """Number of elements of the mesh, without making it."""
        across = (
            math.ceil(2 * half / self.size * (1 - _SLACK))
            + self._count_beside(center - half + pitch / 2, sensor.thickness / 2)
            + self._count_beside(size - pitch / 2 - center - half, sensor.thickness / 2)
            for center, half, pitch, size in (
                (contact.center_x, contact.half_x, sensor.pitch_x, sensor.size_x),
                (contact.center_y, contact.half_y, sensor.pitch_y, sensor.size_y),
            )
        )
        return math.prod(across) * self.layers

    def _across(self, low: float, length: float, center: float, half: float, coarsest: float) -> Floats:
        count = math.ceil(2 * half / self.size * (1 - _SLACK))
        inside = np.full(count, 2 * half / count)
        left = self._beside(center - half - low, coarsest)
        right = self._beside(low + length - center - half, coarsest)
        return np.asarray(low + np.cumsum(np.concatenate([[0.0], left[::-1], inside, right])))

    def _beside(self, gap: float, coarsest: float) -> Floats:
        """Widths that grow from ``size`` to ``coarsest`` and fill ``gap``; none for a gap of rounding errors."""
        widths: list[float] = []
        while sum(widths) < gap - _SLACK * self.size:
            widths.append(min(self.size * self.growth ** (len(widths) + 1), coarsest))
        return np.array(widths) * (gap / sum(widths) if widths else 0.0)

    def _count_beside(self, gap: float, coarsest: float) -> int:
        """Number of widths that ``_beside`` returns."""
        left, width, count = gap - _SLACK * self.size, self.size * self.growth, 0
        while left > 0 and self.size < width < coarsest:
            left, width, count = left - width, width * self.growth, count + 1
        return count + max(0, math.ceil(left / min(width, coarsest)))


def fem_frames(
    sensor: SensorArray, contacts: Sequence[Contact], mesh: Mesh | None = None, poisson: float = 0.48
) -> Floats:
    """Return b_z at the taxel centres, shape ``(n, rows, columns)``, Pa, compression negative.

    On the default mesh a footprint takes some ten seconds and 0.7 GiB.
    Its response is kept in ``TFRA_CACHE`` or ``~/.cache/tfra``; what is damaged there is computed
    again.

    Raises:
        ValueError: ``poisson`` is not in [0, 0.5), a footprint leaves the block, or the mesh is too coarse for a
            contact: an element must not be longer than half of half_x, half_y and the thickness.
        RuntimeError: Conjugate gradients did not converge.
    """
    if not 0.0 <= poisson < 0.5:
        raise ValueError(f"poisson: a value in [0, 0.5) is needed, got {poisson}")
    chosen = mesh or Mesh()
    footprints = [replace(contact, normal_force=-1.0, mu=0.0, phi=0.0) for contact in contacts]
    for index, footprint in enumerate(footprints):
        _check(index, sensor, footprint, chosen)
    responses = {each: _cached(sensor, each, chosen, poisson) for each in dict.fromkeys(footprints)}
    frames = np.empty((len(contacts), sensor.rows, sensor.columns))
    for frame, contact, footprint in zip(frames, contacts, footprints, strict=True):
        frame[:] = np.tensordot(contact.force, responses[footprint], 1)
    return frames


def response(sensor: SensorArray, contact: Contact, mesh: Mesh, poisson: float) -> Floats:
    """Return b_z at the taxel centres for unit resultants F_x, F_y, F_z spread like the contact's pressure.

    Shape ``(3, rows, columns)`` in 1/m^2; nothing is read from or written to the cache.  Raises ``RuntimeError``
    if conjugate gradients did not converge.
    """
    block = _Block(mesh.planes(sensor, contact), poisson)
    load = block.load(contact.pressure)
    x, y = (at.reshape(sensor.rows, sensor.columns) for at in sensor.positions())
    return np.stack([block.base_stress(block.solve(load, axis), x[0], y[:, 0]) for axis in range(3)])


def _check(index: int, sensor: SensorArray, contact: Contact, mesh: Mesh) -> None:
    for axis in ("x", "y"):
        center, half = getattr(contact, f"center_{axis}"), getattr(contact, f"half_{axis}")
        low, size = -getattr(sensor, f"pitch_{axis}") / 2, getattr(sensor, f"size_{axis}")
        if center - half < low - _SLACK * size or center + half > low + size * (1 + _SLACK):
            raise ValueError(f"contact {index}: center_{axis}: the footprint {center:g} +- {half:g} m leaves the block")
    limits = {"half_x": contact.half_x, "half_y": contact.half_y, "thickness": sensor.thickness}
    for name, value in limits.items():
        if mesh.size > value / 2 * (1 + _SLACK):
            raise ValueError(
                f"contact {index}: elements of {mesh.size:g} m are too coarse for {name} = {value:g} m, "
                f"at most {value / 2:g} m is needed"
            )


class _Line:
    """Quadratic elements on a line: nodes in order, mass and stiffness as dense matrices."""

    def __init__(self, planes: Floats) -> None:
        self._basis = skfem.Basis(skfem.MeshLine(planes), skfem.ElementLineP2())
        self._order = np.argsort(self._basis.doflocs[0])
        self.nodes: Floats = self._basis.doflocs[0][self._order]
        self.mass = self._assembled(lambda u, v, w: u * v)
        self.stiffness = self._assembled(lambda u, v, w: u.grad[0] * v.grad[0])

    def _assembled(self, form: Callable[..., Any]) -> Floats:
        matrix = skfem.BilinearForm(form).assemble(self._basis).toarray()
        return np.asarray(matrix[np.ix_(self._order, self._order)])

    def modes(self, fixed: list[int]) -> tuple[Floats, Floats]:
        """Eigenvalues ``(k,)`` of stiffness against mass and vectors ``(nodes, k)``, zero at the ``fixed`` nodes."""
        free = np.delete(np.arange(len(self.nodes)), fixed)
        values, inner = linalg.eigh(self.stiffness[np.ix_(free, free)], self.mass[np.ix_(free, free)])
        vectors = np.zeros((len(self.nodes), len(free)))
        vectors[free] = inner
        return values, vectors

    def recovered(self, at: Floats) -> Floats:
        """Map nodal forces to the density at points ``at`` that does the same work, ``(points, nodes)``."""
        values = self._basis.probes(at[None]).toarray()[:, self._order]
        return np.asarray(np.linalg.solve(self.mass, values.T).T)


class _Block:
    """The finite-element problem of one mesh; displacements and loads have shape ``(3, nodes)``."""

    def __init__(self, planes: tuple[Floats, Floats, Floats], poisson: float) -> None:
        self._lame = 2 * poisson / (1 - 2 * poisson)
        self._lines = [_Line(each) for each in planes]
        self._mesh = skfem.MeshHex.init_tensor(*planes)
        self._basis = skfem.Basis(self._mesh, skfem.ElementHex2(), intorder=5)
        self._grid = self._numbering()
        self._fixed = [[[0, -1] if axis == along else [] for along in range(2)] + [[0]] for axis in range(3)]
        self._stiffness = {(i, j): self._coupling(i, j) for i in range(3) for j in range(i, 3)}
        self._volume = [self._divergence(axis) for axis in range(3)]
        self._modes = [self._uncoupled(axis) for axis in range(3)]
        self._free = np.stack([self._freedom(axis) for axis in range(3)])

    def load(self, pressure: Callable[[Any, Any], Floats]) -> Floats:
        """Nodal forces ``(nodes,)`` of a ``pressure(x, y)`` on top, scaled to a resultant of 1 exactly."""
        height = self._lines[2].nodes[-1]
        top = self._mesh.facets_satisfying(lambda place: place[2] > height * (1 - _SLACK), boundaries_only=True)
        basis = skfem.FacetBasis(self._mesh, skfem.ElementHex2(), facets=top, intorder=_LOAD_ORDER)
        forces = skfem.LinearForm(lambda v, w: pressure(w.x[0], w.x[1]) * v).assemble(basis)
        return np.asarray(forces / forces.sum())

    def solve(self, load: Floats, axis: int) -> Floats:
        """Displacements under ``load (nodes,)`` along ``axis``; raises ``RuntimeError`` without convergence."""
        forces = np.zeros((3, load.size))
        forces[axis] = load
        size = (forces.size, forces.size)
        operator = LinearOperator(size, lambda u: (self._free * self._reactions(u.reshape(3, -1))).ravel(), dtype=float)
        inverse = LinearOperator(size, lambda r: self._precondition(r.reshape(3, -1)).ravel(), dtype=float)
        solution, info = cg(operator, (self._free * forces).ravel(), rtol=RESIDUAL, M=inverse, maxiter=2000)
        if info:
            raise RuntimeError(f"conjugate gradients did not converge in {info} iterations")
        return np.asarray(solution.reshape(3, -1))

    def base_stress(self, displacements: Floats, x: Floats, y: Floats) -> Floats:
        """sigma_zz at the base, shape ``(len(y), len(x))``, from the reactions of the bonded nodes."""
        reactions = self._reactions(displacements)[2][self._grid[:, :, 0]]
        return np.asarray(-self._lines[1].recovered(y) @ reactions.T @ self._lines[0].recovered(x).T)

    def _numbering(self) -> Ints:
        """Number of every node by its place in the grid, shape ``(nodes_x, nodes_y, nodes_z)``."""
        axes = [line.nodes for line in self._lines]
        middles = [(nodes[1:] + nodes[:-1]) / 2 for nodes in axes]
        places = [np.searchsorted(middle, at) for middle, at in zip(middles, self._basis.doflocs, strict=True)]
        grid = np.empty([len(nodes) for nodes in axes], dtype=np.int64)
        grid[tuple(places)] = np.arange(self._basis.N)
        return grid

    def _coupling(self, i: int, j: int) -> Any:
        """Sparse forces along ``i`` from displacements along ``j``: 2 eps(u) : eps(v)."""

        def form(u: Any, v: Any, w: Any) -> Any:
            return u.grad[i] * v.grad[j] + (sum(u.grad[k] * v.grad[k] for k in range(3)) if i == j else 0)

        return skfem.BilinearForm(form).assemble(self._basis)

    def _divergence(self, axis: int) -> Any:
        """Elementwise moments of d/d axis against 1, x, y and z about the centre, shape ``(4 elements, nodes)``.

        Rows are scaled so that the product with the transpose is lambda div u div v, projected.
        """
        constant = self._basis.with_element(skfem.ElementHex0())
        rows = []
        for along in (None, 0, 1, 2):

            def moment(w: Any, along: int | None = along) -> Any:
                return 1.0 if along is None else w.x[along] - w.x[along].mean(axis=-1, keepdims=True)

            def square(q: Any, w: Any, moment: Any = moment) -> Any:
                return moment(w) ** 2 * q

            def derivative(u: Any, q: Any, w: Any, moment: Any = moment) -> Any:
                return u.grad[axis] * moment(w) * q

            scale = np.sqrt(self._lame / skfem.LinearForm(square).assemble(constant))
            rows.append(sparse.diags_array(scale) @ skfem.BilinearForm(derivative).assemble(self._basis, constant))
        return sparse.vstack(rows).tocsr()

    def _uncoupled(self, axis: int) -> tuple[list[Floats], Floats]:
        """Eigenvectors along x, y, z of the stiffness that ``axis`` has with itself and the inverse eigenvalues."""
        modes = [line.modes(fixed) for line, fixed in zip(self._lines, self._fixed[axis], strict=True)]
        weighted = [values * (self._lame + 2 if axis == k else 1) for k, (values, _) in enumerate(modes)]
        total = weighted[0][:, None, None] + weighted[1][:, None] + weighted[2]
        return [vectors for _, vectors in modes], 1 / total

    def _freedom(self, axis: int) -> Floats:
        """1 at the nodes that can move along ``axis``, 0 at those held."""
        free = np.ones(self._basis.N)
        for along, fixed in enumerate(self._fixed[axis]):
            free[np.take(self._grid, fixed, axis=along)] = 0
        return free

    def _reactions(self, u: Floats) -> Floats:
        """K u, the forces ``(3, nodes)`` that hold the displacements ``u``."""
        pressure = sum(matrix @ each for matrix, each in zip(self._volume, u, strict=True))
        forces = np.stack([matrix.T @ pressure for matrix in self._volume])
        for (i, j), matrix in self._stiffness.items():
            forces[i] += matrix @ u[j]
            if i != j:
                forces[j] += matrix.T @ u[i]
        return forces

    def _precondition(self, forces: Floats) -> Floats:
        """Displacements of an uncoupled material under ``forces``."""
        product = np.empty_like(forces)
        for axis, ((x, y, z), inverse) in enumerate(self._modes):
            amplitudes = inverse * _along(forces[axis][self._grid], x.T, y.T, z.T)
            product[axis][self._grid] = _along(amplitudes, x, y, z)
        return product


def _along(values: Floats, x: Floats, y: Floats, z: Floats) -> Floats:
    """Multiply ``values (a, b, c)`` by a matrix along each of its axes."""
    first = np.tensordot(x, values, 1)
    return np.asarray(y @ (first @ z.T))


def _cached(sensor: SensorArray, contact: Contact, mesh: Mesh, poisson: float) -> Floats:
    """``response`` from the disk, or computed and stored there."""
    path = _cache_path(sensor, contact, mesh, poisson)
    files = cached(path, lambda: {"response": response(sensor, contact, mesh, poisson).tobytes()})
    return np.frombuffer(files["response"]).reshape(3, sensor.rows, sensor.columns)


def _cache_path(sensor: SensorArray, contact: Contact, mesh: Mesh, poisson: float) -> Path:
    """File named by a hash of everything the response depends on, the code and its libraries included."""
    inputs = [asdict(sensor), asdict(contact), asdict(mesh), poisson, skfem.__version__]
    digest = hashlib.sha256(json.dumps(inputs, sort_keys=True).encode())
    for source in (__file__, contact_module.__file__):
        digest.update(Path(str(source)).read_bytes())
    return cache_directory() / f"fem-{digest.hexdigest()}"
