"""Programs that are killed, and what survives them.  Linux only."""

import signal
import subprocess
import time
import uuid
from collections.abc import Mapping, Sequence
from pathlib import Path

PATIENCE = 5.0
"""Seconds that killed processes have to disappear."""
MARK = "TFRA_KILL_MARK"
SIGNALS = (signal.SIGKILL, signal.SIGTERM, signal.SIGINT, signal.SIGHUP)

CONFIG = """[sensor]
rows = 2
columns = 2
pitch_x_mm = 4.0
pitch_y_mm = 4.0
thickness_mm = 3.0
[search]
steps = 4
[architecture]
mac_lanes = 4
[[contact]]
shape = "hertz"
half_x_mm = 2.0
half_y_mm = 2.0
force_n = -1.0
mu = 0.5
phi_deg = [0, 90]
"""


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
