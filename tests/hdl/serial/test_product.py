"""Products of any word lengths are exact."""

import random

import pytest

from tfra.hdl.serial.product import DELAY, Product
from tfra.sim.harness import play


@pytest.mark.parametrize(("a_bits", "b_bits"), [(18, 18), (34, 21), (33, 19), (16, 16), (24, 24), (10, 12)])
def test_products_are_exact(a_bits, b_bits):
    rng = random.Random(a_bits * b_bits)
    pairs = [(a, b) for a in (-1 << (a_bits - 1), (1 << (a_bits - 1)) - 1) for b in (-1 << (b_bits - 1), -1, 0)]
    for _ in range(100):
        pairs.append((rng.randrange(-1 << a_bits, 1 << a_bits) >> 1, rng.randrange(-1 << b_bits, 1 << b_bits) >> 1))
    cycles = [{"a": a, "b": b} for a, b in pairs] + [{}] * DELAY
    record = play(Product(a_bits, b_bits, a_bits + b_bits), cycles, ["o"])
    assert [row["o"] for row in record[DELAY:]] == [a * b for a, b in pairs]
