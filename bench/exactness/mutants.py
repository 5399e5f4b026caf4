"""Mutation test of gateware and model: how many mutants ``make test`` detects, and how many all tests detect.

``python -m bench.exactness.mutants [--count N] [--seed S] [--workers W] [--keep] [--room NAME]`` changes one place at a
time in a copy of the tree, spread evenly over the files (those in folders called NAME), and runs tests until one fails
that passes without the change.  The tests nearest to the file come first, then those of whole cores, then all others
that can reach it; the long ones come last.  A mutant that the nearest tests do not detect and that does not change the
fingerprint of any design is equivalent.  ``bench/results/mutants.json`` (``mutants_NAME.json``) grows with every
mutant, and ``--keep`` continues from there; the table of docs/development.md comes after every round.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
import time
from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from itertools import repeat
from pathlib import Path
from queue import SimpleQueue
from threading import Lock
from typing import Any

from bench.exactness.mutations import Mutation, choose
from bench.exactness.suite import CORES, ORDER, SLOW, Copy, Outcome, nearest, reached, texts
from bench.publish import ROOT, insert, store

PAGE = "docs/development.md"
AIM = 0.9
"""Least share of the detected mutants that the short tests must detect."""

ROUNDS: tuple[tuple[tuple[str, str], ...], ...] = (
    (("short", "near"),),
    (("short", "cores"),),
    (("short", "rest"),),
    (("long", "near"), ("long", "cores")),
    (("long", "rest"),),
)
"""Tiers and parts of the tests.  All mutants go through a round before those that are left go through the next."""

FATE = ("status", "tier", "test", "round", "seconds")
"""Keys of a record line with the mutant's result; the others describe the mutant."""

MUTATED = ("hdl/", "model/fixed/")
_FINGERPRINT = 900
"""Seconds that the fingerprint may take."""


class Judge:
    """Runs the tests of one copy against one mutant at a time."""

    def __init__(self, folder: Path) -> None:
        self._copy = Copy(folder)
        self._sources = texts(self._copy.root)
        self._reached = reached(self._sources)
        self._passes: dict[tuple[str, str], bool] = {}
        self._before = self._fingerprint()
        if self._before is None:
            raise RuntimeError("the fingerprint fails on the tree as it is")

    def _fingerprint(self) -> str | None:
        code, output = self._copy.run(["bench.exactness.fingerprint"], _FINGERPRINT)
        return output if code == 0 else None

    def __call__(self, file: str, mutation: Mutation, number: int) -> dict[str, Any]:
        """The result of the mutant in this round, and the test that detected it."""
        text, start = self._sources[file], time.perf_counter()
        self._copy.write(file, mutation.apply(text))
        try:
            status, tier, test = self._judge(file, mutation, number)
        finally:
            self._copy.write(file, text)
        return dict(zip(FATE, (status, tier, test, number, round(time.perf_counter() - start)), strict=True))

    def _judge(self, file: str, mutation: Mutation, number: int) -> tuple[str, str, str]:
        for tier, part in ROUNDS[number]:
            outcome = self._first_failure(file, mutation, self._tests(file, tier, part), tier)
            if outcome.failed:
                return ("killed" if outcome.loaded else "broken"), tier, outcome.failed
            if number == 0 and self._fingerprint() == self._before:
                return "equivalent", "", ""
        return ("survived" if number == len(ROUNDS) - 1 else "open"), "", ""

    def _tests(self, file: str, tier: str, part: str) -> list[str]:
        """The test files of a part, in the order in which they are asked."""
        tests = [test for test, files in self._reached.items() if file in files]
        near = nearest(file, tests)
        cores = [test for test in tests if test.startswith(CORES) and test not in near]
        rest = sorted(set(tests) - {*near, *cores}, key=_turn)
        found = {"near": near, "cores": cores, "rest": rest}[part]
        every = tier == "short" or file.startswith("hdl/primitives/")
        return [test for test in found if every or not test.startswith(SLOW)]

    def _first_failure(self, file: str, mutation: Mutation, tests: list[str], tier: str) -> Outcome:
        """The first test that fails with the mutation and passes without."""
        chosen = list(tests)
        while (outcome := self._copy.test(chosen, tier)).failed.startswith("tests/"):
            key = tier, outcome.failed
            if key not in self._passes:
                self._copy.write(file, self._sources[file])
                self._passes[key] = not self._copy.test([outcome.failed], tier).failed
                self._copy.write(file, mutation.apply(self._sources[file]))
            if self._passes[key]:
                return outcome
            print(f"left out, fails without a mutant: {outcome.failed}", flush=True)
            chosen = [test for test in chosen if test != outcome.failed.partition("::")[0]]
        return outcome


def _turn(test: str) -> tuple[int, str]:
    return next(number for number, folder in enumerate(ORDER) if test.startswith(folder)), test


