"""The shapes of weights."""

import numpy as np
import pytest

from tests.model.learned.random_weights import random_weights
from tfra.model.learned.weights import NAMES, Weights

GOOD = random_weights(np.random.default_rng(0), 6, 3, 2)


def test_counts() -> None:
    assert GOOD.counts == (3, 2)
    assert GOOD.taxels == 6
    assert all(getattr(GOOD, name).dtype == np.float64 for name in NAMES)


@pytest.mark.parametrize(
    ("name", "shape"),
    [
        ("first", (3,)),
        ("first", (0, 6)),
        ("second", (2, 3)),
        ("second", (3, 2, 3)),
        ("second", (4, 2, 4)),
        ("read2", (4, 3)),
        ("read1", (3, 3)),
        ("direct", (4, 5)),
    ],
)
def test_another_shape(name: str, shape: tuple[int, ...]) -> None:
    with pytest.raises(ValueError, match=f"^{name}: "):
        Weights(**{key: np.zeros(shape) if key == name else getattr(GOOD, key) for key in NAMES})


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_not_finite(name: str, value: float) -> None:
    arrays = {key: getattr(GOOD, key).copy() for key in NAMES}
    arrays[name].flat[-1] = value
    with pytest.raises(ValueError, match=f"^{name}: a number is not finite"):
        Weights(**arrays)
