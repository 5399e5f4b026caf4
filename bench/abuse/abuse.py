"""All tests for lost or left-over files at full scale, and the table of docs/files.md.

``python -m bench.abuse.abuse [PART ...]`` runs the parts (all by default) and publishes their row; half an hour to an
hour.
"""

from __future__ import annotations

import argparse
import json
import shlex
from collections import Counter
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from typing import Any

from bench.abuse import cache_damage, kills, looks, trees
from bench.publish import ROOT, publish

TREES, LOOKS, KILLS = 10_000, 10_000, 45
"""Random trees; looks at a directory, and at an archive; kills of each command."""

SHARE = 500
"""Trees that a process tries in a row."""


def try_trees() -> dict[str, Any]:
    """Every command on random trees, on two processes."""
    written: Counter[str] = Counter()
    with ProcessPoolExecutor(2) as pool:
        for part in pool.map(trees.run, [SHARE] * (TREES // SHARE), range(0, TREES, SHARE)):
            for counts in part.values():
                written.update(counts)
    return {"trees": TREES, "outcomes": dict(sorted(written.items()))}


def try_looks() -> dict[str, Any]:
    """Looks at both kinds of outputs while three writers replace them."""
    return {"looks": LOOKS, "writers": looks.WRITERS, "met": {kind: looks.looks(kind, LOOKS) for kind in looks.KINDS}}


def try_kills(name: str) -> dict[str, Any]:
    """A command killed at random moments."""
    return {"kills": kills.VICTIMS[name].times(KILLS), "wrong": kills.kill(name, KILLS, seed=1)}


def try_damage() -> dict[str, Any]:
    """Every kind of damage to every entry of a cache."""
    return cache_damage.damage_all("icarus")


PARTS: dict[str, Callable[[], dict[str, Any]]] = {
    "trees": try_trees,
    "looks": try_looks,
    "damage": try_damage,
    **{f"kills of {name}": partial(try_kills, name) for name in kills.VICTIMS},
}


def row_of_trees(found: dict[str, Any]) -> tuple[str, str, str]:
    """What was tried, how often, and the result."""
    outcomes = found["outcomes"]
    refused, written = outcomes.get("exit 2", 0), outcomes.get("written", 0)
    what = "random trees of files, links, pipes and tampered outputs under every command's `--out`"
    return what, f"{found['trees']:,}", f"{written:,} outputs written, {refused:,} refused, no byte lost"


def row_of_kills(name: str, found: dict[str, Any]) -> tuple[str, str, str]:
    """The same of kills."""
    wrong = len(found["wrong"])
    what = f"{name} at random moments, by KILL, TERM, INT and HUP in turn"
    said = "output whole, no process and no temporary folder left" if not wrong else f"{wrong} wrong"
    return what, f"{found['kills']:,}", said


def row_of_looks(found: dict[str, Any]) -> tuple[str, str, str]:
    """The same of looks."""
    met: Counter[str] = sum((Counter(counts) for counts in found["met"].values()), Counter())
    whole, exchanged = met.pop("whole", 0), met.pop("exchanged", 0)
    what = f"looks at a directory and at an archive while {found['writers']} writers replace it"
    said = f"{whole:,} whole, {exchanged:,} exchanged during the look, {met.total():,} absent or incomplete"
    return what, f"{whole + exchanged + met.total():,}", said


def row_of_damage(found: dict[str, Any]) -> tuple[str, str, str]:
    """The same of damage."""
    what = f"{found['kinds']} kinds of damage to {found['entries']} entries of the cache"
    said = f"{len(found['wrong'])} not healed by the next run, {found['words']} words compared in each"
    return what, f"{found['kinds'] * found['entries']:,}", said


ROWS: dict[str, Callable[[dict[str, Any]], tuple[str, str, str]]] = {
    "trees": row_of_trees,
    "looks": row_of_looks,
    "damage": row_of_damage,
    **{part: partial(row_of_kills, part) for part in PARTS if part.startswith("kills")},
}


def table(record: dict[str, Any]) -> str:
    """Markdown with a row for each part that was run."""
    commands = {part: f"`python -m bench.abuse.abuse {shlex.quote(part)}`" for part in PARTS if part in record}
    rows = [(*ROWS[part](record[part]), command) for part, command in commands.items()]
    lines = ["| tried | times | found | again |", "|---|---:|---|---|", *(f"| {' | '.join(row)} |" for row in rows)]
    return "\n".join(lines)


def main() -> None:
    """Run and publish."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("parts", nargs="*", metavar="PART", help=", ".join(PARTS))
    wanted = parser.parse_args().parts or list(PARTS)
    file = ROOT / "bench" / "results" / "abuse.json"
    for part in wanted:
        found = PARTS[part]()
        record = json.loads(file.read_text()) if file.exists() else {}
        record[part] = found
        publish("abuse", {name: record[name] for name in PARTS if name in record}, table(record), "docs/files.md")


if __name__ == "__main__":
    main()
