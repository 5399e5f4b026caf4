"""Commands killed at random moments: no process may stay, and the next run leaves no temporary file.

``python -m bench.kills [--kills N] [--seed S]`` kills N of each command and prints what stayed behind; exit code 1 if
anything did.  Linux only.
"""

from __future__ import annotations

import argparse
import os
import random
import re
import signal
import subprocess
import sys
import tempfile
import time
import uuid
from collections.abc import Mapping, Sequence
from pathlib import Path

PATIENCE = 5.0
"""Seconds that killed processes have to disappear."""
MARK = "TFRA_KILL_MARK"
SIGNALS = (signal.SIGKILL, signal.SIGTERM, signal.SIGINT, signal.SIGHUP)
ENTRY = re.compile(r"(core|build|gates|fem)-.+")

CONFIG = """[sensor]
rows = 2
columns = 2
pitch_x_mm = 4.0
pitch_y_mm = 4.0
thickness_mm = 3.0
[search]
steps = 4
[architecture]
mac_lanes = 1
[[contact]]
shape = "hertz"
half_x_mm = 2.0
half_y_mm = 2.0
force_n = -1.0
mu = 0.5
phi_deg = [0, 90]
"""


def kill_at_random(
    command: Sequence[str], env: Mapping[str, str], delay: float, number: signal.Signals, directory: Path | None = None
) -> list[str]:
    """Start ``command``, send it alone the signal ``number`` after ``delay`` seconds, and return what survived it.

    Survivors are ``PID COMMAND`` of processes that the command started, directly or not.
    """
    mark = uuid.uuid4().hex
    process = subprocess.Popen(
        command,
        env={**env, MARK: mark},
        cwd=directory,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    try:
        process.wait(delay)
    except subprocess.TimeoutExpired:
        process.send_signal(number)
    process.wait()
    end = time.monotonic() + PATIENCE
    while (found := marked(mark)) and time.monotonic() < end:
        time.sleep(0.05)
    return found


def marked(mark: str) -> list[str]:
    """Return ``PID COMMAND`` of every living process with ``mark`` in its environment."""
    found, needle = [], f"{MARK}={mark}".encode()
    for place in Path("/proc").iterdir():
        if place.name.isdigit():
            try:
                if needle in (place / "environ").read_bytes().split(b"\0"):
                    words = (place / "cmdline").read_bytes().replace(b"\0", b" ").decode(errors="replace")
                    found.append(f"{place.name} {words}")
            except OSError:  # it has ended
                continue
    return found


def leftovers(cache: Path, temporary: Path) -> list[str]:
    """Return what is in ``cache`` beside its entries, and all that is in ``temporary``."""
    entries = [path for path in cache.iterdir() if not ENTRY.fullmatch(path.name)] if cache.exists() else []
    return [str(path) for path in [*entries, *temporary.iterdir()]]


def commands(place: Path) -> dict[str, list[str]]:
    """Return the commands to kill, by name; they work on a small core in ``place``."""
    tfra = [sys.executable, "-c", "import sys; from tfra.cli.main import main; sys.exit(main())"]
    config, frames = str(place / "tiny.toml"), str(place / "frames.npz")
    return {
        "generate": [*tfra, "generate", config, "--out", str(place / "core")],
        "verify": [*tfra, "verify", config, "--random", "20", "--simulator", "icarus"],
        "verify verilator": [*tfra, "verify", config, "--random", "20", "--simulator", "verilator"],
        "estimate": [*tfra, "estimate", config, frames, "--engine", "rtl", "--out", str(place / "forces.npz")],
        "synth": [*tfra, "synth", config, "--target", "ecp5-25", "--seeds", "1", "--out", str(place / "fpga")],
    }


def campaign(name: str, kills: int, rng: random.Random, place: Path) -> list[str]:
    """Kill the command ``name`` at random moments of its work; return all that survived or was left behind."""
    cache, temporary = place / "cache", place / "tmp"
    temporary.mkdir()
    (place / "tiny.toml").write_text(CONFIG)
    env = {**os.environ, "TFRA_CACHE": str(cache), "TMPDIR": str(temporary)}
    listed = commands(place)
    frames = ["frames", str(place / "tiny.toml"), "--out", str(place / "frames.npz")]
    subprocess.run([*listed["generate"][:3], *frames], env=env, check=True, capture_output=True)
    whole, found = _timed(listed[name], env), list[str]()
    for turn in range(kills):
        if turn % 2 == 0:  # else it goes on from what is there
            for entry in cache.glob("*") if cache.exists() else ():
                entry.unlink() if entry.is_file() else None
        number, delay = SIGNALS[turn % len(SIGNALS)], rng.uniform(0, whole)
        stayed = kill_at_random(listed[name], env, delay, number, place)
        found += [f"{name}: {number.name} after {delay:.2f} s: {each} lives" for each in stayed]
    subprocess.run(listed[name], env=env, cwd=place, check=True, capture_output=True)
    return found + [f"{name}: {each} is left" for each in leftovers(cache, temporary)]


def _timed(command: Sequence[str], env: Mapping[str, str]) -> float:
    start = time.monotonic()
    subprocess.run(command, env=env, check=True, capture_output=True)
    return time.monotonic() - start


def main() -> int:
    """Kill every command."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kills", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    rng, bad = random.Random(options.seed), 0
    for name in commands(Path()):
        with tempfile.TemporaryDirectory() as place:
            found = campaign(name, options.kills, rng, Path(place))
        bad += len(found)
        print("\n".join([f"{name}: {options.kills} kills, {len(found)} left behind", *found]), flush=True)
    return int(bad > 0)


if __name__ == "__main__":
    sys.exit(main())
