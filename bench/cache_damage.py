"""Every kind of damage to every entry of a cache, and what the next run makes of it.

``python -m bench.cache_damage`` verifies a small core with Icarus and with Verilator, and its gates, after each damage.
It prints what did not heal, and how long the check of an entry takes; exit code 1 if anything did not heal.
"""

from __future__ import annotations

import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from bench.damages import DAMAGES
from tfra.model.cache import _read
from tfra.model.design import Adc, Architecture, Design, Formats, Search
from tfra.model.fixed.pipeline import FixedTfra
from tfra.model.scenes import contact_codes
from tfra.model.scratch import discard
from tfra.model.sensor import SensorArray
from tfra.sim.netlist import synthesised
from tfra.sim.run import simulate

DESIGN = Design(
    SensorArray(2, 2, 4e-3, 4e-3, 3e-3),
    name="tiny",
    adc=Adc(6),
    search=Search(2),
    formats=Formats("short", coefficient=10, operand=10, vector_fraction=0, force_fraction=0),
    architecture=Architecture(mac_lanes=1),
)


def runs(cache: Path) -> list[int]:
    """Simulate the core with two simulators, and its gates; return how many words were right in each."""
    codes = contact_codes(DESIGN, 2, 1)
    expected = FixedTfra(DESIGN)(codes).words
    gates = synthesised(replace(DESIGN, target="ecp5"), "ecp5", cache)
    found = [
        simulate(DESIGN, codes, "icarus", build_dir=cache, expected=expected),
        simulate(DESIGN, codes, "verilator", build_dir=cache, expected=expected),
        simulate(DESIGN, codes, "icarus", build_dir=cache, expected=expected, core=gates),
    ]
    return [int((run.words == expected).sum()) for run in found]


def main() -> int:
    """Damage, run, compare."""
    with tempfile.TemporaryDirectory() as place:
        cache = Path(place)
        right = runs(cache)
        good = {path.name: path.read_bytes() for path in cache.iterdir()}
        times = {name: _time_of_check(cache / name) for name in good}
        for name, content in good.items():
            print(f"{name}: {len(content) / 1e6:.2f} MB, checked in {1e3 * times[name]:.2f} ms")
        cases = [(name, kind) for name in good for kind in DAMAGES]
        wrong = [f"{name}: {kind}" for name, kind in cases if not _heals(cache, name, DAMAGES[kind], good, right)]
    print(f"{len(DAMAGES)} kinds of damage to {len(good)} entries: {len(wrong)} did not heal", *wrong, sep="\n")
    return int(bool(wrong))


def _heals(
    cache: Path, name: str, damage: Callable[[Path], None], good: dict[str, bytes], right: list[int]
) -> bool:
    for path in cache.iterdir():
        discard(path)
    for each, content in good.items():
        (cache / each).write_bytes(content)
    damage(cache / name)
    if runs(cache) != right:
        return False
    return {path.name for path in cache.iterdir()} == set(good) and all(_read(cache / each) for each in good)


def _time_of_check(entry: Path) -> float:
    times = []
    for _ in range(20):
        start = time.perf_counter()
        _read(entry)
        times.append(time.perf_counter() - start)
    return min(times)


if __name__ == "__main__":
    sys.exit(main())
