"""Line 11: the bytes of generated files, whatever they are made in."""

import hashlib
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

from bench.publish import ROOT
from bench.scorecard.line import GATEWARE, Line, Measured, progress

EXAMPLES = ("small", "learned_small", "fingers_32x32")
QUICK = ("learned_small",)
KINDS = {"Verilog and its package": ("--package",), "C": ("--backend", "c")}
PYTHONS = ("3.12", "3.13")
"""Beside the one that runs this."""
VARIABLES: dict[str, dict[str, str]] = {
    "hash seed 1": {"PYTHONHASHSEED": "1"},
    "hash seed 4321": {"PYTHONHASHSEED": "4321"},
    "another locale": {"LC_ALL": "tr_TR.UTF-8", "LANG": "tr_TR.UTF-8", "PYTHONUTF8": "0"},
    "another time zone": {"TZ": "Pacific/Kiritimati", "SOURCE_DATE_EPOCH": "1"},
}


def made(folder: Path, python: str, example: str, kind: str, variables: dict[str, str]) -> dict[str, str]:
    """Hashes of all files that ``tfra generate`` writes below the ``folder``, by name.

    Raises ``CalledProcessError`` where it fails.
    """
    out = folder / "core"
    command = [
        python,
        "-m",
        "tfra.cli",
        "generate",
        str(ROOT / "examples" / f"{example}.toml"),
        "--out",
        str(out),
    ]
    environment = {**os.environ, "PYTHONHASHSEED": "0", "PYTHONPATH": str(ROOT), **variables}
    subprocess.run([*command, *KINDS[kind]], cwd=folder, env=environment, capture_output=True, check=True)
    files = sorted(file for file in out.rglob("*") if file.is_file())
    hashes = {str(file.relative_to(out)): hashlib.sha256(file.read_bytes()).hexdigest() for file in files}
    shutil.rmtree(out)
    return hashes


def pythons(folder: Path) -> Iterator[tuple[str, str]]:
    """Versions of ``PYTHONS`` with an interpreter that has tfra installed, in ``folder``; "" where there is none."""
    for version in PYTHONS:
        found = [
            shutil.which(f"python{version}"),
            *map(str, Path.home().glob(f".pyenv/versions/{version}*/bin/python")),
        ]
        place = folder / version
        yield version, next((str(place / "bin" / "python") for one in found if one and _installed(one, place)), "")


def _installed(python: str, place: Path) -> bool:
    """Whether ``python`` could be made to an environment in ``place``."""
    install = ["-m", "pip", "install", "-q", "-c", str(ROOT / "constraints.txt"), "-e", f"{ROOT}[ip]"]
    for command in ([python, "-m", "venv", "--clear", str(place)], [str(place / "bin" / "python"), *install]):
        if subprocess.run(command, capture_output=True, check=False).returncode:
            return False
    return True


def measure(quick: bool) -> Measured:
    """All kinds of files in all variations; quickly, those of one example by this Python."""
    different, missing, count, compared = [], [], 0, 0
    with tempfile.TemporaryDirectory() as folder:
        ways = {name: (sys.executable, variables, "x") for name, variables in VARIABLES.items()}
        ways["another path"] = (sys.executable, {}, "a folder with blanks, ä and/deeper")
        for version, python in () if quick else pythons(Path(folder)):
            if python:
                ways[f"Python {version}"] = (python, {}, "x")
            else:
                missing.append(f"Python {version}")
        for example in QUICK if quick else EXAMPLES:
            for kind in KINDS:
                progress(f"{kind} of {example}")
                first = made(Path(folder), sys.executable, example, kind, {})
                count += len(first)
                for name, (python, variables, place) in ways.items():
                    where = Path(folder) / place
                    where.mkdir(parents=True, exist_ok=True)
                    other = made(where, python, example, kind, variables)
                    compared += len(first)
                    different += [f"{example}, {kind}, {name}: {file}" for file in unequal(first, other)]
    figure = f"{count} files, {len(ways)} ways each: {len(different)} of {compared} differ"
    figure += "".join(f"; not run: {name}" for name in missing)
    return Measured(
        figure, not different and not missing, {"ways": list(ways), "different": different, "missing": missing}
    )


def unequal(first: dict[str, str], other: dict[str, str]) -> list[str]:
    """Files that are not in both with the same hash."""
    return sorted(name for name in first.keys() | other.keys() if first.get(name) != other.get(name))


LINE = Line(
    11,
    "bytes of Verilog, C and packages over hash seeds, locale, path, time zone and Python 3.11 to 3.13",
    "identical",
    "every way is run on one machine, with the versions of constraints.txt.",
    (*GATEWARE, "cli", "constraints.txt", "pyproject.toml", "bench/scorecard/reproducible.py"),
    measure,
)
