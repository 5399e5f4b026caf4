"""Every kind of damage to every entry of a cache, and the result of the next run.

A small core is simulated after each damage, and every word compared; ``python -m bench.abuse.abuse damage`` publishes
it.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from bench.abuse.damages import DAMAGES
from tfra.model.choices import Adc, Architecture, Formats, Search
from tfra.model.cover.scenes import contact_codes
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.fixed.tfra.pipeline import FixedTfra
from tfra.model.sensor import SensorArray
from tfra.runtime.cache import _read
from tfra.runtime.scratch import discard
from tfra.sim.run import simulate

DESIGN = TfraDesign(
    SensorArray(2, 2, 4e-3, 4e-3, 3e-3),
    name="tiny",
    adc=Adc(6),
    search=Search(2),
    formats=Formats("short", coefficient=10, operand=10, vector_fraction=0, force_fraction=0),
    architecture=Architecture(4),
)


def right_words(cache: Path, simulator: str) -> int:
    """Simulate the core and return how many words equal the model's."""
    codes = contact_codes(DESIGN, 2, 1)
    expected = FixedTfra(DESIGN)(codes).words
    run = simulate(DESIGN, codes, simulator, build_dir=cache, expected=expected)
    return int((run.words == expected).sum())


def damage_all(simulator: str) -> dict[str, Any]:
    """Damage, run, compare: how many kinds and entries, the words compared each time, and what did not heal."""
    with tempfile.TemporaryDirectory() as place:
        cache = Path(place)
        words = right_words(cache, simulator)
        good = {path.name: path.read_bytes() for path in cache.iterdir()}
        for name, content in good.items():
            print(f"{name}: {len(content) / 1e6:.2f} MB, checked in {1e3 * _time_of_check(cache / name):.2f} ms")
        wrong = []
        for name in good:
            for kind, damage in DAMAGES.items():
                _restore(cache, good)
                damage(cache / name)
                healed = right_words(cache, simulator) == words and _whole(cache, good)
                wrong += [] if healed else [f"{name}: {kind}"]
    return {"kinds": len(DAMAGES), "entries": len(good), "words": words, "wrong": wrong}


def _restore(cache: Path, good: Mapping[str, bytes]) -> None:
    for path in cache.iterdir():
        discard(path)
    for name, content in good.items():
        (cache / name).write_bytes(content)


def _whole(cache: Path, good: Mapping[str, bytes]) -> bool:
    return {path.name for path in cache.iterdir()} == set(good) and all(_read(cache / name) for name in good)


def _time_of_check(entry: Path) -> float:
    times = []
    for _ in range(20):
        start = time.perf_counter()
        _read(entry)
        times.append(time.perf_counter() - start)
    return min(times)
