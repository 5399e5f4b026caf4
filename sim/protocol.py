"""Common parts of the testbenches of all simulators: stalls, stream rules, the scoreboard, the job and its outcome.

Nothing here depends on a simulator, so all of it can be tested without one.
"""

from __future__ import annotations

import json
import os
import random
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np

from tfra.model.arrays import Ints

MOST_NOTES = 20
"""Violations and mismatches that are kept; all of them are counted."""


def flowing(rng: random.Random) -> Iterator[bool]:
    """Never stall."""
    while True:
        yield False


def random_stalls(rng: random.Random) -> Iterator[bool]:
    """Stall every other cycle, at random."""
    while True:
        yield rng.random() < 0.5


def bursts(rng: random.Random) -> Iterator[bool]:
    """Long runs of flow and of silence."""
    while True:
        yield from [False] * rng.randrange(1, 30)
        yield from [True] * rng.randrange(1, 30)


Pattern = Callable[[random.Random], Iterator[bool]]
"""Endless: True where a port stalls."""

STALLS: dict[str, Pattern] = {"none": flowing, "random": random_stalls, "bursts": bursts}
"""Patterns by name."""


def stalls(name: str, seed: int, port: str) -> Iterator[bool]:
    """Return an endless pattern, True where ``port`` stalls; equal arguments give equal patterns."""
    if name not in STALLS:
        raise ValueError(f"stall: one of {', '.join(STALLS)} is needed, got {name!r}")
    return STALLS[name](random.Random(f"{seed} {port}"))


class Violations:
    """Descriptions of broken rules: the first ``MOST_NOTES`` are kept, all are counted."""

    def __init__(self) -> None:
        self.notes: list[str] = []
        self.count = 0

    def add(self, note: str) -> None:
        """Note one broken rule."""
        self.count += 1
        if len(self.notes) < MOST_NOTES:
            self.notes.append(note)


class StreamRules:
    """Rules of a result stream: valid and payload are stable until ready, ``last`` ends each frame."""

    def __init__(self, frame_words: int, violations: Violations) -> None:
        self._frame_words = frame_words
        self._violations = violations
        self._held: tuple[int, int] | None = None
        self.taken = 0

    def idle(self) -> None:
        """Check a clock edge without valid."""
        if self._held is not None:
            self._violations.add(f"{self._where()}: valid was withdrawn before the word was taken")
            self._held = None

    def word(self, data: int, last: int, ready: bool) -> bool:
        """Check a clock edge with valid; True if it is a transfer."""
        if self._held is not None and self._held != (data, last):
            change = f"from {self._held} to {(data, last)}"
            self._violations.add(f"{self._where()}: payload changed {change} before it was taken")
        self._held = None if ready else (data, last)
        if ready:
            ends = (self.taken + 1) % self._frame_words == 0
            if bool(last) != ends:
                self._violations.add(f"{self._where()}: last is {'missing' if ends else 'set too early'}")
            self.taken += 1
        return ready

    def surplus(self) -> None:
        """Note a word after the last frame."""
        self._violations.add(f"a word follows the last frame, of {self._frame_words} words")

    def _where(self) -> str:
        frame, word = divmod(self.taken, self._frame_words)
        return f"frame {frame}, word {word}"


class Scoreboard:
    """Compare words in order with the expected ones; without expected words it only collects."""

    def __init__(self, expected: Sequence[int] | None) -> None:
        self._expected = expected
        self.observed: list[int] = []
        self.compared = 0
        self.mismatches = 0
        self.first: list[tuple[int, int, int]] = []
        """First mismatches: number of the word, expected, observed."""

    def take(self, word: int) -> None:
        """Take the next word."""
        place = len(self.observed)
        self.observed.append(word)
        if self._expected is None or place >= len(self._expected):
            return
        self.compared += 1
        if self._expected[place] != word:
            self.mismatches += 1
            if len(self.first) < MOST_NOTES:
                self.first.append((place, self._expected[place], word))


@dataclass(frozen=True)
class Probe:
    """A stream between blocks, watched from outside: two signals below the top module, names joined by dots."""

    stage: str
    transfer: str
    """High in the cycles in which the stream transfers."""
    words: str
    """The words of a transfer, the first lowest."""
    layout: tuple[tuple[int, bool], ...]
    """Bits, and whether signed, of each word."""
    transfers: int
    """Transfers of a frame."""

    def unpack(self, packed: Sequence[int]) -> list[int]:
        """Return the words of transfers in order."""
        words = []
        for value in packed:
            for bits, signed in self.layout:
                words.append(signed_word(value, bits) if signed else value & ((1 << bits) - 1))
                value >>= bits
        return words


def signed_word(pattern: int, bits: int) -> int:
    """Return the low ``bits`` of ``pattern`` as a two's complement number."""
    half = 1 << (bits - 1)
    return ((pattern & (2 * half - 1)) ^ half) - half


