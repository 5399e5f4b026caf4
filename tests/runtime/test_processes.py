"""No started program outlives the one that started it, however that ends.  Linux only."""

import os
import random
import signal
import subprocess
import sys
import time
import uuid
from collections.abc import Mapping, Sequence
from pathlib import Path

import pytest

from tfra.cli.main import main
from tfra.codegen.verilog import emit as verilog
from tfra.runtime.ownership import directory_objection
from tfra.runtime.processes import Stopped, complaint, running, stoppable
from tfra.runtime.scratch import sweep

PATIENCE = 5.0
"""Seconds that killed processes have to disappear."""
MARK = "TFRA_KILL_MARK"
CONFIG = (Path(__file__).parents[2] / "examples" / "small.toml").read_text()
SIGNALS = (signal.SIGKILL, signal.SIGTERM, signal.SIGINT, signal.SIGHUP)

STARTER = """
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from tfra.runtime.processes import Stopped, running, stoppable

def work(_):
    stubborn = "trap '' TERM INT HUP; sh -c 'sleep 600' & echo started; sleep 600"
    with running(["sh", "-c", stubborn], Path(".")) as process:
        print(process.stdout.readline(), end="", flush=True)
        process.wait()

try:
    with stoppable(), ThreadPoolExecutor(2) as pool:
        list(pool.map(work, range(2)))
except Stopped as stopped:
    sys.exit(stopped.exit_code)
"""
"""Threads that wait for programs that hear no signal and have programs of their own."""


