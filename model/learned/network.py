"""The learned estimator: a resultant by a network, forces at the taxels by the elastic layer.

The array's two mirrors commute with the network, and it has no biases.

The mirrors form the group e, X, Y, XY, in this order everywhere: X reverses columns, Y rows.  The product of two
elements is the exclusive or of their numbers, and each is its own inverse.  With n = b pitch_x pitch_y, the normal
force at every taxel in N (compression negative), flattened row by row,

    h1[g, c] = ReLU( first[c] . (g n) )
    h2[g, c] = ReLU( sum over g', c' of second[g g', c, c'] h1[g', c'] )
    F[o]     = sum over g of chi[o, g] ( read2[o] . h2[g] + read1[o] . h1[g] + direct[o] . (g n) )

are the outputs of :data:`OUTPUTS` in N.  chi is -1 for F_x under X and XY and for F_y under Y and XY, else 1.

It is computed folded by the mirrors: a quarter of the products, the same numbers.  A sum over the group becomes a
product for each parity (EE, OX, OY, OO) after the butterfly of :mod:`tfra.model.fixed.butterfly`.  So n is folded once,
every matrix is transformed once, and each layer is

    four products, one a parity  ->  butterfly  ->  ReLU at each mirror  ->  butterfly.

F_x is odd in x, F_y odd in y, F_z and the uncertainty are even in both, so each output reads one parity alone.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Generic, NamedTuple, TypeVar

import numpy as np
import numpy.typing as npt

from tfra.model.arrays import Bools, Floats, Singles
from tfra.model.choices import SERIAL, Choices
from tfra.model.fixed.butterfly import EE, HADAMARD, OX, OY, butterfly, taxel_index, to_quads
from tfra.model.learned.field import residual, spread
from tfra.model.sensor import SensorArray
from tfra.model.tfra import Result, Status, check_frames, direction_deg, friction, in_contact, unit_scaled
from tfra.runtime.digest import digest

MIRRORS = 4
"""Elements of the group."""

OUTPUTS = ("F_x", "F_y", "F_z", "uncertainty")
"""The resultant, and how unsure of it the network is; where that is negative, it stands for zero.  No error bar."""

READ = (OX, OY, EE, EE)
"""Parity that each output reads."""

NAMES = ("first", "second", "read2", "read1", "direct")
"""Names of the arrays."""


@dataclass(frozen=True, eq=False)
class Weights:
    """One network of m taxels, C1 orbits of units in its first layer and C2 in its second; float64 arrays.

    ``first (C1, m)``, ``second (4, C2, C1)``, ``read2 (4, C2)``, ``read1 (4, C1)``, ``direct (4, m)``.  Raises
    ``ValueError`` that starts with the name of an array of another shape, or with a number that is not finite.
    Weights with the same numbers are equal.
    """

    first: Floats
    second: Floats
    read2: Floats
    read1: Floats
    direct: Floats

    def __post_init__(self) -> None:
        for name in NAMES:
            object.__setattr__(self, name, np.asarray(getattr(self, name), dtype=np.float64))
        for name, axes in (("first", 2), ("second", 3)):
            shape = getattr(self, name).shape
            if len(shape) != axes or 0 in shape:
                raise ValueError(f"{name}: an array of {axes} axes is needed, none of them empty, got shape {shape}")
        c2, (c1, taxels) = self.second.shape[1], self.first.shape
        outputs = len(OUTPUTS)
        layers = {"second": (MIRRORS, c2, c1)}
        needed = layers | {"read2": (outputs, c2), "read1": (outputs, c1), "direct": (outputs, taxels)}
        for name, shape in needed.items():
            if getattr(self, name).shape != shape:
                raise ValueError(f"{name}: shape {shape} is needed, got {getattr(self, name).shape}")
        for name in NAMES:
            if not np.isfinite(getattr(self, name)).all():
                raise ValueError(f"{name}: a number is not finite")

    @cached_property
    def _digest(self) -> str:
        return digest(repr(self.counts), *(getattr(self, name).tobytes().hex() for name in NAMES))

    def __repr__(self) -> str:
        return f"Weights({self._digest})"

    def __hash__(self) -> int:
        return hash(self._digest)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Weights) and all(np.array_equal(getattr(self, n), getattr(other, n)) for n in NAMES)

    @property
    def counts(self) -> tuple[int, int]:
        """C1, C2."""
        return len(self.first), self.second.shape[1]

    @property
    def taxels(self) -> int:
        """m."""
        return int(self.first.shape[1])


Reals = TypeVar("Reals", Floats, Singles)


class Folded(NamedTuple, Generic[Reals]):
    """Weights in the basis of parities, for Q quads, or what belongs to each of them, as a gradient.

    ``first (4, Q, C1)`` and ``second (4, C1, C2)`` have the parity first and multiply from the right; a quarter in them
    undoes the factor of two butterflies.  ``read2 (4, C2)``, ``read1 (4, C1)``, ``direct (4, Q)``: the output first.
    """

    first: Reals
    second: Reals
    read2: Reals
    read1: Reals
    direct: Reals


def fold(choices: Choices, weights: Weights) -> Folded[Floats]:
    """Transform ``weights`` for the array of ``choices``."""
    places = taxel_index(choices)
    copies = np.bincount(places.ravel())[places]  # a taxel on a middle line has more than one place in its quad
    first, direct = (butterfly(to_quads(choices, taken) / copies) for taken in (weights.first, weights.direct))
    second = butterfly(np.moveaxis(weights.second, 0, -1))
    return Folded(
        first=np.ascontiguousarray(first.transpose(2, 1, 0)) / MIRRORS,
        second=np.ascontiguousarray(second.transpose(2, 1, 0)) / MIRRORS,
        read2=weights.read2,
        read1=weights.read1,
        direct=np.stack([direct[output, :, parity] for output, parity in enumerate(READ)]),
    )


class Network:
    """The network of one sensor.

    Raises ``ValueError`` that starts with ``first:`` for ``weights`` of another number of taxels.
    """

    def __init__(self, sensor: SensorArray, weights: Weights) -> None:
        if weights.taxels != sensor.taxels:
            raise ValueError(f"first: {sensor.taxels} taxels are needed, got {weights.taxels}")
        self.sensor = sensor
        self._choices = Choices(sensor, architecture=SERIAL)  # the butterfly reads the array alone
        self._folded = fold(self._choices, weights)

    @property
    def products(self) -> int:
        """Products of real numbers that a frame takes."""
        return sum(matrix.size for matrix in self._folded)

    def __call__(self, n: Floats) -> Floats:
        """Outputs ``(frames, 4)`` in N for the normal forces ``n (frames, m)`` in N, compression negative."""
        return outputs(self._folded, np.moveaxis(butterfly(to_quads(self._choices, n)), -1, 0))


def outputs(folded: Folded[Reals], inputs: Reals) -> Reals:
    """Outputs ``(k, 4)`` of the network for the parities ``inputs (4, k, Q)`` of frames."""
    h1, _ = layer(inputs, folded.first)
    h2, _ = layer(h1, folded.second)
    return read(folded, h2, h1, inputs)


def layer(parities: Reals, matrices: Reals) -> tuple[Reals, Bools]:
    """Parities ``(4, k, C)`` of a layer from those of its input, and where its units at the mirrors are above zero."""
    mirrors = butterfly_first(parities @ matrices)
    return butterfly_first(np.maximum(mirrors, 0)), mirrors > 0


def read(folded: Folded[Reals], h2: Reals, h1: Reals, inputs: Reals) -> Reals:
    """Outputs ``(k, 4)`` from the parities of both layers and of the input."""
    terms = (h2, folded.read2), (h1, folded.read1), (inputs, folded.direct)
    return np.stack([sum(h[parity] @ rows[o] for h, rows in terms) for o, parity in enumerate(READ)], axis=1)


def butterfly_first(parities: Reals) -> Reals:
    """The butterfly over the first axis, between parities and mirrors, as one small product."""
    signs = HADAMARD.astype(parities.dtype)
    return np.asarray((signs @ parities.reshape(MIRRORS, -1)).reshape(parities.shape))


class Learned:
    """The estimator of one sensor.

    ``threshold`` is the uncertainty over the normal force above which a frame is ``IMPLAUSIBLE``, as one that pulls is;
    ``contact_threshold`` in Pa is ``Tfra``'s.  Frames without traction are estimated as all
    others.  There is no sweep: ``sweep_index`` is -1.

    Raises ``ValueError`` that starts with the name of what is wrong.
    """

    def __init__(self, sensor: SensorArray, weights: Weights, threshold: float, contact_threshold: float = 0.0) -> None:
        if not threshold > 0:
            raise ValueError(f"threshold: more than zero is needed, got {threshold}")
        if not contact_threshold >= 0:
            raise ValueError(f"contact_threshold: zero or more is needed, got {contact_threshold}")
        self.sensor = sensor
        self.threshold = threshold
        self.contact_threshold = contact_threshold
        self._network = Network(sensor, weights)

    def __call__(self, frames: npt.ArrayLike) -> Result:
        """Forces of ``frames (n, rows, columns)`` in Pa; raises ``ValueError`` for a wrong shape or NaN."""
        b = check_frames(self.sensor, frames).reshape(-1, self.sensor.taxels)
        contact = in_contact(b, self.contact_threshold)
        scaled, exponent = unit_scaled(np.where(contact[:, None], b, 0.0))
        outputs = self._network(scaled * self.sensor.taxel_area)
        unit, uncertainty = outputs[:, :3], np.maximum(outputs[:, 3], 0.0)
        spreads = spread(self.sensor, scaled, unit)
        left = residual(self.sensor, scaled, spreads)
        phi, still = direction_deg(unit)
        implausible = (uncertainty > self.threshold * np.abs(unit[:, 2])) | (unit[:, 2] >= 0)
        status = (
            np.where(contact, 0, Status.NO_CONTACT)
            | np.where(contact & still, Status.NO_DIRECTION, 0)
            | np.where(contact & implausible, Status.IMPLAUSIBLE, 0)
        ).astype(np.int64)
        mu = friction(unit)
        mu_x, mu_y = mu * np.cos(np.radians(phi)), mu * np.sin(np.radians(phi))
        forces = np.ldexp(spreads, exponent[:, None, None])
        return Result(
            forces=forces.reshape(len(b), 3, self.sensor.rows, self.sensor.columns),
            resultant=np.ldexp(unit, exponent[:, None]),
            phi_deg=phi,
            mu=mu,
            mu_x=mu_x,
            mu_y=mu_y,
            sweep_index=np.full(len(b), -1, dtype=np.int64),
            status=status,
            uncertainty=np.ldexp(uncertainty, exponent),
            threshold=self.threshold,
            residual=left,
        )
