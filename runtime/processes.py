"""Programs that this one starts: none of them outlives it, and all temporary files of theirs go with them."""

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from types import FrameType
from typing import IO

from tfra.runtime.scratch import scratch, temporary
from tfra.runtime.store import cache_directory

_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
_GONE, _STEP = 1.0, 0.005
"""Seconds that killed processes are waited for, and between two looks."""

_MEMORY = ": is there enough memory?"
_LACKS = {
    "No space left on device": "",
    "Cannot allocate memory": _MEMORY,
    "bad_alloc": _MEMORY,
    "Killed signal terminated program": _MEMORY,
}
"""What programs say that fail for reasons beyond their input, and what to add to that."""

_SUPERVISOR = """
import os, signal, sys
from _thread import start_new_thread

def watch():
    while os.read(0, 1):
        pass
    os.killpg(0, signal.SIGKILL)

start_new_thread(watch, ())
program, *arguments = sys.argv[1:]
nothing = (os.POSIX_SPAWN_OPEN, 0, os.devnull, os.O_RDONLY, 0)
try:
    child = os.posix_spawnp(program, [program, *arguments], os.environ, file_actions=[nothing])
except OSError as error:
    sys.exit(print(f"{program}: {error.strerror}", file=sys.stderr) or 127)
code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
sys.exit(code if code >= 0 else 128 - code)
"""
"""Runs the command in its arguments, as the head of a process group.  Exit code: the command's, or 128 and the signal
that ended it.  Its standard input is a pipe without data, which closes when the starter ends for any reason; then it
kills every process of the group."""

_running: set[int] = set()
"""Process groups."""
_stopping = threading.Event()


class ToolError(RuntimeError):
    """A program failed; the message says how."""


class Stopped(BaseException):
    """This process was asked to end by the signal ``number``."""

    def __init__(self, number: int) -> None:
        super().__init__(signal.Signals(number).name)
        self.number = number

    @property
    def exit_code(self) -> int:
        """What a shell expects of a program that a signal ended."""
        return 128 + self.number


@contextmanager
def stoppable() -> Iterator[None]:
    """Within the block the first SIGINT, SIGTERM or SIGHUP raises :class:`Stopped` in the main thread.

    Started programs are killed before, so that no thread goes on waiting for one.  Further signals are ignored, since
    cleaning up is short.  A signal that is ignored stays so, as ``nohup`` wants it.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    ignored = None, signal.SIG_IGN
    before = {number: handler for number in _SIGNALS if (handler := signal.getsignal(number)) not in ignored}
    try:
        for number in before:
            signal.signal(number, _stop)
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        _stopping.clear()


def _stop(number: int, frame: FrameType | None) -> None:
    if _stopping.is_set():
        return
    _stopping.set()
    for group in list(_running):
        _kill(group)
    raise Stopped(number)


@contextmanager
def running(
    command: Sequence[str],
    directory: Path,
    environment: Mapping[str, str] | None = None,
    *,
    stdout: int | IO[str] = subprocess.PIPE,
    stderr: int = subprocess.STDOUT,
) -> Iterator[subprocess.Popen[str]]:
    """Start ``command`` in ``directory``, with nothing to read and a folder for temporary files of its own.

    It and whatever it starts are killed when the block ends, and when this process does in whatever way.
    """
    with scratch(temporary()) as folder:
        variables = {**(os.environ if environment is None else environment), **_yowasp(), "TMPDIR": str(folder)}
        supervised = [sys.executable, "-I", "-S", "-c", _SUPERVISOR, *command]
        read_end, write_end = os.pipe()
        try:
            with subprocess.Popen(
                supervised,
                cwd=directory,
                env=variables,
                stdin=read_end,
                stdout=stdout,
                stderr=stderr,
                text=True,
                errors="replace",
                start_new_session=True,
            ) as process:
                _running.add(process.pid)
                try:
                    if _stopping.is_set():
                        raise ToolError(f"{command[0]} was not started: this process ends")
                    yield process
                finally:
                    _kill(process.pid)
                    _running.discard(process.pid)
                    process.wait()
                    _await_end(process.pid)
        finally:
            os.close(read_end)
            os.close(write_end)


def _yowasp() -> dict[str, str]:
    """Where YoWASP's programs are to keep what they compile, if they can't do so in their own place."""
    default = Path(os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache"), "YoWASP")
    folder = Path(os.environ.get("YOWASP_CACHE_DIR", default)).absolute()
    existing = next(each for each in (folder, *folder.parents) if os.path.exists(each))
    usable = existing.is_dir() and os.access(existing, os.W_OK | os.X_OK)
    return {} if usable else {"YOWASP_CACHE_DIR": str(cache_directory() / "YoWASP")}


def _kill(group: int) -> None:
    with suppress(ProcessLookupError, PermissionError):  # the latter is what some systems say of a dead one
        os.killpg(group, signal.SIGKILL)


def _await_end(group: int) -> None:
    """Wait until no process of a killed ``group`` can write anything."""
    patience = time.monotonic() + _GONE
    with suppress(ProcessLookupError, PermissionError):
        while time.monotonic() < patience:
            os.killpg(group, 0)
            time.sleep(_STEP)


def complaint(program: str, code: int, output: str) -> str:
    """Say in one line why ``program`` ended with exit ``code``; ``output`` is what it printed."""
    lines = [line.strip() for line in output.splitlines() if line.strip()]
    errors = [line for line in lines if line.startswith("ERROR")]
    return f"{program} failed: {beyond(code, output) or [f'exit code {code}', *lines[-1:], *errors[:1]][-1]}"


def beyond(code: int, output: str) -> str:
    """Say in one line what beyond its input made a program fail, or nothing.

    That is a signal, which an exit ``code`` above 128 tells, or something it has told itself in its ``output``.
    """
    try:
        name = signal.Signals(code - 128).name
    except ValueError:
        lines = [line.strip() for line in output.splitlines()]
        found = [line + advice for line in lines for words, advice in _LACKS.items() if words in line]
        return found[0] if found else ""
    return f"killed by {name}" + (_MEMORY if name == "SIGKILL" else "")
