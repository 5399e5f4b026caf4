"""Frames that the tests of generated code send to a skin."""

from collections.abc import Iterator

import numpy as np

from tfra.model.arrays import Ints
from tfra.model.skin.finding import THRESHOLD_FRACTION
from tfra.model.skin.skin import Skin
from tfra.model.skin.smoothing import GAIN

_SEED = 1
_CONES = 12
"""Contacts of a recorded frame."""
_FRAMES = 3
"""Such frames."""


def recorded(skin: Skin) -> Ints:
    """Codes of the test's frames ``(n, rows, columns)``: contacts, none, all pressed, level peaks, some at a limit."""
    half = 1 << (skin.adc.bits - 1)
    shape = (skin.sensor.rows, skin.sensor.columns)
    rows, columns = np.indices(shape)
    apart = max(4, skin.choices.gap + 2)
    pairs = (rows % apart == 0) & (columns % apart < 2)
    single = pairs & (columns % apart == 0)
    # A single taxel is smoothed to four times its code.
    least = max(-(-half * skin.choices.word >> THRESHOLD_FRACTION), GAIN // 4 * skin.adc.threshold)
    some = np.resize([half, least, least - 1], np.count_nonzero(single))
    limit = np.zeros(shape, dtype=np.int64)
    limit[single] = -some
    none = np.zeros(shape, dtype=np.int64)
    return np.stack([*_cones(skin), none, none - half, np.where(pairs, -half, 0), limit])


def _cones(skin: Skin) -> Iterator[Ints]:
    """Frames of contacts of any height and width, some of which touch, with traction around and noise."""
    rng = np.random.default_rng(_SEED)
    top = (1 << (skin.adc.bits - 1)) - 1
    shape = (skin.sensor.rows, skin.sensor.columns)
    for _ in range(_FRAMES):
        codes = rng.integers(-top // 100, top // 20, shape)
        for height in top // 2 ** rng.integers(0, 6, _CONES):
            row, column = rng.integers(0, shape)
            far = np.hypot(*(np.indices(shape) - np.array([row, column])[:, None, None]))
            cone = height * np.maximum(0, 1 - far / rng.integers(1, 6))
            codes = np.minimum(codes, -np.rint(cone).astype(np.int64))
        yield codes
