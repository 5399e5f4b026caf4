"""Place and route by nextpnr in two runs: the best of some placements, and its routing.

Whoever calls says how nextpnr is run.  It needs Python alone: packages have a copy, which their ``place.py`` uses.
"""

import json
import os
import re
from collections import deque
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from itertools import islice
from pathlib import Path

Run = Callable[[Sequence[str], str], None]
"""Runs nextpnr with arguments, and keeps its output in the file of a name."""

_MOST, _ENOUGH, _SEEDS = 8, 0.93, 100
"""Placements of a seed at most; the share of the aim that nextpnr expects of one that is good enough, since routing
makes slow paths faster; how far apart the placements' seeds are, above the number of seeds."""
_FREE, _SITE = "free.json", "BEL"
"""The netlist without sites, and the attribute that is a cell's site."""
_SETTINGS = ("router", "target_freq", "seed")
"""What a placed netlist would tell nextpnr instead of its options."""
_CONSTANT = "$PACKER_"
"""How nextpnr's names of constant nets begin: one of them is the write clock of memories that are never written."""


def place(
    run: Run,
    words: Sequence[str],
    netlist: str,
    directory: Path,
    seed: int,
    clock_mhz: float,
    *,
    free: Sequence[str] = (),
    several: bool = False,
) -> str:
    """Place the file ``netlist`` with nextpnr's options ``words``, and return the file of the placed netlist.

    Once or ``several`` times; with ``free``, options of another placer, once with either, or in turns.  That one
    begins, and hard blocks have no sites for it.  The first is taken of which nextpnr expects ``_ENOUGH`` of
    ``clock_mhz``, else the best.  First is meant in the order of seeds, not of time, so that the number of processors
    changes nothing.
    """
    words = [*words, "--freq", str(clock_mhz), "--no-route"]
    if free:
        without = json.loads((directory / netlist).read_text())
        for cell in (cell for module in without["modules"].values() for cell in module["cells"].values()):
            cell["attributes"].pop(_SITE, None)
        (directory / _FREE).write_text(json.dumps(without))

    def once(turn: int) -> tuple[float, str]:
        file, log = f"placed{turn}.json", f"seed{seed}.place{turn}.log"
        more = ["--json", netlist] if turn % 2 or not free else [*free, "--json", _FREE]
        more += ["--write", file, "--seed", str(seed + _SEEDS * turn)]
        run([*words, *more], log)
        return expected_mhz((directory / log).read_text(errors="replace")), file

    number, found = _MOST if several else 1 + bool(free), list[tuple[float, str]]()
    turns, processors = iter(range(number)), os.cpu_count() or 1
    with ThreadPoolExecutor(processors) as pool:
        running = deque(pool.submit(once, turn) for turn in islice(turns, processors))
        while running:
            found.append(running.popleft().result())
            if found[-1][0] >= _ENOUGH * clock_mhz:
                break
            running.extend(pool.submit(once, turn) for turn in islice(turns, 1))
    _, best = max(found)
    for file in {_FREE, *(f"placed{turn}.json" for turn in range(number))} - {best}:
        (directory / file).unlink(missing_ok=True)
    _forget_settings(directory / best)
    return best


def _forget_settings(placed: Path) -> None:
    """Leave ``_SETTINGS`` out of a placed netlist."""
    netlist = json.loads(placed.read_text())
    for module in netlist["modules"].values():
        for setting in _SETTINGS:
            module.get("settings", {}).pop(setting, None)
    placed.write_text(json.dumps(netlist))


def route(run: Run, words: Sequence[str], log: str, clock_mhz: float) -> None:
    """Route a placed netlist with nextpnr's options ``words``."""
    run([*words, "--no-pack", "--no-place", "--freq", str(clock_mhz)], log)


def expected_mhz(log: str) -> float:
    """The frequency that nextpnr's ``log`` of a placement ends with; 0 where it knows no clock."""
    found = re.findall(r"Max frequency for clock\s+'([^']+)': ([\d.]+) MHz", log)
    return [0.0, *(float(mhz) for clock, mhz in found if not is_constant(clock))][-1]


def is_constant(clock: str) -> bool:
    """Whether nextpnr takes a constant net for this ``clock``."""
    return clock.startswith(_CONSTANT)
