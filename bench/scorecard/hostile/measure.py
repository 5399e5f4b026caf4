"""Line 10: what users, crashes, other processes and damaged bytes can do to the program."""

import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from bench.publish import ROOT
from bench.scorecard.hostile import fuzz, sanitizers
from bench.scorecard.line import GATEWARE, Line, Measured, progress

TESTS = {
    "misuse": ("tests/cli/test_misuse.py", "tests/cli/test_inputs.py", "tests/calibrate/test_loads.py"),
    "kills and concurrent writers": (
        "tests/runtime",
        "tests/cli/test_entry.py",
        "tests/study/search/test_search.py",
        "tests/train/test_run.py::test_an_interrupted_training_continues_to_the_same_weights",
    ),
    "damaged files": (
        "tests/recordings",
        "tests/view/test_resultfile.py",
        "tests/view/test_skin.py::test_a_damaged_result_is_refused",
        "tests/codegen/config/test_weights.py",
        "tests/train/test_run.py::test_a_damaged_state_is_refused",
    ),
}
QUICK_TESTS = {"kills and concurrent writers": ("tests/runtime/test_staging.py", "tests/runtime/test_store.py")}
DESIGNS, NOISE, SIMULATED = 12, 1000, 2
"""Drawn designs under the sanitizers, frames of noise for each, and designs in C++."""
QUICK_DESIGNS, QUICK_NOISE = 2, 100
QUICK_INPUTS = 200
LEAST, LEAST_EACH = 1_000_000, 10_000
"""Inputs of a full run, and of each reader."""


def tested(places: Sequence[str]) -> dict[str, int]:
    """How many tests of pytest's ``places`` passed, and how many did anything else."""
    with tempfile.TemporaryDirectory() as folder:
        report = Path(folder) / "tests.xml"
        command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", f"--junitxml={report}", *places]
        subprocess.run(command, cwd=ROOT, capture_output=True, check=False)
        cases = list(ElementTree.parse(report).getroot().iter("testcase"))
    passed = sum(not [part for part in case if part.tag in ("failure", "error", "skipped")] for case in cases)
    return {"passed": passed, "not passed": len(cases) - passed}


def measure(quick: bool) -> Measured:
    """Tests, sanitizers and fuzzing, or a part of each."""
    tests = {}
    for kind, places in (QUICK_TESTS if quick else TESTS).items():
        progress(f"tests of {kind}")
        tests[kind] = tested(places)
    progress("sanitizers")
    checked = sanitizers.campaign(*((QUICK_DESIGNS, QUICK_NOISE, 0) if quick else (DESIGNS, NOISE, SIMULATED)))
    progress("fuzzing")
    from bench.scorecard.hostile.readers import READERS  # slow: half of the package, which no other line needs

    counts = {name: QUICK_INPUTS if quick else reader.count for name, reader in READERS.items()}
    fuzzed = (fuzz.brief if quick else fuzz.campaign)(counts)
    return judged(tests, checked, fuzzed, quick)


def judged(
    tests: dict[str, dict[str, int]],
    checked: dict[str, dict[str, Any]],
    fuzzed: dict[str, dict[str, Any]],
    quick: bool,
) -> Measured:
    """The figure, and whether nothing is wrong in any of them; each reader reads some inputs and refuses others."""
    passed = sum(kind["passed"] for kind in tests.values())
    failed = sum(kind["not passed"] for kind in tests.values())
    inputs = {name: sum(one["outcome"].values()) for name, one in fuzzed.items()}
    found = {name: one["findings"] for name, one in fuzzed.items() if one["findings"]}
    reports = {name: one for name, one in checked.items() if one["report"] or one["differ"] or not one["compared"]}
    kinds = ", ".join(f"{kind['passed']} of {name}" for name, kind in tests.items())
    words = sum(one["compared"] for one in checked.values())
    figure = (
        f"{passed} of {passed + failed} tests pass ({kinds}); {len(checked)} programs with sanitizers, "
        f"{words:,} answers: {len(reports)} reports or differences; {sum(inputs.values()):,} inputs of "
        f"{len(inputs)} readers: {sum(len(each) for each in found.values())} findings"
    )
    enough = quick or (sum(inputs.values()) >= LEAST and min(inputs.values()) >= LEAST_EACH)
    facts = {
        "tests": tests,
        "sanitizers": checked,
        "fuzzed": {name: one["outcome"] for name, one in fuzzed.items()},
        "findings": found,
        "limits": {"seconds": fuzz.SECONDS, "bytes": fuzz.MEMORY},
    }
    return Measured(figure, enough and passed > 0 and not (failed or reports or found), facts)


LINE = Line(
    10,
    "hostile inputs, kills, concurrent writers, damaged files; C under sanitizers; fuzzing of every reader",
    "0 tracebacks, hangs, reports, lost files; 1e6 inputs, 1e4 of each reader",
    "inputs are valid ones with a few changes by chance, without guidance by coverage; the conversion of Parquet, which"
    " has a process of its own, is called within the reader's; shifts in the headers of ap_int are left out; arguments"
    " of commands and the output of other programs are not fuzzed.",
    (*GATEWARE, "recordings", "calibrate", "view", "study", "train", "cli", "sim", "bench/scorecard/hostile"),
    measure,
)
