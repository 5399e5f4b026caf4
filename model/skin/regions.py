"""The region of a contact: the taxels about its peak that are at least half as high."""

from typing import NamedTuple

import numpy as np
from scipy import ndimage

from tfra.model.arrays import Bools, Ints

_CROSS = np.array([[0, 1, 0], [1, 1, 1], [0, 1, 0]], dtype=np.bool_)[None]
"""A taxel and its four neighbours, in one frame."""

_WITHIN = np.concatenate([np.zeros_like(_CROSS), _CROSS, np.zeros_like(_CROSS)])
"""The same as the neighbourhood of three axes."""


class Span(NamedTuple):
    """Extent of regions along an axis, each ``(n,)``: first and last taxel, sum of the taxels' indices."""

    first: Ints
    last: Ints
    total: Ints


def regions(high: Bools, free: Bools, peak: Ints) -> tuple[Bools, Bools]:
    """The taxels of ``high`` and ``free`` that are connected to the ``peak``, and whether others cut them off.

    In: ``high`` and ``free (n, rows, columns)``, and for each frame the index ``peak (n,)`` of a taxel that is both.
    Out: the region, of the same shape, four neighbours being connected; and ``(n,)``, whether a neighbour of the region
    is high but not free.
    """
    labels, _ = ndimage.label(high & free, structure=_WITHIN)
    own = labels.reshape(len(peak), -1)[np.arange(len(peak)), peak]
    region = labels == own[:, None, None]
    around = ndimage.binary_dilation(region, structure=_CROSS)
    return region, (around & high & ~free).any(axis=(1, 2))


def grown(region: Bools, gap: int) -> Bools:
    """Taxels within ``gap`` taxels of ``region (n, rows, columns)`` along both axes."""
    return np.asarray(ndimage.maximum_filter(region, size=(1, 2 * gap + 1, 2 * gap + 1), mode="constant"))


def spans(region: Bools) -> tuple[Span, Span]:
    """Extent of each ``region (n, rows, columns)``, none of them empty, along its rows and along its columns."""
    return _span(region.sum(axis=2)), _span(region.sum(axis=1))


def _span(counts: Ints) -> Span:
    """Extent from the number of taxels at each index, ``(n, size)``."""
    size = counts.shape[1]
    touched = counts > 0
    return Span(touched.argmax(axis=1), size - 1 - touched[:, ::-1].argmax(axis=1), counts @ np.arange(size))
