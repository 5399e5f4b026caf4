"""Mirror folding: four mirror taxels to four parities and back, with additions alone.

A quad is four words.  In the taxel domain they are the taxels (i, j), (i, j'), (i', j), (i', j') with
i' = rows - 1 - i, j' = columns - 1 - j; in the parity domain EE, OX (odd in x), OY (odd in y), OO.  The same
butterfly, a 4-point Walsh-Hadamard transform, serves both ways: applied twice it multiplies by four.  On the
middle line of an odd count the two mirror taxels are the same one, and the odd parities vanish by themselves.
"""

from typing import TypeVar

import numpy as np
import numpy.typing as npt

from tfra.model.arrays import Floats, Ints
from tfra.model.choices import Choices

EE, OX, OY, OO = range(4)
"""Parities, and the places of mirror taxels, by their place in a quad: bit 0 mirrors x, bit 1 mirrors y."""

Numbers = TypeVar("Numbers", Ints, Floats)

HADAMARD = np.array([[1, 1, 1, 1], [1, -1, 1, -1], [1, 1, -1, -1], [1, -1, -1, 1]], dtype=np.int64)


def butterfly(quads: Numbers) -> Numbers:
    """Sums and differences over the last axis of ``(..., 4)`` words; two bits longer."""
    a, b, c, d = np.moveaxis(quads, -1, 0)
    return np.stack([a + b + c + d, a - b + c - d, a + b - c - d, a - b - c + d], axis=-1)


def taxel_index(choices: Choices) -> Ints:
    """Row-major taxel number of every word of a taxel-domain vector, shape ``(quads, 4)``."""
    rows, columns = choices.sensor.rows, choices.sensor.columns
    i, j = np.divmod(np.arange(choices.quads), choices.quad_columns)
    place = np.arange(4)
    row = np.where(place & 2, rows - 1 - i[:, None], i[:, None])
    column = np.where(place & 1, columns - 1 - j[:, None], j[:, None])
    return np.asarray(row * columns + column, dtype=np.int64)


def distinct(choices: Choices) -> npt.NDArray[np.bool_]:
    """True where a word of a taxel-domain vector is the first to hold its taxel, shape ``(quads, 4)``."""
    index = taxel_index(choices).ravel()
    first = np.zeros(index.size, dtype=np.bool_)
    first[np.unique(index, return_index=True)[1]] = True
    return first.reshape(-1, 4)


def to_quads(choices: Choices, taxels: Numbers) -> Numbers:
    """Row-major vectors ``(..., m)`` as taxel-domain quads ``(..., quads, 4)``."""
    return taxels[..., taxel_index(choices)]


def to_taxels(choices: Choices, quads: Numbers) -> Numbers:
    """Taxel-domain quads ``(..., quads, 4)`` as row-major vectors ``(..., m)``."""
    flat = quads.reshape(*quads.shape[:-2], 4 * choices.quads)
    first = np.unique(taxel_index(choices).ravel(), return_index=True)[1]
    return flat[..., first]
