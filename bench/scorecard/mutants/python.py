"""Mutants of the model and of codegen: a wrong change of a source file, and the short tests that it meets."""

import os
import re
import shutil
import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path
from typing import Any

from bench.publish import ROOT
from bench.scorecard.mutants.mutations import Mutation, choose

COUNT, SEED = 48, 2
MUTATED = ("model", "codegen")
SECONDS = 300
"""For the tests of a mutant; those that don't end in this time have not noticed it."""
END_TO_END = (
    "tests/model/fixed/tfra/test_pipeline.py",
    "tests/model/fixed/learned/test_pipeline.py",
    "tests/codegen/test_back_ends.py",
    "tests/sim/test_compiled.py",
    "tests/hdl/serial/test_core.py",
    "tests/codegen/config/test_read.py",
    "tests/hdl/parallel/learned/test_core.py",
    "tests/hdl/parallel/tfra/test_core.py",
)
"""Tests of whole cores and configurations, quick ones first, for mutants that nearer tests don't notice."""
LEFT_OUT = shutil.ignore_patterns(".git", ".venv", "build", "__pycache__", "*.egg-info", ".hypothesis", ".*_cache")


class Copy:
    """A copy of the tree that tests run in, with a cache of its own, in the empty or missing ``folder``."""

    def __init__(self, folder: Path) -> None:
        self._root, self._scratch = folder / "tree", folder / "scratch"
        shutil.copytree(ROOT, self._root, ignore=LEFT_OUT, symlinks=True)
        self._broken = set[str]()

    def judge(self, file: str, mutation: Mutation) -> str:
        """The test that notices the mutant: it fails, and passes without the change; "" if none does in time."""
        text, end = (self._root / file).read_text(), time.monotonic() + SECONDS
        tests = nearest(file, self._root)
        try:
            while True:
                self._write(file, mutation.apply(text))
                failed = self._failing(tests, end)
                self._write(file, text)
                if not failed or not self._failing([failed], time.monotonic() + SECONDS):
                    return failed
                self._broken.add(failed)
        finally:
            self._write(file, text)

    def _write(self, file: str, text: str) -> None:
        """Replace a file's text; its bytecode goes, since it may have the same size and second."""
        path = self._root / file
        path.write_text(text)
        for old in (path.parent / "__pycache__").glob(f"{path.stem}.*.pyc"):
            old.unlink()

    def _failing(self, tests: list[str], end: float) -> str:
        """The first of the short ``tests`` that fails before the time ``end``, ``FILE::NAME``; "" if none does."""
        options = ["-x", "-q", "-p", "no:cacheprovider", "-p", "no:xdist", "-m", "not long", "--timeout=100"]
        options += [f"--basetemp={self._scratch / 'tests'}", *(f"--deselect={name}" for name in self._broken)]
        code, output = self._run([*options, *tests], end)
        if code in (None, 0, 5):  # 5: there are none
            return ""
        found = re.search(r"^(?:FAILED|ERROR) (tests/[\w/]+\.py(?:::\w+)*)", output, re.MULTILINE)
        return found[1] if found else f"exit code {code}"

    def _run(self, arguments: list[str], end: float) -> tuple[int | None, str]:
        """Exit code and output of pytest with these arguments; no code if it is not done at the time ``end``."""
        shutil.rmtree(self._scratch, ignore_errors=True)
        self._scratch.mkdir()
        more = {"PYTHONPATH": str(self._root), "TFRA_CACHE": str(self._scratch / "cache"), "OMP_NUM_THREADS": "1"}
        how: dict[str, Any] = {"cwd": self._root, "env": {**os.environ, **more}, "start_new_session": True}
        with (self._scratch / "output").open("w+") as output:
            command = [sys.executable, "-m", "pytest", *arguments]
            process = subprocess.Popen(command, stdout=output, stderr=subprocess.STDOUT, **how)
            code: int | None = None
            with suppress(subprocess.TimeoutExpired):
                code = process.wait(max(1, end - time.monotonic()))
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()
            output.seek(0)
            return code, output.read()


def nearest(file: str, root: Path) -> list[str]:
    """Tests for the source ``file``: of its name, then those that import it, then others of the folder that mirrors
    its own, then those of whole cores.
    """
    folder = Path("tests", file).parent
    while not (root / folder).is_dir():
        folder = folder.parent
    named = [name for name in (str(folder / f"test_{Path(file).stem}.py"),) if (root / name).exists()]
    module = "tfra." + file.removesuffix(".py").replace("/", ".")
    parent, _, name = module.rpartition(".")
    uses = re.compile(rf"\b{re.escape(module)}\b|from {re.escape(parent)} import .*\b{name}\b")
    tests = [test for room in MUTATED for test in sorted((root / "tests" / room).rglob("test_*.py"))]
    users = [str(test.relative_to(root)) for test in tests if uses.search(test.read_text())]
    others = [str(test.relative_to(root)) for test in sorted((root / folder).glob("test_*.py"))]
    return list(dict.fromkeys([*named, *users, *others, *END_TO_END]))


def sources() -> list[tuple[str, str]]:
    """Files that are changed, with their texts."""
    files = sorted(path for folder in MUTATED for path in (ROOT / folder).rglob("*.py"))
    return [(str(path.relative_to(ROOT)), path.read_text()) for path in files]


def mutants() -> list[tuple[str, Mutation]]:
    """Files and their mutants, spread evenly over the files."""
    return choose(sources(), COUNT, SEED)
