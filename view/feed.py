"""From frames as they come to what a page asks for: estimated by one thread, kept for some seconds, never queued.

    read, a thread ──▶ waiting: the latest frames ──▶ run, the main thread ──▶ pieces: seconds ──▶ since, each page
"""

import json
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from threading import Condition
from typing import Any, Protocol

import numpy as np

from tfra.model.arrays import Floats
from tfra.recordings.streams import reason
from tfra.view.pack import MOST_BYTES, packed

SECONDS = 10.0
"""How long frames are kept."""

MOST = 2000
"""Frames that are kept, if there is room for as many."""

_WAITING = 64
"""Frames that wait for the estimator; when more arrive, the oldest are dropped."""

_PERIOD = 0.01
"""Seconds between two pieces; screens are not faster."""

_MESSAGES = {
    "waiting": "Waiting for the first frame of {source}.",
    "running": "Receiving frames from {source}.",
    "ended": "{source} has ended.",
    "empty": "{source} has ended without a frame.",
    "broken": "{source} broke: {reason}.",
}
"""What a page says of the source, by its state."""

Arrival = tuple[int, float, Floats]
"""The number of a frame, its time of arrival in s since 1970, and the frame ``(rows, columns)`` in Pa."""


class Tare(Protocol):
    """What takes the next frames for the array at rest."""

    @property
    def told(self) -> str:
        """What a page says of the tare."""

    def again(self) -> None:
        """Take a new one, whatever thread asks."""


@dataclass(frozen=True)
class Batch:
    """Frames that were estimated together, as JSON."""

    last: int
    when: float
    count: int
    text: str


class Feed:
    """Frames of ``source`` on their way to pages.

    ``result`` makes of frames ``(n, rows, columns)`` what a page's script reads, in ``each`` bytes a frame.  Locked by
    ``_changed``, which is notified of changes.
    """

    def __init__(self, source: str, result: Callable[[Floats], dict[str, Any]], each: int) -> None:
        self.source = source
        self.most = max(_WAITING, min(MOST, MOST_BYTES // each))
        """Frames that are kept."""
        self.keep: Callable[[Floats], None] | None = None
        """Called with the times in s of the frames whose result was just made."""
        self.tare: Tare | None = None
        """What can take a new tare."""
        self._result = result
        self._changed = Condition()
        self._waiting: deque[Arrival] = deque(maxlen=_WAITING)
        self._pieces: deque[Batch] = deque()
        self._busy = False
        self._begun = 0.0
        self._state = "waiting"
        self._reason = ""
        self._first_fault = ""
        self._readers = 0
        self._shown = False
        self.counts = {"came": 0, "estimated": 0, "drawn": 0, "malformed": 0}

    def read(self, frames: Iterable[Floats | str], report: Callable[[str], None]) -> None:
        """Take frames until there are no more; a text says what is wrong with a line: ``report`` gets the first."""
        try:
            for frame in frames:
                with self._changed:
                    if isinstance(frame, str):
                        self.counts["malformed"] += 1
                        if not self._first_fault:
                            self._first_fault = frame
                            report(frame)
                    else:
                        now = time.time()
                        if not self.counts["came"]:
                            self._begun, self._state = now, "running"
                        self._waiting.append((self.counts["came"], now, frame))
                        self.counts["came"] += 1
                    self._changed.notify_all()
            state, cause = "ended", ""
        except OSError as error:
            state, cause = "broken", reason(error)
        with self._changed:
            self._state, self._reason = state, cause
            self._changed.notify_all()

    def run(self) -> None:
        """Estimate arriving frames until the source ends."""
        while True:
            began = time.monotonic()
            with self._changed:
                self._changed.wait_for(lambda: self._waiting or self._over)
                if not self._waiting:
                    return
                frames = list(self._waiting)
                self._waiting.clear()
                self._busy = True
            batch = self._batch(frames)
            with self._changed:
                self._keep(batch)
                self._busy = False
                self.counts["estimated"] += batch.count
                self._changed.notify_all()
            time.sleep(max(0.0, began + _PERIOD - time.monotonic()))

    def _batch(self, frames: list[Arrival]) -> Batch:
        count = len(frames)
        numbers, when, stress = map(np.array, zip(*frames, strict=True))
        results, times = [self._result(stress)], when - self._begun
        if self.keep:
            self.keep(times)
        content = {
            "numbers": packed(numbers, "float64"),
            "time": packed(times, "float64"),
            "results": results,
            "came": when[-1],
        }
        text = json.dumps(content, separators=(",", ":"))
        return Batch(int(numbers[-1]), when[-1], count, text)

    def _keep(self, batch: Batch) -> None:
        self._pieces.append(batch)
        stored = sum(batch.count for batch in self._pieces)
        while stored > self.most or self._pieces[0].when < batch.when - SECONDS:
            stored -= self._pieces.popleft().count

    @property
    def _over(self) -> bool:
        """Whether every frame that came has been estimated, and no more come."""
        return self._state in ("ended", "broken") and not (self._waiting or self._busy)

    @contextmanager
    def reading(self) -> Iterator[Callable[[], None]]:
        """A page reads frames in the block; it calls what it gets when it has the last one of all."""

        def shown() -> None:
            self._shown = True

        with self._changed:
            self._readers += 1
        try:
            yield shown
        finally:
            with self._changed:
                self._readers -= 1
                self._changed.notify_all()

    @property
    def is_read(self) -> bool:
        """Whether a page reads, or has the last frame of all."""
        return self._shown or self._readers > 0

    def wait_for_pages(self, *, one: bool) -> None:
        """Wait until no page reads; with ``one`` until one has the last frame of all, too."""
        with self._changed:
            self._changed.wait_for(lambda: not self._readers and (self._shown or not one))

    def since(self, after: int, patience: float) -> tuple[str, int, bool]:
        """What a page gets: the state, the counts, and the pieces behind frame ``after``, in JSON.

        Returns the number of the last frame, too, and whether it is the last of all.  Without any it waits for
        ``patience`` seconds, or until the source has ended.
        """
        with self._changed:
            self._changed.wait_for(lambda: self._over or (self._pieces and self._pieces[-1].last > after), patience)
            pieces = [batch for batch in self._pieces if batch.last > after]
            over = self._over and not pieces
            state = {"state": self._state, "message": self._message(), "fault": self._first_fault, "over": over}
            state |= self.counts
            state |= {"tare": self.tare.told} if self.tare else {}
        texts = ",".join(batch.text for batch in pieces)
        return f'{json.dumps(state)[:-1]},"pieces":[{texts}]}}', pieces[-1].last if pieces else after, over

    def count_drawn(self, count: int) -> None:
        """Count frames that a page has drawn."""
        with self._changed:
            self.counts["drawn"] += count

    def _message(self) -> str:
        state = "empty" if self._state == "ended" and not self.counts["came"] else self._state
        return _MESSAGES[state].format(source=self.source, reason=self._reason)

    def totals(self) -> str:
        """The counts of frames, in a line."""
        counts = self.counts
        wrong = f"; malformed lines: {counts['malformed']:,}" if counts["malformed"] else ""
        came, estimated, drawn = (f"{counts[key]:,}" for key in ("came", "estimated", "drawn"))
        return f"{came} frames came, {estimated} were estimated, {drawn} drawn{wrong}"
