"""Imperfections of a real array: spread of gains, a dead taxel, a common offset, noise, and broken taxels.

Offsets that differ from taxel to taxel can't be told from noise in a single frame, so both are one white term.
"""

import numpy as np
import numpy.typing as npt

from tfra.model.arrays import Ints, Singles

GAIN, GAINED = 0.03, 0.2
"""Largest standard deviation of the gains, and the share of frames that have any."""

DEAD = 0.04
"""Share of frames with a taxel that reads zero."""

OFFSET, SHIFTED = 0.01, 0.4
"""Largest common offset over the frame's peak, and the share of frames that have one."""

QUIET, LOUD = 1e-4, 1e-2
"""Limits of the noise's standard deviation over the peak, distributed evenly in its logarithm."""

UNTARED, UNTARED_SHARE = 5e-3, 0.03
"""Largest standard deviation of the taxels' own offsets over the peak, and the share of frames that have them."""

BROKEN = 0.05
"""Share of frames whose most pressed taxel is dead, or any taxel stuck at a value up to the peak, half of each."""


def augmented(
    frames: Singles, peak: Singles, rng: np.random.Generator, gain_error: Singles | None = None
) -> Singles:
    """Return ``frames (n, m)`` as an imperfect array would report them; ``peak (n, 1)`` is the largest magnitude.

    ``gain_error (m,)``: standard deviations of the taxels' gains in every frame, where they are known.
    """
    count, taxels = frames.shape
    if gain_error is None:
        gain = _some(rng, count, GAINED) * rng.uniform(0.0, GAIN, (count, 1)).astype(np.float32)
    else:
        gain = gain_error
    own = _some(rng, count, UNTARED_SHARE) * rng.uniform(0.0, UNTARED, (count, 1))
    white = np.hypot(np.exp(rng.uniform(np.log(QUIET), np.log(LOUD), (count, 1))), own)
    shift = _some(rng, count, SHIFTED) * rng.uniform(-OFFSET, OFFSET, (count, 1))
    deviation = np.sqrt((frames * gain) ** 2 + (peak * white.astype(np.float32)) ** 2)  # both are normal
    noisy = frames + peak * shift.astype(np.float32) + deviation * rng.standard_normal(frames.shape, np.float32)
    dead = np.flatnonzero(rng.random(count) < DEAD)
    noisy[dead, rng.integers(taxels, size=len(dead))] = 0.0
    return np.asarray(noisy)


def broken(frames: Singles, rng: np.random.Generator, dead: Ints | tuple[()] = ()) -> npt.NDArray[np.intp]:
    """Break a taxel that is not among the ``dead`` in some of ``frames (n, m)``, in place; return which."""
    alive = np.delete(np.arange(frames.shape[1]), dead)
    which = np.flatnonzero(rng.random(len(frames)) < BROKEN)
    magnitudes = np.abs(frames[which])
    stuck = rng.random(len(which)) < 0.5
    taxel = np.where(stuck, alive[rng.integers(len(alive), size=len(which))], magnitudes.argmax(axis=1))
    frames[which, taxel] = magnitudes.max(axis=1) * rng.uniform(-1.0, 1.0, len(which)) * stuck
    return which


def _some(rng: np.random.Generator, count: int, share: float) -> Singles:
    """1 in a share of the frames, else 0: ``(count, 1)``."""
    return (rng.random((count, 1)) < share).astype(np.float32)
