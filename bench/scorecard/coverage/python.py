"""Branches of the package's Python that the tests take: the quick ones, and the long ones of a few files.

``python -m bench.scorecard.coverage.python [TESTS ...]`` runs them, or only the quick ones of some files, with both
cores under coverage.py, and keeps the counts of each file in ``build/coverage/python.json``.  Exits with the tests'
code; a run with failures is kept and told.
"""

import json
import os
import subprocess
import sys
import tempfile
from dataclasses import asdict, dataclass
from hashlib import sha256
from pathlib import Path
from typing import Any

from bench.publish import ROOT

RESULT = ROOT / "build" / "coverage" / "python.json"
ROOMS = ("tfra", *sorted(place.name for place in (ROOT / "tfra").iterdir() if place.is_symlink() and place.is_dir()))
"""Folders of the package; ``tfra/`` has a link to each other one."""

WAIVERS: dict[str, str] = {
    "sim/testbench.py": "runs in the simulators' processes, whose Python coverage.py does not see",
    "codegen/package/templates/*": "is written into packages, whose tests run it there",
}
"""Files, or folders, whose branches are not counted, and why."""

LONG = (
    "tests/cli/test_synth.py",
    "tests/sim/test_verify.py",
    "tests/sim/test_verify_skin.py",
    "tests/study/test_run.py",
)
"""Files whose long tests run as well: no quick one verifies a core or a skin, or has a cluster."""

UNABLE = ("tests/cli/test_entry.py::test_files_that_may_not_grow",)
"""Tests that are left out: files of coverage.py may not grow there, either."""

_SETTINGS = """\
[run]
branch = true
parallel = true
sigterm = true
data_file = {data}
source =
    {rooms}
patch = subprocess, _exit
[json]
pretty_print = false
"""


@dataclass(frozen=True)
class Branches:
    """Branches of a file, and those that a test took; ``lines`` in the same way."""

    file: str
    branches: int
    taken: int
    lines: int
    run: int

    @property
    def share(self) -> float:
        """Of the branches, in percent; of the lines where there is no branch."""
        total, good = (self.branches, self.taken) if self.branches else (self.lines, self.run)
        return 100 * good / total if total else 100.0


def waiver(file: str) -> str:
    """Why ``file`` is not counted, "" where it is."""
    return next((reason for pattern, reason in WAIVERS.items() if Path(file).match(pattern)), "")


def digest() -> str:
    """A hash of the package's Python, of which a result is."""
    files = sorted(file for room in ROOMS for file in (ROOT / room).rglob("*.py"))
    return sha256(b"".join(file.read_bytes() for file in files)).hexdigest()


def read(facts: dict[str, Any]) -> list[Branches]:
    """The files of a report of coverage.py in JSON, the least share first."""
    found = []
    for name, file in facts["files"].items():
        count = file["summary"]
        sizes = (count["num_branches"], count["covered_branches"], count["num_statements"], count["covered_lines"])
        found.append(Branches(name, *sizes))
    return sorted(found, key=lambda one: (one.share, one.file))


def measured(tests: list[str], result: Path) -> int:
    """Run ``tests``, all if there is none; write the counts of all files into ``result``; return the tests' code."""
    places = os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")]).rstrip(os.pathsep)
    variables = {**os.environ, "OMP_NUM_THREADS": "1", "PYTHONPATH": places}
    with tempfile.TemporaryDirectory() as name:  # not in the tree, which some tests list
        folder = Path(name)
        settings = folder / "settings"
        rooms = "\n    ".join(str(ROOT / room) for room in ROOMS)
        settings.write_text(_SETTINGS.format(data=folder / "data", rooms=rooms))

        def coverage(*command: str) -> int:
            run = [sys.executable, "-m", "coverage", command[0], f"--rcfile={settings}", *command[1:]]
            return subprocess.run(run, cwd=ROOT, env=variables, check=False).returncode

        options = ["-q", "-n", "2", "--dist", "worksteal", *(f"--deselect={test}" for test in UNABLE)]
        code = coverage("run", "-m", "pytest", *options, "-m", "not long", *tests)
        if not tests:
            code = coverage("run", "-m", "pytest", *options, "-m", "long", *LONG) or code
        coverage("combine", "-q")
        coverage("json", "-q", "-o", str(folder / "report.json"))
        report = json.loads((folder / "report.json").read_text())
    kept = {"passed": code == 0, "digest": digest(), "tests": tests, "files": [asdict(one) for one in read(report)]}
    result.parent.mkdir(parents=True, exist_ok=True)
    result.write_text(json.dumps(kept))
    return code


if __name__ == "__main__":
    sys.exit(measured(sys.argv[1:], RESULT))