@dataclass(frozen=True)
class Job:
    """The job of a testbench.  Words and codes are two's complement patterns, that is, unsigned."""

    codes: Ints
    """Taxel codes of all frames, ``(n * taxels,)``."""
    taxels: int
    frame_words: int
    expected: Ints | None = None
    coefficients: Ints | None = None
    """Words for the ``load`` port, if the core has one, before the first frame."""
    seed: int = 0
    stall_in: str = "none"
    stall_out: str = "none"
    patience: int = 200_000
    """Cycles without any transfer after which the core hangs."""
    drain: int = 256
    """Cycles after the last frame in which no word may follow."""
    probes: tuple[Probe, ...] = ()

    @property
    def frames(self) -> int:
        """Frames sent and expected back."""
        return len(self.codes) // self.taxels

    def save(self, path: Path) -> None:
        """Write the job for another process."""
        rest = {key: getattr(self, key) for key in _PLAIN} | {"probes": [asdict(p) for p in self.probes]}
        words = {key: getattr(self, key) for key in ("codes", "expected", "coefficients")}
        given = {key: value for key, value in words.items() if value is not None}
        np.savez(path, **given, rest=np.array(json.dumps(rest)))

    @classmethod
    def load(cls, path: Path) -> Job:
        """Read what ``save`` wrote."""
        with np.load(path) as file:
            words, rest = {key: file[key] for key in file if key != "rest"}, json.loads(str(file["rest"]))
        rest["probes"] = tuple(
            Probe(**{**probe, "layout": tuple((bits, sign) for bits, sign in probe["layout"])})
            for probe in rest["probes"]
        )
        return cls(**words, **rest)


_PLAIN = ("taxels", "frame_words", "seed", "stall_in", "stall_out", "patience", "drain")


@dataclass
class Outcome:
    """The outcome of a testbench.  Cycles count clock edges from the end of reset."""

    words: list[int] = field(default_factory=list)
    violations: list[str] = field(default_factory=list)
    compared: int = 0
    mismatches: int = 0
    last_taxel: list[int] = field(default_factory=list)
    first_word: list[int] = field(default_factory=list)
    last_word: list[int] = field(default_factory=list)
    cycles: int = 0
    probes: list[list[int]] = field(default_factory=list)
    """Per probe, the packed words of every transfer."""

    def save(self, path: Path) -> None:
        """Write the outcome, completely or not at all."""
        fresh = path.with_name(f".{path.name}.{os.getpid()}")
        with open(fresh, "w") as stream:
            json.dump(asdict(self), stream)
        os.replace(fresh, path)

    @classmethod
    def load(cls, path: Path) -> Outcome:
        """Read what ``save`` wrote."""
        return cls(**json.loads(path.read_text()))


class Record:
    """The outcome in the making: scoreboard, rules and frame marks of one run."""

    def __init__(self, job: Job) -> None:
        self.job = job
        self.violations = Violations()
        self.rules = StreamRules(job.frame_words, self.violations)
        self.scoreboard = Scoreboard(None if job.expected is None else job.expected.tolist())
        self.loaded = self.sent = 0
        self.cycles = 0
        self.last_taxel: list[int] = []
        self.first_word: list[int] = []
        self.last_word: list[int] = []
        self.probes: list[list[int]] = [[] for _ in job.probes]

    @property
    def transfers(self) -> int:
        """Transfers of all ports, a measure of progress."""
        return self.loaded + self.sent + self.rules.taken

    @property
    def missing(self) -> int:
        """Words still to come."""
        return self.job.frames * self.job.frame_words - self.rules.taken

    def coefficient_sent(self) -> None:
        """Count a coefficient."""
        self.loaded += 1

    def taxel_sent(self, cycle: Callable[[], int]) -> None:
        """Count a taxel; ``cycle`` is asked at the end of a frame only."""
        self.sent += 1
        if self.sent % self.job.taxels == 0:
            self.last_taxel.append(cycle())

    def word_seen(self, data: int, last: int, ready: bool, cycle: Callable[[], int]) -> bool:
        """Check a cycle with valid; True if it ended a frame."""
        if not self.rules.word(data, last, ready):
            return False
        self.scoreboard.take(data)
        place = (self.rules.taken - 1) % self.job.frame_words
        if place == 0:
            self.first_word.append(cycle())
        ends = place == self.job.frame_words - 1
        if ends:
            self.last_word.append(cycle())
        return ends

    def hung(self) -> None:
        """Note that there was no transfer for too long."""
        total = self.job.frames * self.job.frame_words
        self.violations.add(
            f"no transfer in {self.job.patience} cycles after {self.rules.taken} of {total} words "
            f"and {self.sent} of {len(self.job.codes)} taxels"
        )

    def outcome(self) -> Outcome:
        """Close the record."""
        board = self.scoreboard
        notes = list(self.violations.notes)
        if self.violations.count > len(notes):
            notes.append(f"... {self.violations.count} in all")
        return Outcome(
            board.observed,
            notes,
            board.compared,
            board.mismatches,
            self.last_taxel,
            self.first_word,
            self.last_word,
            self.cycles,
            self.probes,
        )
