"""Growth is counted as the model counts, and the wall stands where the memory is full."""

import pytest

from bench.large import growth


@pytest.mark.parametrize("size", [4, 5, 8])
def test_bits_by_hand_are_the_models(size):
    assert growth.bits(size) == growth.square(size, 4).coefficient_bits


@pytest.mark.parametrize("blocks", growth.DEVICES.values())
def test_one_taxel_more_does_not_fit(blocks):
    size, room = growth.largest(blocks), blocks * growth.WORDS * growth.WORD_BITS
    assert growth.bits(size) <= room < growth.bits(size + 1)


@pytest.mark.long
def test_everything_grows():
    rows = [growth.measure(size, 16) for size in (4, 6, 8)]
    for key in ("products", "latency", "interval"):
        values = [row[key] for row in rows]
        assert values == sorted(set(values)), key
    assert rows[-1]["bits"] <= rows[-1]["blocks"] * growth.WORDS * growth.WORD_BITS
    assert len({line.count("|") for line in growth.table(rows).splitlines()}) == 1
    rows[0]["estimated"] = {"luts": 12345, "blocks": 7}
    assert "| 12,345, 7 |" in growth.table(rows)
    assert len(growth.limit_table().splitlines()) == 2 + len(growth.DEVICES)
