"""Finite-element stress under the loaded elastic cover: a second, independent source of frames.

The problem is that of :mod:`tfra.model.cover.layer`: a linear elastic block, bonded at z = 0, rollers at its sides,
the contact's tractions on top.  Nothing is shared with the series there: Navier's equations are assembled on a
graded mesh of 27-node hexahedra, for shear modulus 1 and lambda = 2 nu / (1 - 2 nu); Young's modulus drops out of
the stress.  All elements are boxes, so their matrices are Kronecker products of those that scikit-fem assembles
along x, y and z.

Locking: the cover is thin, bonded and nearly incompressible; with full integration, quadratic hexahedra of 1 mm
miss b_z by up to 3.5 % of its peak at nu = 0.48.  So the volume change enters by its projection on 1, x, y, z in each
element (B-bar; with quadratic displacements a stable pair, doi:10.1007/978-3-642-36519-5), and the error at
nu = 0.499 is nearly that at 0.48.

Stress at the base: not derived from the displacements, which would lose an order, but from the reactions
r = K u of the bonded nodes.  The stress that does the same work as r on every shape function of the base,
M sigma_zz = -r with M the mass matrix of the base, is the conservative flux of Hughes, Engel, Mazzei and Larson
(J. Comput. Phys. 163, 467, 2000): its integral over the base is exactly the applied force.

Solver: conjugate gradients.  Without the terms that couple the three displacements, one-dimensional eigenvectors
invert the stiffness exactly.  With this preconditioner the iterations don't grow when the mesh is refined, and no
factor is stored.

The loads q_x, q_y and q_z of a unit resultant are solved once for each footprint and kept on disk; force,
friction and direction of a contact only combine them.
"""

import hashlib
import json
import math
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from functools import reduce
from pathlib import Path
from typing import Any

import numpy as np
from scipy import linalg, sparse
from scipy.sparse.linalg import LinearOperator, cg

