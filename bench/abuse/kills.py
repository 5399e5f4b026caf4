"""Commands killed at random moments: no process survives, outputs are complete, and the next run removes all remains.

Slow commands are killed less often.  Linux only; ``python -m bench.abuse.abuse "kills of frames"`` runs it at full
scale.
"""

from __future__ import annotations

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
from dataclasses import dataclass
from pathlib import Path

from tfra.runtime.ownership import directory_objection, file_objection

PATIENCE = 5.0
"""Seconds that killed processes have to disappear."""
MARK = "TFRA_KILL_MARK"
SIGNALS = (signal.SIGKILL, signal.SIGTERM, signal.SIGINT, signal.SIGHUP)
TFRA = (sys.executable, "-c", "import sys; from tfra.cli.entry import main; sys.exit(main())")
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
mac_lanes = 4
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
        preexec_fn=hear_signals,
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


def hear_signals() -> None:
    """Restore signals that ``nohup`` and shells make background processes ignore."""
    for number in SIGNALS[1:]:
        signal.signal(number, signal.SIG_DFL)


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
    """Return the files in ``cache`` that are not entries, and all files in ``temporary``."""
    entries = [path for path in cache.iterdir() if not ENTRY.fullmatch(path.name)] if cache.exists() else []
    return [str(path) for path in [*entries, *temporary.iterdir()]]


@dataclass(frozen=True)
class Victim:
    """A command to kill, its ``arguments`` in a folder of its own, and what it writes there, if anything.

    ``share`` of the kills: fewer for what takes long.
    """

    arguments: str
    out: str = ""
    share: float = 1.0

    @property
    def words(self) -> list[str]:
        """The command line."""
        return [*TFRA, *self.arguments.split(), *(["--out", self.out] if self.out else [])]

    def times(self, kills: int) -> int:
        """Number of kills of this command if others are killed ``kills`` times."""
        return round(self.share * kills)

    def objection(self, place: Path) -> str | None:
        """Return what is wrong with the output, which was complete before."""
        if not self.out:
            return None
        if not (place / self.out).exists():
            return f"{self.out} is gone"
        kind = file_objection if self.out.endswith(".npz") else directory_objection
        return kind(place / self.out, self.arguments.split()[0])


VICTIMS = {
    "frames": Victim("frames tiny.toml", "simulated.npz"),
    "estimate": Victim("estimate tiny.toml frames.npz --engine rtl", "forces.npz", share=0.25),
    "generate": Victim("generate tiny.toml", "core"),
    "verify": Victim("verify tiny.toml --random 20 --simulator icarus"),
    "synth": Victim("synth tiny.toml --target xc7", "fpga", share=0.6),  # yosys alone
    "synth with nextpnr": Victim("synth tiny.toml --target ecp5-25 --seeds 1 --clock-mhz 20", "fpga", share=0.07),
    "paper": Victim("paper", "again"),
}


def campaign(victim: Victim, kills: int, rng: random.Random, place: Path) -> list[str]:
    """Kill the command at random moments; return everything that survived, was damaged or remained."""
    cache, temporary, notes = place / "cache", place / "tmp", place / "notes.txt"
    temporary.mkdir()
    (place / "tiny.toml").write_text(CONFIG)
    notes.write_text("years of work")
    env = {**os.environ, "TFRA_CACHE": str(cache), "TMPDIR": str(temporary)}
    subprocess.run(Victim("frames tiny.toml", "frames.npz").words, env=env, cwd=place, check=True, capture_output=True)
    whole, found = _timed(victim.words, env, place), list[str]()
    names = {path.name for path in place.iterdir()}
    for turn in range(kills):
        if turn % 2 == 0:  # otherwise it continues from the existing files
            for entry in cache.glob("*") if cache.exists() else ():
                entry.unlink() if entry.is_file() else None
        number, delay = SIGNALS[turn % len(SIGNALS)], rng.uniform(0, whole)
        stayed = kill_at_random(victim.words, env, delay, number, place)
        wrong = [f"{each} lives" for each in stayed] + [text for text in [victim.objection(place)] if text]
        found += [f"{number.name} after {delay:.2f} s: {each}" for each in wrong]
    subprocess.run(victim.words, env=env, cwd=place, check=True, capture_output=True)
    left = {path.name for path in place.iterdir()} ^ names
    found += [f"{each} is left or gone" for each in [*leftovers(cache, temporary), *sorted(left)]]
    return found + (["notes.txt has changed"] if notes.read_text() != "years of work" else [])


def _timed(command: Sequence[str], env: Mapping[str, str], place: Path) -> float:
    start = time.monotonic()
    subprocess.run(command, env=env, cwd=place, check=True, capture_output=True)
    return time.monotonic() - start


def kill(name: str, kills: int, seed: int) -> list[str]:
    """Kill the command ``name`` its share of ``kills`` times, and print and return the faults."""
    with tempfile.TemporaryDirectory() as place:
        found = campaign(VICTIMS[name], VICTIMS[name].times(kills), random.Random(seed), Path(place))
    print("\n  ".join([f"{name}: {VICTIMS[name].times(kills)} kills, {len(found)} wrong", *found]), flush=True)
    return found
