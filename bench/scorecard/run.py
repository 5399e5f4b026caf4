"""The trust scorecard: every line measured, and its page written.

``python -m bench.scorecard.run [--quick] [--only N ...]`` measures the lines whose sources have changed since they were
measured, writes ``bench/results/scorecard.json`` after each of them and then docs/scorecard.md.  ``--quick`` measures
those with fewer frames, and writes nothing.  Exits with 1 if a line misses its target; a quick run only where that was
reached before.
"""

import argparse
import sys
import time
from collections.abc import Mapping
from typing import Any

from bench.publish import ROOT, insert, store, stored
from bench.scorecard.line import Line, command
from bench.scorecard.lines import LINES

NAME, PAGE = "scorecard", "docs/scorecard.md"
Record = dict[str, Any]


def known() -> dict[int, Record]:
    """What was measured before, by number."""
    if not (ROOT / "bench" / "results" / f"{NAME}.json").exists():
        return {}
    return {record["number"]: record for record in stored(NAME) if "key" in record}


def measured(line: Line, before: Record | None, quick: bool) -> Record:
    """The record of a line: the one from ``before`` while that holds, else a new one; a failure is always repeated."""
    if line.measure is None:
        return line.facts()
    if before and before["passed"] and before["key"] == line.key(False):
        return {**before, **line.facts(), "current": True}
    print(f"line {line.number}: {line.title}", flush=True)
    key, start = line.key(quick), time.perf_counter()
    found = line.measure(quick)
    record = {
        **line.facts(),
        "figure": found.figure,
        "passed": found.passed,
        "seconds": round(time.perf_counter() - start),
        "command": command(line.number, quick),
        "key": key,
        "current": True,
        "facts": found.facts,
    }
    print(f"  {found.figure}: {verdict(record)}, {record['seconds']} s", flush=True)
    return record


def verdict(record: Record) -> str:
    """How a line did, in a few words."""
    if "passed" not in record:
        return "not measured"
    stale = "" if record["current"] else ", of earlier sources"
    return ("reached" if record["passed"] else "**missed**") + stale


def worse(record: Record, before: Record | None) -> bool:
    """Whether a line misses its target that reached it before."""
    return not record.get("passed", True) and before is not None and before["passed"]


def table(records: list[Record]) -> str:
    """Markdown: a row for each line, then a sentence for each on what its figure does not tell."""
    lines = ["| | line | target | figure | target is | seconds |", "|---:|---|---|---|---|---:|"]
    for record in records:
        cells = (
            record["title"],
            record["target"],
            record.get("figure", ""),
            verdict(record),
            record.get("seconds", ""),
        )
        lines.append(f"| {record['number']} | {' | '.join(map(str, cells))} |")
    told = [f"* Line {record['number']}: {record['limits']}" for record in records if record["limits"]]
    return "\n".join([*lines, "", *told])


def rows(found: Mapping[int, Record]) -> list[Record]:
    """A record of each line: the one that was ``found`` now, or what is stored, maybe by another run meanwhile."""
    records, before = [], known()
    for line in LINES:
        old = before.get(line.number, {})
        current = {"current": old["key"] == line.key(False)} if old else {}
        records.append(found.get(line.number) or {**old, **line.facts(), **current})
    return records


def main() -> int:
    """Measure, store, publish."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="fewer frames, and nothing is written")
    parser.add_argument("--only", type=int, nargs="+", help="numbers of the lines to measure; others stay as they are")
    options = parser.parse_args()
    before, found = known(), dict[int, Record]()
    for line in LINES:
        if not options.only or line.number in options.only:
            found[line.number] = measured(line, before.get(line.number), options.quick)
            if not options.quick:
                store(NAME, rows(found))
    records = rows(found)
    if options.quick:
        print(table(records))
        return int(any(worse(record, before.get(record["number"])) for record in records))
    insert(NAME, table(records), PAGE)
    return int(any(not record.get("passed", True) for record in records))


if __name__ == "__main__":
    sys.exit(main())
