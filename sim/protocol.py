"""Common parts of the testbenches of all simulators: stalls, stream rules, the job and its outcome.

Nothing here depends on a simulator, so all of it can be tested without one.
"""

import json
import os
import random
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path

MOST_NOTES = 20
"""Violations that are described; all of them are counted."""


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


@dataclass(frozen=True)
class Probe:
    """A stream between blocks, watched from outside: two signals below the top module, names joined by dots."""

    stage: str
    transfer: str
    """High in the cycles in which the stream transfers."""
    words: str
    """The words of a transfer, the first lowest."""
    layout: Sequence[tuple[int, bool]]
    """Bits, and whether signed, of each word."""
    transfers: int
    """Transfers of a frame."""

    def unpack(self, packed: Sequence[int]) -> list[int]:
        """Return the words of transfers in order."""
        words = []
        for value in packed:
            for bits, signed in self.layout:
                half = signed << (bits - 1)
                words.append(((value & ((1 << bits) - 1)) ^ half) - half)
                value >>= bits
        return words


@dataclass(frozen=True)
class Job:
    """The job of a testbench.  Words and codes are two's complement patterns, that is, unsigned."""

    codes: list[int]
    """Taxel codes of all frames, one after the other."""
    taxels: int
    frame_words: int
    """Words of a result frame, or of a record."""
    results: int
    """Frames or records expected back."""
    expected: list[int] | None = None
    coefficients: list[int] | None = None
    """Words for the ``load`` port, if the core has one, before the first frame."""
    seed: int = 0
    stall_in: str = "none"
    stall_out: str = "none"
    patience: int = 200_000
    """Cycles without any transfer after which the core hangs."""
    drain: int = 256
    """Cycles after the last frame in which no word may follow."""
    probes: Sequence[Probe] = ()
    settings: Mapping[str, int] = field(default_factory=dict)
    """Constant inputs by their ports."""

    def save(self, path: Path) -> None:
        """Write the job for another process."""
        path.write_text(json.dumps(asdict(self)))

    @classmethod
    def load(cls, path: Path) -> "Job":
        """Read what ``save`` wrote."""
        values = json.loads(path.read_text())
        return cls(**values | {"probes": [Probe(**probe) for probe in values["probes"]]})


@dataclass
class Outcome:
    """The outcome of a testbench.  Cycles count clock edges from the end of reset."""

    words: list[int] = field(default_factory=list)
    violations: list[str] = field(default_factory=list)
    compared: int = 0
    """Words that were compared with expected ones."""
    mismatches: int = 0
    last_taxel: list[int] = field(default_factory=list)
    """Cycle of each frame's last taxel; of its first and last result word in the next ones."""
    first_word: list[int] = field(default_factory=list)
    last_word: list[int] = field(default_factory=list)
    cycles: int = 0
    probes: list[list[int]] = field(default_factory=list)
    """Per probe, the packed words of every transfer."""

    def save(self, path: Path) -> None:
        """Write the outcome, completely or not at all."""
        fresh = path.with_name(f".{path.name}.{os.getpid()}")
        fresh.write_text(json.dumps(asdict(self)))
        os.replace(fresh, path)

    @classmethod
    def load(cls, path: Path) -> "Outcome":
        """Read what ``save`` wrote."""
        return cls(**json.loads(path.read_text()))


class Record:
    """The outcome in the making: checks the rules of the result stream, notes its words and the marks of frames.

    The rules: valid and payload are stable until ready, ``last`` ends each frame.  ``cycle`` gives the cycle of now.
    """

    def __init__(self, job: Job, cycle: Callable[[], int]) -> None:
        self.job = job
        self.outcome = Outcome(probes=[[] for _ in job.probes])
        self.loaded = 0
        self.sent = 0
        self._cycle = cycle
        self._broken = 0
        self._waiting: tuple[int, int] | None = None  # word and last that were offered and not taken

    @property
    def transfers(self) -> int:
        """Transfers of all ports, a measure of progress."""
        return self.loaded + self.sent + len(self.outcome.words)

    @property
    def missing(self) -> int:
        """Words still to come."""
        return self.job.results * self.job.frame_words - len(self.outcome.words)

    def coefficient_sent(self) -> None:
        """Count a coefficient."""
        self.loaded += 1

    def taxel_sent(self) -> None:
        """Count a taxel; the last of a frame is marked."""
        self.sent += 1
        if self.sent % self.job.taxels == 0:
            self.outcome.last_taxel.append(self._cycle())

    def idle(self) -> None:
        """Check a clock edge without valid."""
        if self._waiting is not None:
            self._note_at_word("valid was withdrawn before the word was taken")
            self._waiting = None

    def word(self, data: int, last: int, ready: bool) -> bool:
        """Check a clock edge with valid; True if it ended a frame."""
        if self._waiting is not None and self._waiting != (data, last):
            self._note_at_word(f"payload changed from {self._waiting} to {(data, last)} before it was taken")
        self._waiting = None if ready else (data, last)
        if not ready:
            return False
        place = len(self.outcome.words) % self.job.frame_words
        ends = place == self.job.frame_words - 1
        if bool(last) != ends:
            self._note_at_word(f"last is {'missing' if ends else 'set too early'}")
        self.outcome.words.append(data)
        if place == 0:
            self.outcome.first_word.append(self._cycle())
        if ends:
            self.outcome.last_word.append(self._cycle())
        return ends

    def surplus(self) -> None:
        """Note a word after the last frame."""
        self._note(f"a word follows the last frame, of {self.job.frame_words} words")

    def hung(self) -> None:
        """Note that there was no transfer for too long."""
        words = len(self.outcome.words)
        self._note(
            f"no transfer in {self.job.patience} cycles after {words} of {words + self.missing} words "
            f"and {self.sent} of {len(self.job.codes)} taxels"
        )

    def close(self) -> Outcome:
        """Compare the words with the expected ones, and return the outcome."""
        outcome = self.outcome
        if self._broken > MOST_NOTES:
            outcome.violations.append(f"... {self._broken} in all")
        pairs = list(zip(outcome.words, self.job.expected or (), strict=False))
        outcome.compared = len(pairs)
        outcome.mismatches = sum(word != expected for word, expected in pairs)
        outcome.cycles = self._cycle()
        return outcome

    def _note_at_word(self, note: str) -> None:
        frame, word = divmod(len(self.outcome.words), self.job.frame_words)
        self._note(f"frame {frame}, word {word}: {note}")

    def _note(self, note: str) -> None:
        self._broken += 1
        if self._broken <= MOST_NOTES:
            self.outcome.violations.append(note)
