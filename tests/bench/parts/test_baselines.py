"""A small block through synthesis, place and route, against its baseline and a corrupted one."""

import json

import pytest

from bench.parts.baseline import compare
from bench.parts.baselines import FOLDER, SUBJECTS, measure


@pytest.mark.long
def test_one_block_through_all_tools() -> None:
    """The CORDIC against its baseline, and against a corrupted one."""
    baselines = json.loads((FOLDER / "cordic.json").read_text())
    found = measure(SUBJECTS["cordic"])
    assert compare(found, baselines) == []
    ((version, known),) = baselines.items()
    known["resources"]["LUT"] = round(known["resources"]["LUT"] * 0.9)
    known["mhz"] *= 1.3
    worse = compare(found, {version: known})
    assert [line.partition(":")[0] for line in worse] == ["LUT", "Fmax"]
