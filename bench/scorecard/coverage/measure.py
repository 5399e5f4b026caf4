"""Line 6: lines and branches of the Verilog, branches of the Python, declared bins."""

import json
import re
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import asdict
from typing import Any

from bench.scorecard.coverage import bins, python
from bench.scorecard.coverage.run import Covered, covered
from bench.scorecard.coverage.verilog import Point
from bench.scorecard.coverage.waivers import WAIVERS, waived
from bench.scorecard.line import GATEWARE, Line, Measured, progress
from bench.scorecard.words.drawn import drawn, presets
from bench.scorecard.words.harness import Configuration

SEED = 1
DRAWN, NAMES = (0, 1, 3, 8, 15, 17, 18, 24), ("small", "learned_small", "fingers_32x32")
"""Configurations of line 1: both estimators, parallel and serial, alone and behind AXI, a skin."""
CYCLES, QUICK_CYCLES = 8_000_000, 300_000
QUICK_DRAWN, QUICK_BINS = (3, 18), r"(stalls|reset): parallel .*|plateau: .*|status: learned, .* alone"
PYTHON = 95
"""Percent of branches."""
LOWEST = 10
"""Files that are named."""


def configurations(quick: bool) -> list[Configuration]:
    """Those that are run."""
    numbers = QUICK_DRAWN if quick else DRAWN
    found = [one for number, one in enumerate(drawn(max(numbers) + 1, SEED)) if number in numbers]
    return found if quick else [*found, *(one for one in presets() if one.name in NAMES)]


def verilog(reached: Mapping[Point, int]) -> dict[str, Any]:
    """Counts of points, those not reached by the reason of their waiver, those without one, and useless waivers."""
    missed = [point for point, count in reached.items() if not count]
    reasons = {point: waived(point) for point in missed}
    used = Counter(waiver.reason for waiver in reasons.values() if waiver)
    lines = [point for point in reached if point.kind == "block"]
    return {
        "lines": len(lines),
        "branches": len(reached) - len(lines),
        "lines_missed": sum(point in reasons for point in lines),
        "waived": dict(used),
        "missed": [" | ".join((at.block, at.kind, at.condition)) for at in sorted(missed) if not reasons[at]],
        "unused": sorted({waiver.reason for waiver in WAIVERS} - set(used)),
    }


def branches() -> dict[str, Any]:
    """Counts of the package's Python as the last run of the tests left them; why they are of no use, in ``stale``."""
    if not python.RESULT.exists():
        return {"stale": "not measured"}
    kept = json.loads(python.RESULT.read_text())
    files = [python.Branches(**one) for one in kept["files"]]
    counted = [one for one in files if not python.waiver(one.file)]
    stale = "of other sources" if kept["digest"] != python.digest() else "of some tests" if kept["tests"] else ""
    return {
        "stale": stale or ("" if kept["passed"] else "a test failed"),
        "branches": sum(one.branches for one in counted),
        "taken": sum(one.taken for one in counted),
        "lines": sum(one.lines for one in counted),
        "run": sum(one.run for one in counted),
        "lowest": [{**asdict(one), "share": round(one.share, 1)} for one in counted[:LOWEST]],
        "waived": python.WAIVERS,
    }


def judged(found: Iterable[Covered], wanted: Iterable[str], packaged: dict[str, Any] | None) -> Measured:
    """The figure of the runs ``found``, the bins ``wanted`` and, unless quick, the ``packaged`` Python.

    A quick run is too short for some branches, which are only told.
    """
    reached: Counter[Point] = Counter()
    hits: Counter[str] = Counter()
    words = wrong = 0
    for one in found:
        reached.update(one.points)
        hits.update(one.bins)
        words, wrong = words + one.words, wrong + one.wrong
    rtl, names = verilog(reached), list(wanted)
    empty = [name for name in names if not hits[name]]
    counted = rtl["branches"] - sum(rtl["waived"].values())
    figure = f"Verilog: {rtl['lines'] - rtl['lines_missed']:,} of {rtl['lines']:,} lines,"
    figure += f" {counted - len(rtl['missed']):,} of {counted:,} branches, {sum(rtl['waived'].values())} more waived;"
    figure += f" bins: {len(names) - len(empty)} of {len(names)}, {wrong} of {words:,} words wrong; Python: "
    good = not (rtl["lines_missed"] or empty or wrong)
    if packaged is None:
        return Measured(figure + "not in a quick run", good, {"verilog": rtl, "empty": empty})
    good &= not rtl["missed"]
    if "branches" in packaged:
        share = 100 * packaged["taken"] / packaged["branches"]
        good &= share >= PYTHON
        figure += f"{share:.1f} % of {packaged['branches']:,} branches"
    figure += f" ({packaged['stale']})" * bool(packaged["stale"])
    good &= not packaged["stale"] and not rtl["unused"]
    facts = {"seed": SEED, "verilog": rtl, "bins": dict(hits), "empty": empty, "python": packaged}
    return Measured(figure, good, facts)


def measure(quick: bool) -> Measured:
    """All configurations and the kept result of Python, or two configurations alone."""
    found = []
    for configuration in configurations(quick):
        progress(configuration.name)
        found.append(covered(configuration, QUICK_CYCLES if quick else CYCLES))
    wanted = [name for name in bins.declared() if not quick or re.fullmatch(QUICK_BINS, name)]
    return judged(found, wanted, None if quick else branches())


LINE = Line(
    6,
    "coverage: lines and branches of the Verilog, branches of the Python, declared bins (sizes, lanes, plateaus,"
    " stalls, status bits, phases of a reset)",
    f"Verilog and bins 100 %, Python {PYTHON} %, waivers named",
    "places of a block with the same condition, numbers aside, are one branch, over all instances and configurations;"
    " conditions without a signal are left out. Of the bins, only core × stalls of both ports and core × phase of a"
    " reset are crossed. Three pairs of status bits that no frame was found to show are not declared. Registers and the"
    " front end behind AXI are waived here; their own tests reach them. Python is measured by"
    " `python -m bench.scorecard.coverage.python` before, with `make test` and the long tests of verifications, studies"
    " and syntheses.",
    (*dict.fromkeys((*GATEWARE, *python.ROOMS)), "bench/scorecard/words", "bench/scorecard/coverage", "tests"),
    measure,
)