def survivors(
    command: Sequence[str], env: Mapping[str, str], delay: float, number: signal.Signals, directory: Path
) -> list[str]:
    """Start ``command``, send it alone the signal ``number`` after ``delay`` seconds, and return what survived it.

    Survivors are ``PID COMMAND`` of processes that the command started, directly or not.
    """
    mark = uuid.uuid4().hex
    quiet = {"stdin": subprocess.DEVNULL, "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    process = subprocess.Popen(command, env={**env, MARK: mark}, cwd=directory, preexec_fn=hear_signals, **quiet)
    try:
        process.wait(delay)
    except subprocess.TimeoutExpired:
        process.send_signal(number)
    process.wait()
    end = time.monotonic() + PATIENCE
    while (found := marked(mark)) and time.monotonic() < end:
        time.sleep(0.05)
    return found


def hear_signals() -> None:
    """Restore signals that ``nohup`` and shells make background processes ignore."""
    for number in SIGNALS[1:]:
        signal.signal(number, signal.SIG_DFL)


def marked(mark: str) -> list[str]:
    """Return ``PID COMMAND`` of every living process with ``mark`` in its environment."""
    found, needle = [], f"{MARK}={mark}".encode()
    for place in Path("/proc").glob("[0-9]*"):
        try:
            if needle in (place / "environ").read_bytes().split(b"\0"):
                words = (place / "cmdline").read_bytes().replace(b"\0", b" ").decode(errors="replace")
                found.append(f"{place.name} {words}")
        except OSError:  # it has ended
            continue
    return found


def become(mark: str, count: int) -> bool:
    """Whether there are ``count`` marked processes in the end: starting takes time, and so does init's reaping."""
    for _ in range(1000):
        if len(marked(mark)) == count:
            return True
        time.sleep(0.01)
    return False


@pytest.mark.parametrize("number", SIGNALS)
def test_a_signal_to_the_starter_ends_all(tmp_path: Path, number: signal.Signals) -> None:
    mark = uuid.uuid4().hex
    variables = {**os.environ, MARK: mark, "TMPDIR": str(tmp_path)}
    command = [sys.executable, "-c", STARTER]
    how = {"stdout": subprocess.PIPE, "text": True, "preexec_fn": hear_signals}
    with subprocess.Popen(command, env=variables, **how) as process:
        assert process.stdout is not None
        started = [process.stdout.readline() for _ in range(2)]
        all_there = become(mark, 1 + 2 * 5)
        process.send_signal(number)
    assert started == ["started\n"] * 2
    assert all_there
    assert process.returncode == (-number if number == signal.SIGKILL else 128 + number)
    assert become(mark, 0)
    sweep(tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_survivors_are_seen(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The check itself: a program that nobody looks after is found."""
    monkeypatch.setattr(sys.modules[__name__], "PATIENCE", 0.1)
    sleeper = "import subprocess, time; subprocess.Popen(['sleep', '600'], start_new_session=True); time.sleep(600)"
    found = survivors([sys.executable, "-c", sleeper], os.environ, 1.0, signal.SIGKILL, tmp_path)
    assert [line.split()[1:] for line in found] == [["sleep", "600"]]
    os.kill(int(found[0].split()[0]), signal.SIGKILL)


@pytest.mark.long
def test_a_command_killed_at_any_moment_leaves_its_output_whole(tmp_path: Path) -> None:
    """The old output or the new one, no process, and nothing of its own that the next run does not remove."""
    (tmp_path / "tiny.toml").write_text(CONFIG)
    (tmp_path / "tmp").mkdir()
    env = {**os.environ, "TFRA_CACHE": str(tmp_path / "cache"), "TMPDIR": str(tmp_path / "tmp")}
    script = "import sys; from tfra.cli.entry import main; sys.exit(main())"
    command = [sys.executable, "-c", script, "generate", "tiny.toml", "--out", "core"]
    start = time.monotonic()
    subprocess.run(command, env=env, cwd=tmp_path, check=True, capture_output=True)
    seconds, names = time.monotonic() - start, {path.name for path in tmp_path.iterdir()}
    rng = random.Random(1)
    for number in 2 * SIGNALS:
        assert survivors(command, env, rng.uniform(0, seconds), number, tmp_path) == []
        assert directory_objection(tmp_path / "core", "generate") is None
    subprocess.run(command, env=env, cwd=tmp_path, check=True, capture_output=True)
    assert {path.name for path in tmp_path.iterdir()} == names
    assert list((tmp_path / "tmp").iterdir()) == []


def test_a_program_runs_with_nothing_to_read_and_a_place_of_its_own(tmp_path: Path) -> None:
    script = 'cat; pwd; echo "$WORD"; touch "$TMPDIR/left"; echo "$TMPDIR"; echo wrong >&2; exit 3'
    with running(["sh", "-c", script], tmp_path, {**os.environ, "WORD": "two words"}) as process:
        printed, _ = process.communicate()
    here, word, folder, error = printed.splitlines()
    assert (here, word, error, process.returncode) == (str(tmp_path), "two words", "wrong", 3)
    assert not Path(folder).exists()


def test_what_a_program_leaves_running_is_ended(tmp_path: Path) -> None:
    mark = uuid.uuid4().hex
    leaving = ["sh", "-c", "sleep 600 > /dev/null 2>&1 &"]
    with running(leaving, tmp_path, {**os.environ, MARK: mark}) as process:
        process.wait()
    assert process.returncode == 0
    assert become(mark, 0)


@pytest.mark.parametrize(("script", "code"), [("kill -KILL $$", 137), ("kill -SEGV $$", 139), ("exit 7", 7)])
def test_exit_codes(tmp_path: Path, script: str, code: int) -> None:
    with running(["sh", "-c", script], tmp_path) as process:
        process.communicate()
    assert process.returncode == code


def test_a_missing_program_is_told(tmp_path: Path) -> None:
    with running(["nothing-like-this"], tmp_path) as process:
        printed, _ = process.communicate()
    assert complaint("it", process.returncode, printed) == "it failed: nothing-like-this: No such file or directory"


def test_a_signal_is_heard_once_and_only_in_the_block() -> None:
    before = signal.getsignal(signal.SIGTERM)
    steps = []

    def work() -> None:
        try:
            os.kill(os.getpid(), signal.SIGTERM)
            steps.append("not heard")
        finally:
            os.kill(os.getpid(), signal.SIGTERM)
            steps.append("cleaned")

    with pytest.raises(Stopped) as stopped, stoppable():
        work()
    assert steps == ["cleaned"]
    assert stopped.value.exit_code == 143
    assert signal.getsignal(signal.SIGTERM) is before


def test_an_ignored_signal_stays_ignored() -> None:
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        with stoppable():
            os.kill(os.getpid(), signal.SIGHUP)
    finally:
        signal.signal(signal.SIGHUP, before)


@pytest.mark.parametrize(
    ("code", "output", "line"),
    [
        (137, "much\nlog", "it failed: killed by SIGKILL: is there enough memory?"),
        (139, "", "it failed: killed by SIGSEGV"),
        (1, "Traceback\n  deep\nERROR: no such cell\nlast", "it failed: ERROR: no such cell"),
        (1, "Traceback\n  deep\nValueError: no\n\n", "it failed: ValueError: no"),
        (1, "E: mmap\n\nCaused by:\n  Cannot allocate memory (os error 12)\n", "it failed: "
            "Cannot allocate memory (os error 12): is there enough memory?"),
        (1, "g++: out\nfile.o: No space left on device\nmake: Error 1", "it failed: file.o: No space left on device"),
        (4, "", "it failed: exit code 4"),
    ],
)  # fmt: skip
def test_complaints(code: int, output: str, line: str) -> None:
    assert complaint("it", code, output) == line


@pytest.mark.long
def test_a_killed_yosys_is_told_in_a_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(verilog, "_YOSYS", "import os; os.kill(os.getpid(), 9)")
    config = tmp_path / "tiny.toml"
    config.write_text(CONFIG)
    assert main(["generate", str(config), "--out", str(tmp_path / "core")]) == 1
    assert capsys.readouterr().err == "tfra generate: yosys failed: killed by SIGKILL: is there enough memory?\n"
    assert [path.name for path in tmp_path.iterdir()] == ["tiny.toml"]
