"""The tests of a copy of this tree: those that can detect a change of a file, their order, and their results."""

from __future__ import annotations

import os
import re
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from bench.publish import ROOT

PACKAGES = (
    "runtime", "model", "recordings", "report", "hdl", "codegen", "sim", "synth", "study", "train", "view", "cli",
    "paper",
)
"""Folders that are packages in the package ``tfra``, whose own files are in the folder ``library``."""
FOLDERS = ("tfra", *PACKAGES, "bench", "tests")
"""Folders of Python files."""
_LEFT = shutil.ignore_patterns(".git", ".venv", "build", "__pycache__", "*.egg-info", ".hypothesis", ".*_cache")

CORES = (
    "tests/hdl/parallel/tfra/test_core.py",
    "tests/hdl/parallel/learned/test_core.py",
    "tests/sim/test_verify.py",
    "tests/hdl/serial",
)
"""Tests that run whole cores."""

ORDER = ("tests/hdl", "tests/model/fixed", "tests/sim", "tests/codegen", "tests/")
"""Folders in the order in which their tests run when those nearest to a change have not detected it."""

SLOW = ("tests/synth", "tests/paper", "tests/bench", "tests/cli", "tests/model/cover")
"""Folders whose long tests check no word of a core: gates and sizes, figures, studies."""

TIERS = {"short": "not long", "long": "long"}
"""The tiers of tests, and how pytest chooses theirs."""

_TEST = {"short": 300, "long": 900}
"""Seconds after which a test has failed."""
_RUN = 5400


@dataclass(frozen=True)
class Outcome:
    """The result of a run of tests: ``failed`` is the first test that failed, ``FILE::NAME``, or "".

    ``loaded`` is false where it failed because the tests could not be loaded.
    """

    failed: str
    loaded: bool = True


class Copy:
    """A copy of the tree that tests run in, with caches of its own; ``folder`` is empty or missing before."""

    def __init__(self, folder: Path) -> None:
        self.root = folder / "tree"
        self._scratch = folder / "scratch"
        shutil.copytree(ROOT, self.root, ignore=_LEFT, symlinks=True)

    def write(self, file: str, text: str) -> None:
        """Replace a file's text; its bytecode goes, since it may have the same size and second."""
        path = self.root / file
        path.write_text(text)
        for old in (path.parent / "__pycache__").glob(f"{path.stem}.*.pyc"):
            old.unlink()

    def run(self, arguments: Sequence[str], seconds: float) -> tuple[int | None, str]:
        """Exit code and output of ``python -m`` with these arguments; no code if it took longer."""
        shutil.rmtree(self._scratch, ignore_errors=True)
        shutil.rmtree(self.root / ".hypothesis", ignore_errors=True)
        self._scratch.mkdir()
        more = {"PYTHONPATH": str(self.root), "TFRA_CACHE": str(self._scratch / "cache"), "OMP_NUM_THREADS": "1"}
        how = {"cwd": self.root, "env": {**os.environ, **more}, "start_new_session": True, "stderr": subprocess.STDOUT}
        with (self._scratch / "output").open("w+") as output:
            process = subprocess.Popen([sys.executable, "-m", *arguments], stdout=output, **how)
            try:
                code: int | None = process.wait(seconds)
            except subprocess.TimeoutExpired:
                code = None
            finally:
                with suppress(ProcessLookupError):
                    os.killpg(process.pid, signal.SIGKILL)  # what it may have left after, too
                process.wait()
            output.seek(0)
            return code, output.read()

    def test(self, chosen: Sequence[str], tier: str) -> Outcome:
        """The tests ``chosen`` in this order, until one fails."""
        if not chosen:
            return Outcome("")
        options = ["-x", "-q", "-p", "no:cacheprovider", "-p", "no:xdist", "-m", TIERS[tier]]
        options += [f"--timeout={_TEST[tier]}", f"--basetemp={self._scratch / 'tests'}"]
        code, output = self.run(["pytest", *options, *chosen], _RUN)
        if code in (0, 5):  # 5: this tier has none of them
            return Outcome("")
        found = re.findall(r"^(?:FAILED|ERROR) (tests/[\w/]+\.py(?:::\w+)*)", output, re.MULTILINE)
        return Outcome(found[0] if found else f"exit code {code}", loaded=code != 2)


def nearest(file: str, tests: Iterable[str]) -> list[str]:
    """Those of ``tests`` that are made for the source ``file``: of its name, then of its folder."""
    path, every = Path(file), sorted(tests)
    folder = Path("tests", path.parent)
    while folder != Path("tests") and not any(Path(test).parent == folder for test in every):
        folder = folder.parent
    named = [test for test in every if Path(test).name == f"test_{path.stem}.py"]
    named.sort(key=lambda test: Path(test).parent != folder)
    return named + [test for test in every if Path(test).parent == folder and test not in named]


def texts(root: Path) -> dict[str, str]:
    """All Python files of the tree with their texts."""
    files = (file for folder in FOLDERS for file in sorted((root / folder).rglob("*.py")))
    return {str(file.relative_to(root)): file.read_text() for file in files}


def reached(sources: Mapping[str, str]) -> dict[str, set[str]]:
    """The files that each test file of ``sources`` names, or that those name, and so on; itself too."""
    modules = {_module(file): file for file in sources}
    named = {file: {modules[name] for name in _names(text) if name in modules} for file, text in sources.items()}
    result = {}
    for test in sources:
        if Path(test).name.startswith("test_"):
            found, new = {test}, {test}
            while new:
                new = set[str]().union(*(named[file] for file in new)) - found
                found |= new
            result[test] = found
    return result


def _module(file: str) -> str:
    """The name by which a file is imported."""
    name = file.removesuffix(".py").removesuffix("/__init__").replace("/", ".")
    folder, dot, inside = name.partition(".")
    if folder == "tfra":
        return f"tfra{dot}{inside}"
    return f"tfra.{name}" if folder in PACKAGES else name


def _names(text: str) -> set[str]:
    """Dotted names that may be modules of ours, in imports and in strings."""
    names = set(re.findall(r"\b(?:tfra|bench|tests)(?:\.\w+)+|(?<=import )tfra$", text, re.MULTILINE))
    for module, listed in re.findall(r"^\s*from ([\w.]+) import ([\w, ]+|\([\w,\s]+\))", text, re.MULTILINE):
        names |= {f"{module}.{word}" for word in re.findall(r"\w+", listed)}
    return names | {name.rpartition(".")[0] for name in names}
