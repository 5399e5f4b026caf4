"""The data memory's map and initial contents, and the image of the coefficient store."""

import numpy as np

from tfra.hdl.serial.isa import ADDRESS_BITS
from tfra.hdl.serial.sizes import STORE_DEPTH, lane_count
from tfra.model.arrays import Ints
from tfra.model.fixed.coefficients import Operator
from tfra.model.fixed.design import Design


class MemoryMap:
    """Addresses of the data memory, allocated in order; constants are in its initial contents.

    Vectors are stored parity by parity; maps of taxels row-major.  A subclass has the vectors and maps of an estimator.
    The operands come first: the multiplier lanes read them from a copy of the memory's lowest ``operands`` words.
    """

    operands: int

    def __init__(self) -> None:
        self.contents: dict[int, int] = {}
        self._constants: dict[tuple[int, ...], int] = {}
        self._scalars: dict[str, int] = {}
        self.end = 0  # words reserved so far

    def reserve(self, words: int) -> int:
        """Address of ``words`` words reserved for the caller.

        Raises ``ValueError`` when the memory is full.
        """
        start, self.end = self.end, self.end + words
        if self.end > 1 << ADDRESS_BITS:
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
        return [self.contents.get(address, 0) for address in range(self.end)]


def operators(design: Design) -> list[Operator]:
    """All operators in the order of the coefficient store: stack by stack."""
    return [operator for stack in design.stacks.values() for operator in stack.operators]


def operator_of(design: Design, name: str) -> Operator:
    """The operator called ``name``."""
    return next(operator for operator in operators(design) if operator.name == name)


def length(operator: Operator) -> int:
    """Products of a row: quads of the operand."""
    return int(operator.rows.shape[-1])


def lengths(design: Design) -> tuple[int, ...]:
    """The lengths of all operators, each once, in the order of the stacks; MAC names one by its place."""
    return tuple(dict.fromkeys(length(operator) for operator in operators(design)))


def groups(design: Design, operator: Operator) -> int:
    """Groups of rows that are computed at a time, for each parity of an operator's results."""
    return -(-operator.quads // lane_count(design))


def padded(design: Design, name: str) -> int:
    """Result quads of the operator ``name`` with those of lanes without a row: whole groups."""
    return groups(design, operator_of(design, name)) * lane_count(design)


def bases(design: Design) -> dict[str, int]:
    """First address of every operator's coefficients, by name."""
    addresses, start = {}, 0
    for operator in operators(design):
        addresses[operator.name] = start
        start += 4 * groups(design, operator) * length(operator)
    return addresses


def store_image(design: Design) -> Ints:
    """Coefficients ``(depth, lanes)`` in the order in which they are loaded and read.

    For every operator, stack by stack, every parity of its results, every group of ``lanes`` result quads: a word for
    each quad of the operand, with one coefficient of every quad of the group.  Quads past an operator's last are zero.

    Raises ``ValueError`` when they do not fit the store.
    """
    lanes, parts = lane_count(design), []
    for operator in operators(design):
        rows = np.zeros((groups(design, operator) * lanes, 4, length(operator)), dtype=np.int64)
        rows[: operator.quads] = operator.rows
        parts.append(rows.reshape(-1, lanes, 4, length(operator)).transpose(2, 0, 3, 1).reshape(-1, lanes))
    image = np.concatenate(parts)
    if len(image) > STORE_DEPTH:
        reason = f"the serial core's store holds {STORE_DEPTH} words of coefficients, {len(image)} are needed"
        raise ValueError(f"architecture.kind: {reason}")
    return image
