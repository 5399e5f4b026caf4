"""One-line warnings about the numbers of a recording before a tare changes them."""

from collections.abc import Iterator

import numpy as np

from tfra.model.arrays import Bools, Floats
from tfra.model.choices import Adc
from tfra.model.fixed.front_end import MOST_AVERAGED
from tfra.recordings.input import PASCALS, Input, codes_of

FRAMES = 8
"""Fewest frames in which a number that never changes says something."""

STEPS = 8
"""A number that never changes is told where half of those around it change by so many of the smallest steps there are:
far from a contact, codes without noise stay, too."""

LOAD, LOUD = 0.1, 0.02
"""Where numbers are 0 at rest, one that never changes while the load does, by the first share of the largest, is told
if it is above the second share of the largest magnitude."""

OUTLYING = 4.0
"""A taxel whose numbers in the tare are so many times as far apart as half of the taxels' were pressed in it."""

SATURATED = 0.01
"""Share of frames with a number at an end of the converter's range above which that is told."""

_SHOWN = 5

_PRINTED = 0.005
"""Error of a number with two decimals."""


def doubts(levels: Floats, rest: Floats | None, adc: Adc, given: Input, alive: Bools) -> Iterator[str]:
    """Yield warnings about ``levels (n, rows, columns)`` in the recording's unit, and about ``rest``, its tare.

    Only taxels that are ``alive (rows, columns)`` count.
    """
    yield from still(levels, alive, zero=rest is None and given.level_at_rest(adc.bits) == 0)
    if rest is not None:
        yield from tare_doubts(rest, alive, adc, given)
    if given.unit == "codes":
        yield from _ends(levels, alive, adc, given)


def still(levels: Floats, alive: Bools | None = None, *, zero: bool = True) -> Iterator[str]:
    """Yield a warning about taxels that never change, if there are any; ``zero``: numbers are 0 at rest."""
    constant = np.ptp(levels, axis=0) == 0
    constant &= True if alive is None else alive
    if len(levels) < FRAMES or not constant.any() or constant.all():
        return
    size = np.abs(levels)
    load = size.sum(axis=(1, 2))
    loud = size[0] > LOUD * size.max() if zero and np.ptp(load) > LOAD * load.max() else False
    places = np.argwhere(constant & (loud | (_around(np.ptp(levels, axis=0)) >= STEPS * _step(levels))))
    if not len(places):
        return
    some = ", ".join(f"({row}, {column}) {levels[0, row, column]:g}" for row, column in places[:_SHOWN])
    more = " ..." if len(places) > _SHOWN else ""
    row, column = places[0]
    who, are = ("taxel reads", "is it") if len(places) == 1 else ("taxels read", "are they")
    yield (
        f"{len(places)} {who} the same in all {len(levels)} frames, (row, column) {some}{more}: {are} dead? "
        f"Neighbours can stand in (--dead {row},{column})"
    )


def fractions(levels: Floats) -> Iterator[str]:
    """Yield a warning about codes with fractions that no mean of the core has."""
    most = 1 << MOST_AVERAGED
    odd = np.abs(levels - np.rint(levels * most) / most) > _PRINTED * (1 + 1e-6)
    if odd.any():
        means = f"no mean of 2, 4, ... {most} codes has"
        yield f"codes have fractions, as {levels[odd][0]:g}, that {means}: is the unit Pa or kPa? (--unit)"


def _around(values: Floats) -> Floats:
    """The median of the up to eight ``values (rows, columns)`` around each."""
    padded = np.pad(values, 1, constant_values=np.nan)
    rows, columns = values.shape
    offsets = [(i, j) for i in range(3) for j in range(3) if (i, j) != (1, 1)]
    return np.asarray(np.nanmedian([padded[i : i + rows, j : j + columns] for i, j in offsets], axis=0))


def _step(levels: Floats) -> float:
    """The smallest change from frame to frame."""
    change = np.abs(np.diff(levels, axis=0))
    return float(change.min(where=change > 0, initial=np.inf))


def tare_doubts(rest: Floats, alive: Bools, adc: Adc, given: Input) -> Iterator[str]:
    """Yield a warning about a tare in which something presses, or that is too noisy to be one."""
    if len(rest) < 2:
        return
    code = (given.pa_per_code or adc.lsb) if given.unit == "codes" else PASCALS[given.unit]
    least = adc.threshold * adc.lsb / code
    apart = np.where(alive, np.ptp(rest, axis=0), 0.0)
    usual = float(np.median(apart[alive]))
    row, column = np.unravel_index(int(apart.argmax()), apart.shape)
    if usual > least:
        yield (
            f"the numbers of a taxel are {usual:.4g} {given.unit} apart in the tare, more than a contact has to be "
            f"({least:.4g}): was the array at rest in all {len(rest)} frames of it?"
        )
    elif apart[row, column] > max(least, OUTLYING * usual):
        low, high = rest[:, row, column].min(), rest[:, row, column].max()
        yield (
            f"taxel ({row}, {column}) reads from {low:g} to {high:g} within the tare, others are {usual:.4g} apart: "
            f"did something press in its {len(rest)} frames?"
        )


def _ends(levels: Floats, alive: Bools, adc: Adc, given: Input) -> Iterator[str]:
    """Codes at an end of the converter's range; those of a unipolar converter rest at the lower one."""
    first, last = codes_of(given.coding, adc.bits)
    ends = (levels >= last) | ((levels <= first) & (given.level_at_rest(adc.bits) > first))
    ends &= alive & (np.ptp(levels, axis=0) > 0)
    frames = int(ends.any(axis=(1, 2)).sum())
    if frames > SATURATED * len(levels):
        taxels = int(ends.any(axis=0).sum())
        yield (
            f"{frames} of {len(levels)} frames and {taxels} of {ends[0].size} taxels read {first} or {last}, an end of "
            f"the converter's {adc.bits} bits: was it saturated (the forces would be too small)?"
        )
