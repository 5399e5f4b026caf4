"""The process that ``tfra`` is: its streams, its signals, its limits."""

import os
import signal
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[2] / "examples"
MISSING = "none.toml: cannot be read: No such file or directory\n"
LINES = {
    "full": "standard output: cannot be written: No space left on device\n",
    "closed": "standard output: cannot be written: Bad file descriptor\n",
}


def run(script: str, tmp_path: Path, **environment: str) -> subprocess.CompletedProcess[str]:
    """Run a shell ``script``, in which $TFRA is the command."""
    variables = {**os.environ, "TFRA": f"{sys.executable} -m tfra.cli", **environment}
    return subprocess.run(
        ["bash", "-c", script], capture_output=True, text=True, check=False, cwd=tmp_path, env=variables
    )


@pytest.mark.parametrize("command", ["--help", "--version"])
@pytest.mark.parametrize(("stream", "redirection"), [("full", "> /dev/full"), ("closed", ">&-")])
def test_output_that_cannot_be_written(tmp_path: Path, command: str, stream: str, redirection: str) -> None:
    found = run(f"$TFRA {command} {redirection}", tmp_path)
    assert (found.returncode, found.stdout, found.stderr) == (1, "", LINES[stream])


def test_a_reader_that_has_gone(tmp_path: Path) -> None:
    found = run("$TFRA --help | true; exit ${PIPESTATUS[0]}", tmp_path)
    assert (found.returncode, found.stderr) == (128 + signal.SIGPIPE, "")


@pytest.mark.parametrize("redirection", ["2> /dev/full", "2>&-", ">&- 2>&- <&-"])
def test_complaints_that_nobody_hears(tmp_path: Path, redirection: str) -> None:
    found = run(f"$TFRA frames none.toml --out f.npz {redirection}", tmp_path)
    assert (found.returncode, found.stdout, found.stderr) == (2, "", "")
    assert list(tmp_path.iterdir()) == []


def test_without_input(tmp_path: Path) -> None:
    found = run("$TFRA frames none.toml --out f.npz <&-", tmp_path)
    assert (found.returncode, found.stderr) == (2, MISSING)


def test_poor_encodings(tmp_path: Path) -> None:
    for command, encoding in (("--help", "ascii"), ("verify --help", "latin-1")):
        found = run(f"$TFRA {command}", tmp_path, LC_ALL="C", PYTHONIOENCODING=encoding)
        assert (found.returncode, found.stderr) == (0, "")
    found = run("$TFRA frames µ.toml --out f.npz", tmp_path, PYTHONIOENCODING="ascii")
    assert found.stderr == "\\xb5.toml: cannot be read: No such file or directory\n"


def test_names_that_are_no_text(tmp_path: Path) -> None:
    found = run("$TFRA frames $'\\xff.toml' --out f.npz", tmp_path)
    assert found.stderr == "\\udcff.toml: cannot be read: No such file or directory\n"
    (tmp_path / os.fsdecode(b"caf\xe9.toml")).write_text((EXAMPLES / "hertz_40x20.toml").read_text())
    lines = (
        "$TFRA frames $'caf\\xe9.toml' --out $'\\xff.npz'",
        "$TFRA estimate $'caf\\xe9.toml' $'\\xff.npz' --out $'\\xfe.npz'",
        "$TFRA view $'\\xfe.npz' --out $'\\xfd.html' --frames 0:2",
    )
    found = run(" && ".join(lines), tmp_path)
    assert (found.returncode, found.stderr) == (0, "")
    assert "\\udcfd.html: " in found.stdout
    assert sorted(os.listdir(os.fsencode(tmp_path))) == [b"caf\xe9.toml", b"\xfd.html", b"\xfe.npz", b"\xff.npz"]
    assert "\\udcfe" in (tmp_path / os.fsdecode(b"\xfd.html")).read_text(encoding="utf-8")


def test_warnings_are_ours(tmp_path: Path) -> None:
    found = run("$TFRA --version", tmp_path, PYTHONWARNINGS="error")
    assert (found.returncode, found.stdout, found.stderr) == (0, f"tfra {version('tfra')}\n", "")


def test_files_that_may_not_grow(tmp_path: Path) -> None:
    found = run(f"ulimit -f 1; exec $TFRA frames {EXAMPLES}/hertz_40x20.toml --out f.npz", tmp_path)
    assert (found.returncode, found.stderr) == (2, "f.npz: cannot be written: File too large\n")
    assert list(tmp_path.iterdir()) == []


SCRIPTS = {
    "while imported": "import os, signal; os.kill(os.getpid(), signal.SIGINT)",
    "dropped by a callback": """
import signal, sys, time
class Tidy:
    def __del__(self):
        signal.raise_signal(signal.SIGINT)
def main():
    tidy = Tidy()
    del tidy
    time.sleep(60)
""",
    "while running": "import signal\ndef main():\n    signal.raise_signal(signal.SIGINT)",
    "an error of ours": "def main():\n    return 1 // 0",
    "a full disk": "def main():\n    raise OSError(28, 'No space left on device', 'build')",
}


def replaced(script: str, tmp_path: Path) -> subprocess.CompletedProcess[str]:
    """Run the entry with another command line in place of ``tfra.cli.main``."""
    (tmp_path / "standin.py").write_text(script)
    start = (
        "import importlib.util, sys\n"
        "from tfra.cli import entry\n"
        "class Finder:\n"
        "    def find_spec(self, name, path=None, target=None):\n"
        "        if name == 'tfra.cli.main':\n"
        "            return importlib.util.spec_from_file_location(name, 'standin.py')\n"
        "sys.meta_path.insert(0, Finder())\n"
        "sys.exit(entry.main())\n"
    )
    return subprocess.run([sys.executable, "-c", start], capture_output=True, text=True, check=False, cwd=tmp_path)


@pytest.mark.parametrize(
    ("name", "code"), [("while imported", -signal.SIGINT), ("dropped by a callback", 130), ("while running", 130)]
)
def test_interruptions_are_quiet(tmp_path: Path, name: str, code: int) -> None:
    found = replaced(SCRIPTS[name], tmp_path)
    assert (found.returncode, found.stderr) == (code, "")


def test_errors_of_our_own(tmp_path: Path) -> None:
    found = replaced(SCRIPTS["an error of ours"], tmp_path)
    assert found.returncode == 70
    assert "ZeroDivisionError" in found.stderr
    assert found.stderr.endswith("this is a bug in tfra; please report it with the lines above\n")


def test_errors_of_the_system(tmp_path: Path) -> None:
    found = replaced(SCRIPTS["a full disk"], tmp_path)
    assert (found.returncode, found.stderr) == (1, "tfra: build: No space left on device\n")
