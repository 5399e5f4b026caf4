"""Reads an output while three writers replace it repeatedly: it must exist and be complete every time.

``python -m bench.abuse.abuse looks`` runs it at full scale.
"""

from __future__ import annotations

import multiprocessing
import os
import tempfile
from collections import Counter
from collections.abc import Callable
from multiprocessing.synchronize import Event
from pathlib import Path

import numpy as np

from tfra.runtime.outputs import output_directory, write_npz
from tfra.runtime.ownership import directory_objection, file_objection

WRITERS = 3
FILES = 40
BYTES = 5000


def write_directory(out: Path, turn: int) -> None:
    """An output the size of a generated core."""
    with output_directory(out, "generate") as fresh:
        for number in range(FILES):
            (fresh / f"lane_{number}.hex").write_bytes(bytes([turn % 256]) * BYTES)


def write_archive(out: Path, turn: int) -> None:
    """A result of a few frames."""
    write_npz(out, {"forces": np.full(FILES * BYTES // 8, turn)}, "estimate")


KINDS: dict[str, tuple[Callable[[Path, int], None], Callable[[Path], str | None]]] = {
    "directory": (write_directory, directory_objection),
    "archive": (write_archive, file_objection),
}


def look(out: Path, objection: Callable[[Path], str | None]) -> str:
    """Read all of ``out`` and return its state: "whole", "exchanged" during the look, "absent" or what is wrong with
    it.

    Files are opened one after the other by their path, so that a directory may be exchanged in between; its number
    and the time of its last change tell.
    """
    try:
        before = out.stat()
    except FileNotFoundError:
        return "absent"
    try:
        wrong = objection(out)
    except OSError as error:
        wrong = str(error)
    after = out.stat()
    if wrong and (before.st_ino, before.st_ctime_ns) != (after.st_ino, after.st_ctime_ns):
        return "exchanged"
    return wrong or "whole"


def _write(kind: str, out: Path, end: Event) -> None:
    turn = os.getpid()
    while not end.is_set():
        turn += 1
        KINDS[kind][0](out, turn)


def looks(kind: str, count: int) -> Counter[str]:
    """Look ``count`` times; counts by state.  Raises ``RuntimeError`` if a writer failed or left something."""
    write, objection = KINDS[kind]
    with tempfile.TemporaryDirectory() as directory:
        out, end = Path(directory) / "out", multiprocessing.Event()
        write(out, 0)
        writers = [multiprocessing.Process(target=_write, args=(kind, out, end)) for _ in range(WRITERS)]
        for writer in writers:
            writer.start()
        found = Counter(look(out, objection) for _ in range(count))
        end.set()
        for writer in writers:
            writer.join()
        if any(writer.exitcode for writer in writers) or os.listdir(directory) != ["out"]:
            raise RuntimeError(f"writers ended with {[w.exitcode for w in writers]} and left {os.listdir(directory)}")
    return found
