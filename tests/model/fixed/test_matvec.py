"""Products against unbounded integers, where doubles are exact and where they are not."""

from fractions import Fraction
from itertools import product
from math import floor

import numpy as np
import pytest

from tfra.model.choices import FORMATS, Architecture, Formats
from tfra.model.cover.scenes import SENSORS
from tfra.model.fixed.matvec import matvec
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.fixed.tfra.operators import STACKS

LONGEST = Formats("longest", coefficient=27, operand=27, vector_fraction=16, force_fraction=4)
TOP = 1 << (LONGEST.operand - 1)


def make(formats, name="4×6, 5×3 mm, h 2 mm"):
    return TfraDesign(SENSORS[name], formats=formats, architecture=Architecture(4))


def half_up(value):
    return floor(value + Fraction(1, 2))


def exact(design, stack, vector):
    """Result quads of one ``vector (Q, 4)`` of Python integers that are multiplier words times a power of two."""
    quads = []
    for op in design.stacks[stack].operators:
        for rows in op.rows.tolist():
            sums = [sum(c * v[p ^ op.flip] for c, v in zip(rows[p], vector, strict=True)) for p in range(4)]
            quads.append([half_up(Fraction(s) / Fraction(2) ** op.fraction) for s in sums])
    return quads


def rounded(design, vector):
    """``vector (Q, 4)`` as the multiplier sees it: each parity's words cut to an operand, which fills its word."""
    bits, columns = design.formats.operand, []
    for column in vector.T.tolist():
        significant = max((v ^ (v >> 63)).bit_length() for v in column)
        unit = Fraction(2) ** (significant - bits + 1)
        limit = (1 << (bits - 1)) - 1
        columns.append([min(half_up(v / unit), limit) * unit for v in column])
    return list(zip(*columns, strict=True))


@pytest.mark.parametrize("stack", STACKS)
@pytest.mark.parametrize("formats", [*FORMATS.values(), LONGEST], ids=lambda formats: formats.name)
def test_any_vector(formats, stack):
    design, rng = make(formats), np.random.default_rng(1)
    for bits in (1, 8, 20, design.widths.vector - 1):
        vectors = rng.integers(-(1 << bits), 1 << bits, (3, design.quads, 4))
        vectors[0] = np.sign(vectors[0]) << bits - 1
        want = [exact(design, stack, rounded(design, vector)) for vector in vectors]
        assert matvec(design, stack, vectors).tolist() == want


def below_a_tie(row, shift):
    """Operand words with nearly the largest sum of their products with ``row``, one less than half of ``2^shift``."""
    step = np.argmax(row & 1)  # an odd coefficient reaches any remainder
    words = np.where(row < 0, -TOP, TOP - 1)
    words[step] -= np.sign(row[step]) << shift
    rest = int(((1 << (shift - 1)) - 1 - row @ words) % (1 << shift))
    words[step] += rest * pow(int(row[step]), -1, 1 << shift) % (1 << shift)
    return words


def hardest(design, op, row, parity):
    """A vector ``(Q, 4)`` of full length whose sum in ``row`` doubles would round to the next result."""
    significant = design.widths.vector - 1
    vector = np.zeros((design.quads, 4), dtype=np.int64)
    words = below_a_tie(row, op.fraction + design.formats.operand - 1 - significant)
    vector[:, parity ^ op.flip] = words << (significant - design.formats.operand + 1)
    return vector, int(row @ words)


@pytest.mark.parametrize("name", ["4×6, 5×3 mm, h 2 mm", "5×7, 3×3 mm, h 2 mm"])
def test_sums_beyond_doubles_are_exact(name):
    """The largest sums of every row, half of them odd ones beyond 2^53."""
    design, beyond = make(LONGEST, name), set()
    for stack in STACKS:
        for op in design.stacks[stack].operators:
            places = [(i, p) for i, p in product(range(op.quads), range(4)) if (op.rows[i, p] & 1).any()]
            hard = [hardest(design, op, op.rows[i, p], p) for i, p in places]
            vectors = np.array([vector for vector, _ in hard])
            got = matvec(design, stack, vectors)
            assert got.tolist() == [exact(design, stack, vector.tolist()) for vector in vectors]
            if any(float(total) != total for _, total in hard):
                beyond.add(op.name)
    assert beyond >= {"sums_n", "sums_b"}, "doubles would do"
