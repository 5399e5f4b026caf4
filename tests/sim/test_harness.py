"""The harness of the block tests shows a block's signals where one wants to look at them."""

from pathlib import Path

from tfra.hdl.lib.butterfly import Butterfly
from tfra.sim.harness import run


def test_waves_of_a_block(tmp_path: Path) -> None:
    quads = [[1, 2, 3, 4], [5, -6, 7, -8]]
    seen = run(Butterfly(8), {"i": quads}, {"o": 2}, vcd=tmp_path / "fold.vcd")
    assert seen.values["o"][0] == [10, -2, -4, 0]
    text = (tmp_path / "fold.vcd").read_text()
    assert "$enddefinitions" in text
    assert " i__valid " in text
