"""Readers of bytes from outside against changed inputs: each may read them or refuse them in a line, and nothing else.

``python -m bench.scorecard.hostile.fuzz READER FIRST END`` tries the inputs of these numbers, and prints what was found
as JSON.
"""

import json
import mmap
import os
import resource
import signal
import struct
import subprocess
import sys
import tempfile
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import contextmanager
from itertools import repeat
from multiprocessing import get_context
from pathlib import Path
from random import Random
from typing import Any

from bench.publish import ROOT

SECONDS = 5
"""Of the processor that an input may take."""
STUCK = 60
"""Seconds after which a process has stopped for ever."""
MEMORY = 1 << 30
"""Bytes that a reader may take beyond what its process has."""
LINE = 1400
"""Characters of a refusal."""
PROCESSES = 2
WORKER = ("-m", "bench.scorecard.hostile.fuzz")


class Slow(BaseException):
    """An input took too long."""


def complaint(read: Any, data: bytes, refusals: tuple[type[Exception], ...]) -> str | None:
    """What is wrong with how ``read`` took ``data``: "" where it refused it, and None where it read it."""
    signal.setitimer(signal.ITIMER_PROF, SECONDS)
    try:
        read(data)
    except refusals as error:
        return "" if "\n" not in str(error) and len(str(error)) < LINE else f"not a line: {str(error)[:300]!r}"
    except BaseException as error:
        place = traceback.extract_tb(error.__traceback__)[-1]
        inside = [frame for frame in traceback.extract_tb(error.__traceback__) if str(ROOT) in frame.filename]
        where = f"{Path(inside[-1].filename).name}:{inside[-1].lineno}" if inside else ""
        return f"{type(error).__name__} at {where} ({Path(place.filename).name}): {str(error)[:200]}"
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
    return None


def limited() -> None:
    """Make warnings errors, and limit time and memory."""

    def stop(number: int, frame: object) -> None:
        raise Slow(f"more than {SECONDS} s")

    from tfra.runtime.errors import Notice

    signal.signal(signal.SIGPROF, stop)
    warnings.simplefilter("error")
    warnings.simplefilter("ignore", Notice)
    pages = int(Path("/proc/self/statm").read_text().split()[0])
    most = pages * mmap.PAGESIZE + MEMORY
    resource.setrlimit(resource.RLIMIT_AS, (most, resource.RLIM_INFINITY))


def tried(name: str, first: int, end: int, progress: mmap.mmap | None = None) -> dict[str, Any]:
    """What became of the inputs ``first`` to ``end`` of a reader: how many were read, refused, and what was found."""
    from bench.scorecard.hostile.readers import READERS

    reader, outcome = READERS[name], Counter[str]()
    findings: dict[str, list[Any]] = {}
    with tempfile.TemporaryDirectory() as folder:
        os.environ["TFRA_CACHE"] = folder
        draw, read = reader.make(Path(folder))
        limited()
        for number in range(first, end):
            if progress:
                struct.pack_into("<q", progress, 0, number)
            with warnings.catch_warnings(action="ignore"):
                data = draw(Random(f"{name} {number}"))
            found = complaint(read, data, reader.refusals)
            outcome["read" if found is None else "found" if found else "refused"] += 1
            if found:
                findings.setdefault(found.partition("): ")[0], [number, 0, found])[1] += 1
    return {"outcome": outcome, "findings": list(findings.values())}


@contextmanager
def _progress(path: Path) -> Iterator[mmap.mmap]:
    with open(path, "r+b") as stream, mmap.mmap(stream.fileno(), 8) as words:
        yield words


def watched(name: str, first: int, end: int) -> dict[str, Any]:
    """The same in processes of their own: one that dies or stops is a finding, and another goes on behind it."""
    outcome = Counter[str]()
    findings: list[list[Any]] = []
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "progress")
        while first < end:
            path.write_bytes(struct.pack("<q", first))
            command = [sys.executable, *WORKER, name, str(first), str(end), str(path)]
            with subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
                said, told = _awaited(process, path)
            if process.returncode == 0:
                found = json.loads(said)
                outcome.update(found["outcome"])
                return {"outcome": dict(outcome), "findings": findings + found["findings"]}
            (last,) = struct.unpack("<q", path.read_bytes())
            findings.append([last, 1, f"the process ended with {process.returncode}: {told[-300:].decode()}"])
            outcome["found"] += 1
            first = last + 1
    return {"outcome": dict(outcome), "findings": findings}


def _awaited(process: subprocess.Popen[bytes], path: Path) -> tuple[bytes, bytes]:
    """What the process prints; it is killed when it makes no progress."""
    last, since = path.read_bytes(), time.monotonic()
    while True:
        try:
            return process.communicate(timeout=2)
        except subprocess.TimeoutExpired:
            if (now := path.read_bytes()) != last:
                last, since = now, time.monotonic()
            elif time.monotonic() - since > STUCK:
                process.kill()


def brief(counts: dict[str, int]) -> dict[str, dict[str, Any]]:
    """The first inputs of each reader, all in one process, whose death raises ``BrokenProcessPool``."""
    with ProcessPoolExecutor(1, get_context("spawn"), _quiet) as pool:
        return dict(zip(counts, pool.map(tried, counts, repeat(0), counts.values()), strict=True))


def _quiet() -> None:
    """Drop what libraries print of damaged files."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), 2)


def campaign(counts: dict[str, int]) -> dict[str, dict[str, Any]]:
    """So many inputs of each reader."""
    with ThreadPoolExecutor(PROCESSES) as pool:
        return dict(zip(counts, pool.map(lambda name: watched(name, 0, counts[name]), counts), strict=True))


if __name__ == "__main__":
    reader_name, begin, stop_at, *places = sys.argv[1:]
    if places:
        with _progress(Path(places[0])) as shared:
            print(json.dumps(tried(reader_name, int(begin), int(stop_at), shared)))
    else:
        print(json.dumps(tried(reader_name, int(begin), int(stop_at)), indent=1))
