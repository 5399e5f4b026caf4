"""A placement that can be routed: the best of some, where how well one ends is chance."""

import json
import os
import re
from collections import deque
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from itertools import islice
from pathlib import Path

from tfra.synth.tools import run

_MOST, _ENOUGH, _SEEDS = 8, 0.93, 100
"""Placements of a seed at most; the share of the aim that nextpnr expects of one that is good enough, since routing
makes slow paths faster; how far apart the placements' seeds are, above the number of seeds."""
_SETTINGS = ("router", "target_freq", "seed")
"""What a placed netlist would tell nextpnr instead of its options."""
_CONSTANT = "$PACKER_"
"""How nextpnr's names of constant nets begin: one of them is the write clock of memories that are never written."""


def place(program: str, words: Sequence[str], directory: Path, seed: int, clock_mhz: float, *, several: bool) -> str:
    """Place with nextpnr's options ``words``, once or ``several`` times, and return the file of the placed netlist.

    Several end with the first of which nextpnr expects ``_ENOUGH`` of ``clock_mhz``; if none is, the best is taken.
    First is meant in the order of seeds, not of time, so that the number of processors changes nothing.  Raises
    :class:`tools.ToolError`.
    """
    words = [*words, "--freq", str(clock_mhz), "--no-route"]

    def once(turn: int) -> tuple[float, str]:
        file, log = f"placed{turn}.json", f"seed{seed}.place{turn}.log"
        run(program, [*words, "--write", file, "--seed", str(seed + _SEEDS * turn)], directory, log)
        return expected_mhz((directory / log).read_text(errors="replace")), file

    number, found = _MOST if several else 1, list[tuple[float, str]]()
    turns, processors = iter(range(number)), os.cpu_count() or 1
    with ThreadPoolExecutor(processors) as pool:
        running = deque(pool.submit(once, turn) for turn in islice(turns, processors))
        while running:
            found.append(running.popleft().result())
            if found[-1][0] >= _ENOUGH * clock_mhz:
                break
            running.extend(pool.submit(once, turn) for turn in islice(turns, 1))
    _, best = max(found)
    for file in {f"placed{turn}.json" for turn in range(number)} - {best}:
        (directory / file).unlink(missing_ok=True)
    _forget_settings(directory / best)
    return best


def expected_mhz(log: str) -> float:
    """The frequency that nextpnr's ``log`` of a placement ends with; 0 where it knows no clock."""
    found = re.findall(r"Max frequency for clock\s+'([^']+)': ([\d.]+) MHz", log)
    return [0.0, *(float(mhz) for clock, mhz in found if not is_constant(clock))][-1]


def is_constant(clock: str) -> bool:
    """Whether nextpnr takes a constant net for this ``clock``."""
    return clock.startswith(_CONSTANT)


def _forget_settings(placed: Path) -> None:
    """Leave ``_SETTINGS`` out of a placed netlist."""
    netlist = json.loads(placed.read_text())
    for module in netlist["modules"].values():
        for setting in _SETTINGS:
            module.get("settings", {}).pop(setting, None)
    placed.write_text(json.dumps(netlist))