from tfra.model.arrays import Floats
from tfra.model.cover import contact as contact_module
from tfra.model.cover.contact import Contact
from tfra.model.sensor import SensorArray, require_finite
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

    ``size`` > 0 is the longest side of an element under the contact, m; at least 2 ``layers`` of elements get thinner
    towards base and top; ``growth`` >= 1 is the ratio of neighbours' sides away from the contact, up to half the
    thickness.  Raises ``ValueError`` naming the field for other values.
    """

    size: float = 0.5e-3
    layers: int = 4
    growth: float = 1.2

    def __post_init__(self) -> None:
        require_finite(self, "size")
        if self.layers < 2:
            raise ValueError(f"layers: at least 2 are needed, got {self.layers}")
        require_finite(self, "growth", needed="a finite ratio >= 1", good=lambda value: value >= 1)

    def planes(self, sensor: SensorArray, contact: Contact) -> tuple[Floats, Floats, Floats]:
        """Increasing coordinates of the element planes across x, y and z, m; origin in the first taxel, base z = 0."""
        z = sensor.thickness / 2 * (1 - np.cos(np.linspace(0.0, np.pi, self.layers + 1)))
        return self._across(sensor, contact, "x"), self._across(sensor, contact, "y"), z

    def elements(self, sensor: SensorArray, contact: Contact) -> int:
        """Number of elements of the mesh, without making it."""
        across = (self._counts(_stretches(sensor, contact, axis), sensor.thickness / 2) for axis in "xy")
        return math.prod(sum(counts) for counts in across) * self.layers

    def _across(self, sensor: SensorArray, contact: Contact, axis: str) -> Floats:
        lengths, coarsest = _stretches(sensor, contact, axis), sensor.thickness / 2
        before, under, behind = self._counts(lengths, coarsest)
        growing = [np.minimum(self.size * self.growth ** np.arange(1, n + 1), coarsest) for n in (before, behind)]
        shapes = growing[0][::-1], np.ones(under), growing[1]
        widths = [shape * (length / shape.sum()) for shape, length in zip(shapes, lengths, strict=True) if len(shape)]
        return np.asarray(np.cumsum(np.concatenate([[0.0], *widths])) - getattr(sensor, f"pitch_{axis}") / 2)

    def _counts(self, lengths: tuple[float, float, float], coarsest: float) -> tuple[int, int, int]:
        """Numbers of elements before, under and behind the footprint."""
        before, under, behind = lengths
        inside = math.ceil(under / self.size * (1 - _SLACK))
        return self._beside(before, coarsest), inside, self._beside(behind, coarsest)

    def _beside(self, gap: float, coarsest: float) -> int:
        """Number of widths that grow from ``size`` to ``coarsest`` and fill ``gap``; none for rounding errors."""
        left, width, count = gap - _SLACK * self.size, self.size * self.growth, 0
        while left > 0 and self.size < width < coarsest:
            left, width, count = left - width, width * self.growth, count + 1
        return count + max(0, math.ceil(left / min(width, coarsest)))


def _stretches(sensor: SensorArray, contact: Contact, axis: str) -> tuple[float, float, float]:
    """Lengths of the block before, under and behind the footprint, m; negative where it leaves the block."""
    half = getattr(contact, f"half_{axis}")
    before = getattr(contact, f"center_{axis}") - half + getattr(sensor, f"pitch_{axis}") / 2
    return before, 2 * half, getattr(sensor, f"size_{axis}") - before - 2 * half


def fem_frames(
    sensor: SensorArray, contacts: Sequence[Contact], mesh: Mesh | None = None, poisson: float = 0.48
) -> Floats:
    """Return b_z at the taxel centres, shape ``(n, rows, columns)``, Pa, compression negative.

    On the default mesh a footprint takes some ten seconds and 0.7 GiB.  Its response is kept in ``TFRA_CACHE`` or
    ``~/.cache/tfra``; what is damaged there is computed again.

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
    for axis in "xy":
        before, length, behind = _stretches(sensor, contact, axis)
        if min(before, behind) < -_SLACK * getattr(sensor, f"size_{axis}"):
            place = f"{getattr(contact, f'center_{axis}'):g} +- {length / 2:g} m"
            raise ValueError(f"contact {index}: center_{axis}: the footprint {place} leaves the block")
    limits = {"half_x": contact.half_x, "half_y": contact.half_y, "thickness": sensor.thickness}
    for name, value in limits.items():
        if mesh.size > value / 2 * (1 + _SLACK):
            raise ValueError(
                f"contact {index}: elements of {mesh.size:g} m are too coarse for {name} = {value:g} m, "
                f"at most {value / 2:g} m is needed"
            )


class _Line:
    """Quadratic elements on a line: nodes in order, and sparse matrices of integrals of shape functions u, v.

    ``products[j][i]``, ``(nodes, nodes)``: of u (``i`` = 0) or u' (1) times v (``j`` = 0) or v' (1).
    ``moments[k][i]``, ``(elements, nodes)``: of u or u' times an element's normalised Legendre polynomial of degree k.
    """

    def __init__(self, planes: Floats) -> None:
        self._basis = skfem.Basis(skfem.MeshLine(planes), skfem.ElementLineP2(), intorder=_LOAD_ORDER)
        self._order = np.argsort(self._basis.doflocs[0])
        self.nodes: Floats = self._basis.doflocs[0][self._order]
        each = self._basis.with_element(skfem.ElementLineP0())
        self.products = [[self._assembled(_product(i, j))[self._order] for i in (0, 1)] for j in (0, 1)]
        self.moments = [[self._assembled(_moment(i, k), each) for i in (0, 1)] for k in (0, 1)]

    def _assembled(self, form: Callable[..., Any], *test: Any) -> Any:
        return skfem.BilinearForm(form).assemble(self._basis, *test)[:, self._order]

    def modes(self, fixed: list[int]) -> tuple[Floats, Floats]:
        """Eigenvalues ``(k,)`` of stiffness against mass and vectors ``(nodes, k)``, zero at the ``fixed`` nodes."""
        free = np.delete(np.arange(len(self.nodes)), fixed)
        stiffness, mass = (self.products[i][i].toarray()[np.ix_(free, free)] for i in (1, 0))
        values, inner = linalg.eigh(stiffness, mass)
        vectors = np.zeros((len(self.nodes), len(free)))
        vectors[free] = inner
        return values, vectors

    def values(self, at: Floats) -> Floats:
        """Shape functions at points, ``(nodes, points)``."""
        return np.asarray(self._basis.probes(at[None]).toarray()[:, self._order].T)

    def quadrature(self) -> tuple[Floats, Floats]:
        """Points ``(q,)``, and what integrates values there times each shape function, ``(nodes, q)``."""
        points = np.ravel(self._basis.global_coordinates())
        return points, self.values(points) * self._basis.dx.ravel()

    def recovered(self, at: Floats) -> Floats:
        """Map nodal forces to the density at points ``at`` that does the same work, ``(points, nodes)``."""
        return np.asarray(np.linalg.solve(self.products[0][0].toarray(), self.values(at)).T)