def described(file: str, text: str, mutation: Mutation) -> dict[str, Any]:
    """The change in words; two mutants of a tree never have the same."""
    before, after = mutation.before(text), mutation.after(text)
    return {"file": file, "line": mutation.line(text), "kind": mutation.kind, "before": before, "after": after}


def sources(room: str) -> list[tuple[str, str]]:
    """Files that are changed, with their texts; only those in folders called ``room``, unless that is empty."""
    found = [(name, text) for name, text in texts(ROOT).items() if name.startswith(MUTATED)]
    return [(name, text) for name, text in found if not room or room in Path(name).parts]


def table(record: list[dict[str, Any]]) -> str:
    """Mutants and what noticed them, by folder."""
    counted = [one for one in record if one["status"] in ("killed", "survived")]
    folders = sorted({str(Path(one["file"]).parent) for one in counted})
    lines = ["| folder | mutants | noticed by all tests | by `make test` |", "|---|---:|---:|---:|"]
    for folder in folders:
        lines.append(_row(f"`{folder}`", [one for one in counted if str(Path(one["file"]).parent) == folder]))
    lines.append(_row("all", counted))
    every, short = _noticed(counted)
    waiting = sum(one["status"] == "open" for one in record)
    left = len(record) - len(counted) - waiting
    files = len({one["file"] for one in counted})
    text = (
        f"{len(counted)} mutants of {files} files; {left} more are left out, since they change nothing or can't be "
        f"loaded. `make test` notices {short} of the {every} that all tests notice, {short / max(1, every):.0%}."
    )
    if waiting:
        least = short / (every + waiting)
        text += (
            f" {waiting} more have passed the tests nearest to them and wait for the others: if the long ones alone "
            f"noticed all of these, it would be {least:.0%}."
        )
    return "\n".join([text, "", *lines])


def _noticed(record: Iterable[dict[str, Any]]) -> tuple[int, int]:
    """How many all tests notice, and how many the short ones."""
    tiers = [one["tier"] for one in record if one["status"] == "killed"]
    return len(tiers), tiers.count("short")


def _row(name: str, record: list[dict[str, Any]]) -> str:
    every, short = _noticed(record)
    return f"| {name} | {len(record)} | {every} | {short} |"


def stored(name: str, seed: int) -> list[dict[str, Any]]:
    """The mutants of this seed that the record ``name`` has."""
    path = ROOT / "bench" / "results" / f"{name}.json"
    found = json.loads(path.read_text()) if path.exists() else {"seed": None}
    return list(found["mutants"]) if found["seed"] == seed else []


def run(
    name: str, record: Sequence[dict[str, Any]], chosen: Sequence[tuple[str, Mutation]], seed: int, workers: int
) -> None:
    """Complete the lines of ``record``, a round after another; store them as they come, and the table of each round."""
    lock, judges = Lock(), SimpleQueue[Judge]()

    def judge(place: int, number: int) -> None:
        own = judges.get()
        try:
            fate = own(*chosen[place], number)
        finally:
            judges.put(own)
        with lock:
            record[place].update(fate)
            print("{file}:{line} {kind}: {status} {tier} {test} {seconds} s".format(**record[place]), flush=True)
            store(name, {"seed": seed, "mutants": judged(record)})

    with tempfile.TemporaryDirectory(prefix="mutants-") as folder, ThreadPoolExecutor(workers) as pool:
        for ready in pool.map(Judge, (Path(folder) / str(number) for number in range(workers))):
            judges.put(ready)
        for number in range(len(ROUNDS)):
            left = [place for place, one in enumerate(record) if is_open(one, number)]
            list(pool.map(judge, left, repeat(number)))
            insert(name, table(record), PAGE)


def is_open(one: dict[str, Any], number: int) -> bool:
    """Whether a mutant is to go through this round."""
    return bool("status" not in one or (one["status"] == "open" and one["round"] < number))


def judged(record: Iterable[dict[str, Any]]) -> list[dict[str, Any]]:
    """Those that have gone through a round."""
    return [one for one in record if "status" in one]


def main() -> int:
    """Judge all mutants; 1 if the short tests notice too few of them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--workers", type=int, default=1, help="mutants at a time")
    parser.add_argument("--keep", action="store_true", help="keep what was judged before with this seed")
    parser.add_argument("--room", default="", help="only files in folders of this name")
    options = parser.parse_args()
    files, name = dict(sources(options.room)), "_".join(["mutants", *options.room.split()])
    chosen = choose(files.items(), options.count, options.seed)
    record = [described(file, files[file], mutation) for file, mutation in chosen]
    before = stored(name, options.seed) if options.keep else []
    for one in record:
        one |= next((old for old in before if one.items() <= old.items()), {})
    run(name, record, chosen, options.seed, options.workers)
    every, short = _noticed(record)
    return 0 if short >= AIM * every else 1


if __name__ == "__main__":
    sys.exit(main())
