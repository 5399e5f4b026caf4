"""The data memory's map and initial contents, and the image of the coefficient store."""

from __future__ import annotations

import numpy as np

from tfra.hdl.serial.isa import ADDRESS_BITS
from tfra.hdl.serial.sizes import STORE_DEPTH, sizes, sweep_bits
from tfra.model.arrays import Ints
from tfra.model.fixed.coefficients import Operator
from tfra.model.fixed.design import Design
from tfra.model.fixed.tfra.operators import STACKS


class MemoryMap:
    """Addresses of the data memory, allocated in order; constants are in its initial contents.

    Vectors are stored parity by parity, Q words each; maps of taxels row-major.  The operand vectors come first: the
    multiplier lanes read them from a copy of the memory's lowest ``operands`` words.  Words that are no longer used are
    reused:

    ===============  =======================================  =========================================
    words            hold first                               hold then
    ===============  =======================================  =========================================
    ``operand``      the operand of the current product
    ``weights``      n as an operand
    ``stress``       codes, normalised in place
    ``d``            b, then d0, e0 and d                     taxels of a plane of forces
    ``independent``  d_ind, then e1                           ``p``, by taxels
    ``result``       C33^-1 b, then n; normal product of e0   q, by taxels; A-dagger d of a plane
    ``dependent``    d_dep, then the normal product of e1     ``tables`` of the sweep
    ``g``            C33 n                                    ``tables``
    ``sums_b``       sums of A-dagger b                       ``tables``
    ``sums_n``       sums of n, then A_pq
    ===============  =======================================  =========================================
    """

    def __init__(self, design: Design) -> None:
        self.contents: dict[int, int] = {}
        self._constants: dict[tuple[int, ...], int] = {}
        self._scalars: dict[str, int] = {}
        self._end = 0
        vector, spill = 4 * design.quads, sizes(design).lanes - 1
        taxels, table = design.sensor.taxels, 1 << sweep_bits(design)  # a division's quotient can't leave a table
        self.operand, self.weights = self.reserve(vector), self.reserve(vector)
        self.operands = self._end
        self.stress = self.reserve(taxels)
        self.d, self.p = self.reserve(vector), self.reserve(max(vector + spill, taxels))
        self.independent = self.p
        self.result = self.reserve(max(vector + spill, taxels))
        tables = self._end
        self.dependent, self.g = self.reserve(vector + spill), self.reserve(vector + spill)
        sums_b, sums_n = (4 * stride(design, operator_of(design, name)) for name in ("sums_b", "sums_n"))
        self.sums_b = self.reserve(sums_b)
        self.reserve(max(0, tables + 4 * table - self._end))
        self.tables = [tables + number * table for number in range(4)]
        self.sums_n = self.reserve(sums_n)

    def reserve(self, words: int) -> int:
        """Address of ``words`` words reserved for the caller.

        Raises ``ValueError`` when the memory is full.
        """
        start, self._end = self._end, self._end + words
        if self._end > 1 << ADDRESS_BITS:
            raise ValueError(f"architecture.kind: the serial core holds {1 << ADDRESS_BITS} words, more are needed")
        return start

    def scalar(self, name: str, words: int = 1) -> int:
        """Address of the ``words`` words called ``name``."""
        if name not in self._scalars:
            self._scalars[name] = self.reserve(words)
        return self._scalars[name]

    def constants(self, *values: int) -> int:
        """Address of ``values``, which nothing overwrites."""
        if values not in self._constants:
            start = self._constants[values] = self.reserve(len(values))
            self.contents |= dict(enumerate(values, start))
        return self._constants[values]

    @property
    def names(self) -> dict[int, str]:
        """Names of single words, by address; a constant's is its value after ``#``."""
        scalars = sorted((address, name) for name, address in self._scalars.items())
        return dict(scalars) | {address: f"#{value}" for address, value in self.contents.items()}

    @property
    def words(self) -> list[int]:
        """Initial contents of the memory."""
        return [self.contents.get(address, 0) for address in range(self._end)]


def groups(design: Design, operator: Operator) -> int:
    """Groups of rows that are computed at a time, for each parity of an operator's results."""
    return -(-operator.quads // sizes(design).lanes)


def operator_of(design: Design, name: str) -> Operator:
    """The operator called ``name``."""
    return next(o for stack in STACKS for o in design.stacks[stack].operators if o.name == name)


def stride(design: Design, operator: Operator) -> int:
    """Words from one parity of an operator's results to the next; sums, which are few, are not packed."""
    return operator.quads if not operator.name.startswith("sums") else groups(design, operator) * sizes(design).lanes


def bases(design: Design) -> dict[str, int]:
    """First address of every operator's coefficients, by name."""
    found, start = {}, 0
    for name in STACKS:
        for operator in design.stacks[name].operators:
            found[operator.name] = start
            start += 4 * groups(design, operator) * design.quads
    return found


def store_image(design: Design) -> Ints:
    """Coefficients ``(depth, lanes)`` in the order in which they are loaded and read.

    For every operator in the order of ``STACKS``, every parity of its results, every group of ``lanes`` result quads:
    Q words, each with one coefficient of every quad of the group.  Quads past an operator's last are zero.

    Raises ``ValueError`` when they do not fit the store.
    """
    lanes, parts = sizes(design).lanes, []
    for name in STACKS:
        for operator in design.stacks[name].operators:
            rows = np.zeros((groups(design, operator) * lanes, 4, design.quads), dtype=np.int64)
            rows[: operator.quads] = operator.rows
            parts.append(rows.reshape(-1, lanes, 4, design.quads).transpose(2, 0, 3, 1).reshape(-1, lanes))
    image = np.concatenate(parts)
    if len(image) > STORE_DEPTH:
        reason = f"the serial core's store holds {STORE_DEPTH} words of coefficients, {len(image)} are needed"
        raise ValueError(f"architecture.kind: {reason}")
    return image
