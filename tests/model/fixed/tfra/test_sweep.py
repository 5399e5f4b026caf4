"""The integer sweep against the definition, with unbounded integers, one candidate at a time."""

import numpy as np
import pytest

from tests.model.cases import make_design
from tfra.model.cover.scenes import SENSORS
from tfra.model.fixed.tfra.sweep import sweep, sweep_unit, tolerance


def literal(design, stress, p, q, negative, exponent):
    """Index, B^z and B^xy of one frame by Eqs. 23-27 over Python integers."""
    steps, unit = design.search.steps, sweep_unit(design)
    b_z, b_xy = [], []
    for k in range(steps + 1):
        kappa = k - steps if negative else k
        x = [steps * int(pi) + kappa * int(qi) for pi, qi in zip(p, q, strict=True)]
        rest = [unit * int(b) - v for b, v in zip(stress, x, strict=True)]
        b_z.append(sum(v for v in x if v > 0))
        b_xy.append(abs(sum(v for v in rest if v > 0) - sum(unit * int(b) for b in stress if b > 0)))
    limit = min(b_z) + int(tolerance(design)[exponent])
    best = min((xy, k) for k, (z, xy) in enumerate(zip(b_z, b_xy, strict=True)) if z <= limit)
    return best[1], b_z, b_xy


@pytest.mark.parametrize("steps", [1, 7, 100])
@pytest.mark.parametrize("tol", [0.0, 0.37])
def test_random_frames(steps, tol):
    design = make_design(SENSORS["5×7, 3×3 mm, h 2 mm"], steps=steps, tolerance=tol)
    rng = np.random.default_rng(steps)
    count, m = 40, design.sensor.taxels
    stress = rng.integers(-8192, 8192, (count, m))
    scale = 2 ** rng.integers(0, 25, (count, 1))
    p, q = rng.integers(-9, 4, (count, m)) * scale, rng.integers(-9, 9, (count, m)) * scale
    negative, exponent = rng.random(count) < 0.5, rng.integers(0, 13, count)
    got = sweep(design, stress, p, q, negative, exponent)
    for i in range(count):
        index, b_z, b_xy = literal(design, stress[i], p[i], q[i], negative[i], exponent[i])
        assert got.b_z[i].tolist() == b_z
        assert got.b_xy[i].tolist() == b_xy
        assert got.index[i] == index


def chosen(stress, p, q, *, negative=False, tol=0.0, exponent=0, steps=4):
    design = make_design(SENSORS["4×6, 5×3 mm, h 2 mm"], steps=steps, tolerance=tol)
    rows = [np.resize(np.array(v), (1, 24)) for v in (stress, p, q)]
    return int(sweep(design, *rows, np.array([negative]), np.array([exponent])).index[0])


def test_ties_go_to_the_first_candidate_in_sweep_order():
    assert chosen([0], [0], [0]) == 0
    assert chosen([0], [0], [0], negative=True) == 0


def test_a_tolerance_widens_the_plateau():
    """B^z = 0, 0, 0, 50, 100 codes, B^xy falls: the further the tolerance reaches, the later the winner."""
    unit = 4 << 9  # one code, in p
    stress = [-100] * 23 + [300]
    falling = {"stress": stress, "p": [-110 * unit] * 23 + [-100 * unit], "q": [0] * 23 + [200 * unit]}
    first = chosen(**falling)
    wide = chosen(**falling, tol=50.0)
    assert (first, wide) == (2, 3)
    assert chosen(**falling, tol=25.0, exponent=1) == wide


def test_a_corrupted_sum_is_noticed():
    design = make_design(SENSORS["4×6, 5×3 mm, h 2 mm"], steps=4)
    rng = np.random.default_rng(0)
    stress, p, q = (rng.integers(-99, 99, (1, 24)) for _ in range(3))
    good = sweep(design, stress, p, q, np.array([False]), np.array([0]))
    p[0, 3] += 100
    bad = sweep(design, stress, p, q, np.array([False]), np.array([0]))
    assert (good.b_z != bad.b_z).any()
