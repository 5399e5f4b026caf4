"""The working folder of a study: its frames, finished pieces and trials, and a page of the results so far.

Everything in it is stored as soon as it is finished, so a study continues after any interruption.  The folder belongs
to one state of the sources, since others might compute different results.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from tfra.runtime.pieces import Pieces, put
from tfra.runtime.workfolder import held
from tfra.sim.run import digest
from tfra.study.frames.frameset import Definition, FrameSet
from tfra.study.search.trials import sqlite
from tfra.study.tasks import Task
from tfra.study.workers import fingerprint

PARTIAL = "partial.html"


@dataclass(frozen=True)
class Work:
    """A folder, held by this process alone."""

    folder: Path

    def frames(self, definition: Definition) -> FrameSet:
        """The frame set; raises ``InputError`` if the folder has frames of another definition."""
        return FrameSet.create(self.folder / "frames", definition)

    def pieces(self, task: Task) -> Pieces:
        """Finished pieces of a task of this description; raises ``InputError``."""
        key = digest(fingerprint(), repr(task))
        pieces = Pieces(self.folder / "pieces" / f"{task.name}-{key}", key, ".piece")
        pieces.create()
        return pieces

    @property
    def trials(self) -> str:
        """URL of the table of trials."""
        return sqlite(self.folder / "trials.sqlite")

    def show(self, page: str) -> None:
        """Write the page of the results so far."""
        put(self.folder, PARTIAL, page.encode())


@contextmanager
def opened_work(folder: Path) -> Iterator[Work]:
    """Hold ``folder``, which is made if it is missing.

    Raises ``InputError`` where it has other contents, is of other sources, or is held by another run.
    """
    with held(folder, "study", fingerprint()):
        yield Work(folder)
