"""Cycles and sizes of skins: the page tells the records, and they are those of the gateware of today."""

from dataclasses import replace

import numpy as np
import pytest

from bench.cycles import skin_cycles
from bench.parts import skins
from bench.publish import ROOT, stored
from tfra.hdl.skin.timing import SkinTiming
from tfra.model.skin.finding import Finding

PAGE = (ROOT / "docs" / "skins.md").read_text()


def test_the_page_tells_the_records() -> None:
    cycles = {int(side): {int(count): n for count, n in row.items()} for side, row in stored("skin_cycles").items()}
    assert skin_cycles.table(cycles) in PAGE
    assert skins.table(stored("skin_parts")["rows"]) in PAGE


@pytest.mark.parametrize("count", [1, 4, 16])
def test_frames_have_as_many_contacts_as_they_should(count: int) -> None:
    of = skin_cycles.skin(32)
    found, _ = of.find(np.stack([skin_cycles.frame(of, count)]))
    assert found.found.tolist() == [count]
    assert ((found.taxels >= 35) & (found.taxels <= 45)).all()


def test_counted_cycles_are_within_those_stated() -> None:
    """A contact more costs what a contact costs, and no frame takes more than its taxels, finding or forces."""
    for side, row in stored("skin_cycles").items():
        for count, cycles in row.items():
            whole = skin_cycles.skin(int(side))
            of = replace(whole, choices=Finding(most=int(count), threshold=whole.choices.threshold))
            stated = replace(SkinTiming.of(of), taxels=45)
            assert cycles <= stated.interval, (side, count)
            assert cycles >= max(int(side) ** 2, 0.95 * stated.forces), (side, count)


def test_placed_skins_have_the_cycles_of_today() -> None:
    for row in stored("skin_parts")["rows"]:
        whole = skin_cycles.skin(int(row["taxels"].split("×")[0]))
        timed = SkinTiming.of(replace(whole, choices=Finding(most=row["timing"]["contacts"])))
        assert row["timing"]["interval_cycles"] == timed.interval