def _product(i: int, j: int) -> Callable[..., Any]:
    return lambda u, v, w: (u.grad[0] if i else u) * (v.grad[0] if j else v)


def _moment(i: int, k: int) -> Callable[..., Any]:
    def form(u: Any, each: Any, w: Any) -> Any:
        legendre = np.sqrt(12) * (w.x[0] - w.x[0].mean(axis=-1, keepdims=True)) / w.h if k else 1.0
        return (u.grad[0] if i else u) * legendre / np.sqrt(w.h) * each

    return form


class _Block:
    """The finite-element problem of one mesh; displacements and forces have shape ``(3, x, y, z)``: axis and node."""

    def __init__(self, planes: tuple[Floats, Floats, Floats], poisson: float) -> None:
        self._lame = 2 * poisson / (1 - 2 * poisson)
        self._lines = [_Line(each) for each in planes]
        shape = [len(line.nodes) for line in self._lines]
        self._stiffness = {(i, j): self._coupling(i, j) for i in range(3) for j in range(i, 3)}
        self._volume = [self._divergence(axis) for axis in range(3)]
        self._modes = [self._uncoupled(axis) for axis in range(3)]
        self._free = np.ones((3, *shape))
        self._free[..., 0] = self._free[0, [0, -1]] = self._free[1, :, [0, -1]] = 0

    def load(self, pressure: Callable[[Any, Any], Floats]) -> Floats:
        """Nodal forces ``(x, y)`` of a ``pressure(x, y)`` on top, scaled to a resultant of 1 exactly."""
        (x, over_x), (y, over_y) = (line.quadrature() for line in self._lines[:2])
        forces = over_x @ pressure(x[:, None], y) @ over_y.T
        return np.asarray(forces / forces.sum())

    def solve(self, load: Floats, axis: int) -> Floats:
        """Displacements under ``load (x, y)`` on top along ``axis``; raises ``RuntimeError`` without convergence."""
        forces, free = np.zeros_like(self._free), self._free.ravel()
        forces[axis, :, :, -1] = load
        operator = LinearOperator((free.size, free.size), lambda u: free * self._held(u), dtype=float)
        inverse = LinearOperator((free.size, free.size), self._precondition, dtype=float)
        solution, info = cg(operator, free * forces.ravel(), rtol=RESIDUAL, M=inverse, maxiter=2000)
        if info:
            raise RuntimeError(f"conjugate gradients did not converge in {info} iterations")
        return np.asarray(solution.reshape(forces.shape))

    def base_stress(self, displacements: Floats, x: Floats, y: Floats) -> Floats:
        """sigma_zz at the base, shape ``(len(y), len(x))``, from the reactions of the bonded nodes."""
        reactions = self._held(displacements.ravel()).reshape(displacements.shape)[2, :, :, 0]
        return np.asarray(-self._lines[1].recovered(y) @ reactions.T @ self._lines[0].recovered(x).T)

    def _gradients(self, i: int, j: int) -> Any:
        """Integrals of du/di dv/dj, ``(nodes, nodes)``."""
        return _kron([line.products[k == j][k == i] for k, line in enumerate(self._lines)])

    def _coupling(self, i: int, j: int) -> Any:
        """Forces along ``i`` from displacements along ``j``: 2 eps(u) : eps(v)."""
        crossed = self._gradients(i, j)
        return sum((self._gradients(k, k) for k in range(3)), crossed) if i == j else crossed

    def _divergence(self, axis: int) -> Any:
        """Moments of d/d axis against 1, x, y and z about each element's centre, ``(4 elements, nodes)``.

        Rows are scaled so that the product with the transpose is lambda div u div v, projected.
        """
        lines = list(enumerate(self._lines))
        moments = [_kron([line.moments[k == along][k == axis] for k, line in lines]) for along in (None, 0, 1, 2)]
        return np.sqrt(self._lame) * sparse.vstack(moments, format="csr")

    def _uncoupled(self, axis: int) -> tuple[list[Floats], Floats]:
        """Eigenvectors along x, y, z of the stiffness that ``axis`` has with itself and the inverse eigenvalues."""
        modes = [line.modes([0] if k == 2 else [0, -1] if k == axis else []) for k, line in enumerate(self._lines)]
        weighted = [values * (self._lame + 2 if axis == k else 1) for k, (values, _) in enumerate(modes)]
        total = weighted[0][:, None, None] + weighted[1][:, None] + weighted[2]
        return [vectors for _, vectors in modes], 1 / total

    def _held(self, u: Floats) -> Floats:
        """K u, the forces that hold the displacements ``u``, both flat."""
        moved = u.reshape(3, -1)
        pressure = sum(matrix @ each for matrix, each in zip(self._volume, moved, strict=True))
        forces = np.stack([matrix.T @ pressure for matrix in self._volume])
        for (i, j), matrix in self._stiffness.items():
            forces[i] += matrix @ moved[j]
            if i != j:
                forces[j] += matrix.T @ moved[i]
        return forces.ravel()

    def _precondition(self, forces: Floats) -> Floats:
        """Displacements of an uncoupled material under ``forces``, both flat."""
        parts = zip(forces.reshape(self._free.shape), self._modes, strict=True)
        moved = [_along(inverse * _along(force, x.T, y.T, z.T), x, y, z) for force, ((x, y, z), inverse) in parts]
        return np.stack(moved).ravel()


def _kron(lines: Sequence[Any]) -> Any:
    """Kronecker product of the sparse matrices of three lines."""
    return reduce(lambda left, right: sparse.kron(left, right, format="csr"), lines)


def _along(values: Floats, x: Floats, y: Floats, z: Floats) -> Floats:
    """Multiply ``values (a, b, c)`` by a matrix along each of its axes."""
    first = np.tensordot(x, values, 1)
    return np.asarray(y @ (first @ z.T))


def _cached(sensor: SensorArray, contact: Contact, mesh: Mesh, poisson: float) -> Floats:
    """``response`` from the disk, or computed and stored there, named by all that it depends on, code included."""
    inputs = [asdict(sensor), asdict(contact), asdict(mesh), poisson, skfem.__version__]
    digest = hashlib.sha256(json.dumps(inputs, sort_keys=True).encode())
    for source in (__file__, contact_module.__file__):
        digest.update(Path(str(source)).read_bytes())
    path = cache_directory() / f"fem-{digest.hexdigest()}"
    files = cached(path, lambda: {"response": response(sensor, contact, mesh, poisson).tobytes()})
    return np.frombuffer(files["response"]).reshape(3, sensor.rows, sensor.columns)
