"""What a real array adds to a frame: spread of gains, a dead taxel, a common offset, noise.

Offsets that differ from taxel to taxel can't be told from noise in a single frame, so both are one white term.
"""

from __future__ import annotations

import numpy as np

from tfra.train.simulator import Singles

GAIN, GAINED = 0.05, 0.5
"""Largest standard deviation of the gains, and the share of frames that have any."""

DEAD = 0.1
"""Share of frames with a taxel that reads zero."""

OFFSET, SHIFTED = 0.01, 0.5
"""Largest common offset over the frame's peak, and the share of frames that have one."""

QUIET, LOUD = 3e-4, 1e-2
"""Limits of the noise's standard deviation over the peak, distributed evenly in its logarithm."""

UNTARED, UNTARED_SHARE = 5e-3, 0.1
"""Largest standard deviation of the taxels' own offsets over the peak, and the share of frames that have them."""


def augmented(frames: Singles, rng: np.random.Generator) -> Singles:
    """Return ``frames (n, m)`` as an imperfect array would report them."""
    count, taxels = frames.shape
    peak = np.abs(frames).max(axis=1, keepdims=True)
    gain = _some(rng, count, GAINED) * rng.uniform(0.0, GAIN, (count, 1)).astype(np.float32)
    found = frames * (1 + gain * rng.standard_normal(frames.shape, np.float32))
    own = _some(rng, count, UNTARED_SHARE) * rng.uniform(0.0, UNTARED, (count, 1))
    white = np.hypot(np.exp(rng.uniform(np.log(QUIET), np.log(LOUD), (count, 1))), own)
    shift = _some(rng, count, SHIFTED) * rng.uniform(-OFFSET, OFFSET, (count, 1))
    found += peak * shift.astype(np.float32)
    found += (peak * white.astype(np.float32)) * rng.standard_normal(frames.shape, np.float32)
    dead = np.flatnonzero(rng.random(count) < DEAD)
    found[dead, rng.integers(taxels, size=len(dead))] = 0.0
    return np.asarray(found)


def _some(rng: np.random.Generator, count: int, share: float) -> Singles:
    """1 in a share of the frames, else 0: ``(count, 1)``."""
    return (rng.random((count, 1)) < share).astype(np.float32)
