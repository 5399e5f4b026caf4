"""What the short tests notice of small wrong changes in gateware and model.

``python -m bench.exactness.mutants [--keep]`` changes one place at a time in a copy of the tree, spread evenly over the
files, and runs tests until one fails that passes without the change: first those nearest to the file, then those of
whole cores, then all others of hdl, model, sim and codegen.  A mutant that the nearest tests don't notice and that
leaves the fingerprint of all designs as it was changes nothing.  ``bench/results/mutants.json`` has every mutant, and
``--keep`` continues from there.
"""

import argparse
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from bench.exactness.mutations import Mutation, choose
from bench.publish import ROOT, insert, store, stored

COUNT, SEED = 112, 1
AIM = 0.9
"""Least share of the mutants that the tests must notice."""
MUTATED = ("hdl", "model/fixed")
CORES = ("tests/hdl/parallel/tfra/test_core.py", "tests/hdl/parallel/learned/test_core.py", "tests/hdl/serial")
OTHERS = ("tests/hdl", "tests/model", "tests/sim", "tests/codegen")
LEFT_OUT = shutil.ignore_patterns(".git", ".venv", "build", "__pycache__", "*.egg-info", ".hypothesis", ".*_cache")
SECONDS = {"bench.exactness.fingerprint": 900, "pytest": 5400}
"""How long a program may take."""


class Copy:
    """A copy of the tree that tests run in, with a cache of its own, in the empty or missing ``folder``."""

    def __init__(self, folder: Path) -> None:
        self._root, self._scratch = folder / "tree", folder / "scratch"
        shutil.copytree(ROOT, self._root, ignore=LEFT_OUT, symlinks=True)
        self._broken = set[str]()
        self._fingerprint = self._run(["bench.exactness.fingerprint"])
        if self._fingerprint[0]:
            raise RuntimeError(f"the fingerprint fails on the tree as it is:\n{self._fingerprint[1]}")

    def judge(self, file: str, mutation: Mutation) -> tuple[str, str]:
        """Whether the mutant is noticed, and by which test."""
        text = (self._root / file).read_text()
        near = list(nearest(file, self._root))
        self._write(file, mutation.apply(text))
        try:
            for number, tests in enumerate((near, CORES, OTHERS)):
                while failed := self._failing(tests):
                    self._write(file, text)
                    if not self._failing([failed]):
                        return "noticed", failed
                    self._broken.add(failed)
                    self._write(file, mutation.apply(text))
                if number == 0 and self._run(["bench.exactness.fingerprint"]) == self._fingerprint:
                    return "changes nothing", ""
            return "survived", ""
        finally:
            self._write(file, text)

    def _write(self, file: str, text: str) -> None:
        """Replace a file's text; its bytecode goes, since it may have the same size and second."""
        path = self._root / file
        path.write_text(text)
        for old in (path.parent / "__pycache__").glob(f"{path.stem}.*.pyc"):
            old.unlink()

    def _failing(self, tests: Sequence[str]) -> str:
        """The first of the short ``tests`` that fails, ``FILE::NAME``; "" if none does."""
        options = ["-x", "-q", "-p", "no:cacheprovider", "-p", "no:xdist", "-m", "not long", "--timeout=300"]
        options += [f"--basetemp={self._scratch / 'tests'}", *(f"--deselect={name}" for name in self._broken)]
        code, output = self._run(["pytest", *options, *tests])
        if code in (0, 5):  # 5: there are none
            return ""
        found = re.search(r"^(?:FAILED|ERROR) (tests/[\w/]+\.py(?:::\w+)*)", output, re.MULTILINE)
        return found[1] if found else f"exit code {code}"

    def _run(self, arguments: Sequence[str]) -> tuple[int | None, str]:
        """Exit code and output of ``python -m`` with these arguments; no code if it took too long."""
        shutil.rmtree(self._scratch, ignore_errors=True)
        self._scratch.mkdir()
        more = {"PYTHONPATH": str(self._root), "TFRA_CACHE": str(self._scratch / "cache"), "OMP_NUM_THREADS": "1"}
        how: dict[str, Any] = {"cwd": self._root, "env": {**os.environ, **more}, "start_new_session": True}
        with (self._scratch / "output").open("w+") as output:
            command = [sys.executable, "-m", *arguments]
            process = subprocess.Popen(command, stdout=output, stderr=subprocess.STDOUT, **how)
            code: int | None = None
            with suppress(subprocess.TimeoutExpired):
                code = process.wait(SECONDS[arguments[0]])
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()
            output.seek(0)
            return code, output.read()


def nearest(file: str, root: Path) -> Iterator[str]:
    """Tests made for the source ``file``: of its name, then all of the nearest folder that mirrors its own."""
    folder = Path("tests", file).parent
    while not (root / folder).is_dir():
        folder = folder.parent
    named = folder / f"test_{Path(file).stem}.py"
    if (root / named).exists():
        yield str(named)
    others = (test.relative_to(root) for test in (root / folder).glob("test_*.py"))
    yield from sorted(str(test) for test in others if test != named)


def sources() -> list[tuple[str, str]]:
    """Files that are changed, with their texts."""
    files = sorted(path for folder in MUTATED for path in (ROOT / folder).rglob("*.py"))
    return [(str(path.relative_to(ROOT)), path.read_text()) for path in files]


def main() -> int:
    """Judge all mutants; 1 if the tests notice too few of them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--keep", action="store_true", help="keep what was judged before")
    chosen = choose(sources(), COUNT, SEED)
    known = stored("mutants") if parser.parse_args().keep else []
    record = [{"file": file, **vars(mutation)} for file, mutation in chosen]
    for one in record:
        one |= next((old for old in known if one.items() <= old.items()), {})
    with tempfile.TemporaryDirectory(prefix="mutants-") as folder:
        copy = Copy(Path(folder))
        for one, (file, mutation) in zip(record, chosen, strict=True):
            if "status" not in one:
                one["status"], one["test"] = copy.judge(file, mutation)
                print("{file}:{line} {kind}: {status} {test}".format(**one), flush=True)
                store("mutants", [each for each in record if "status" in each])
    found = Counter(one["status"] for one in record)
    counted = found["noticed"] + found["survived"]
    files = len({one["file"] for one in record})
    text = f"Of {counted} mutants in {files} files `make test` notices {found['noticed']}; "
    insert("mutants", f"{text}{found['changes nothing']} more change nothing.", "docs/development.md")
    return int(found["noticed"] < AIM * counted)


if __name__ == "__main__":
    sys.exit(main())
