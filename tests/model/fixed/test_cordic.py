"""The CORDIC against exact moduli and angles."""

import numpy as np
import pytest

from tests.model.cases import make_design
from tfra.model.choices import DIVISION_GUARD
from tfra.model.cover.scenes import SENSORS
from tfra.model.fixed.cordic import cordic, cordic_gain


@pytest.mark.parametrize("formats", ["standard", "wide"])
def test_angles_and_moduli_of_directions(formats):
    """To little more than one unit: a rotation, or a guard bit, fewer costs another quarter of one."""
    design = make_design(SENSORS["8×8, 2×2 mm, h 3 mm"], formats)
    operand = design.formats.operand
    turn = np.random.default_rng(1).random(100_000) * 2 * np.pi
    length = (1 << (operand - 1)) - 1
    x, y = (np.rint(length * v).astype(np.int64) << DIVISION_GUARD for v in (np.cos(turn), np.sin(turn)))
    modulus, angle = cordic(design, x, y)
    error = angle - np.arctan2(y, x) / (2 * np.pi) * 2**operand
    half = 2.0 ** (operand - 1)
    assert np.abs((error + half) % (2 * half) - half).max() < 1.1
    np.testing.assert_allclose(modulus, cordic_gain(design) * np.hypot(x, y), rtol=1.1 * 2.0**-operand)


def test_axes():
    design = make_design(SENSORS["8×8, 2×2 mm, h 3 mm"])
    one, quarter = 1 << 20, 1 << (design.formats.operand - 2)
    _, angle = cordic(design, np.array([one, 0, -one, 0]), np.array([0, one, 0, -one]))
    assert angle.tolist() == [0, quarter, 2 * quarter, 3 * quarter]
