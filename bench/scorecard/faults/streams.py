"""Streams of a sensor's frames: presses that come and go with noise on every taxel, and faults planted in them."""

from collections.abc import Callable
from dataclasses import dataclass, field
from statistics import NormalDist

import numpy as np

from tfra.model.arrays import Floats, Ints
from tfra.model.cover.scenes import contact_codes
from tfra.model.fixed.design import Design
from tfra.model.fixed.front_end import OLDEST

NOISE = 1e-3, 3e-3
"""Least and largest noise of the taxels, a press each: standard deviation, as a share of full scale."""
PEAK = 0.2, 0.6
"""Peaks of the presses, as shares of full scale."""
PRESS, RISE, REST = 120, 20, 40
"""Frames of a press, of its rise and of its fall, and of the rest after it."""
JITTER = 0.1
"""Frames come so much earlier or later, as a share of their period."""
TIMEOUT = 1.4
"""FRAME_TIMEOUT in periods."""
LATE = 0.8, 4.0
"""A late frame comes so many periods after its time, with jitter more than FRAME_TIMEOUT after the one before."""
LAST, EVERY = 40, 64
"""Slots of a fault that stays, and from fault to fault."""


@dataclass(eq=False)
class Stream:
    """``words (n, m)`` of 16 bits, and ``users (n,)``, the numbers of the frames; ``gaps (n,)`` to the next, in cycles.

    ``odd`` are frames of another length by their slot.  ``sigma (n,)`` is the noise in codes.  Faults
    that stay do so for ``last`` slots.
    """

    words: Ints
    users: Ints
    gaps: Ints
    sigma: Floats
    bits: int
    period: int
    last: int = LAST
    odd: dict[int, Ints] = field(default_factory=dict)

    @property
    def low(self) -> int:
        """The least code."""
        return -(1 << (self.bits - 1))

    def script(self, first: int = 0, end: int | None = None) -> Ints:
        """The script of the frames from ``first`` on."""
        heads = np.stack([0 * self.users, self.gaps, self.users & 0xFFFF, 0 * self.users + self.words.shape[1]], axis=1)
        numbers = np.concatenate([heads, self.words & 0xFFFF], axis=1)[first:end]
        if not self.odd:
            return numbers.ravel()
        parts = list(numbers)
        for slot, words in self.odd.items():
            parts[slot - first] = np.concatenate([heads[slot, :3], [len(words)], words & 0xFFFF])
        return np.concatenate(parts)


def clean(design: Design, count: int, period: int, rng: np.random.Generator) -> Stream:
    """So many frames without a fault: random contacts, pressed for some time, of a sensor at rest between them."""
    full, cycle = 1 << (design.adc.bits - 1), PRESS + REST
    shapes = contact_codes(design, -(-count // cycle), rng).reshape(-1, design.sensor.taxels)
    shapes = shapes / np.abs(shapes).max(axis=1, keepdims=True) * rng.uniform(*PEAK, (len(shapes), 1)) * full
    number, time = np.divmod(np.arange(count), cycle)
    level = np.clip(np.minimum(time, PRESS - time) / RISE, 0, 1)
    sigma = np.repeat(rng.uniform(*NOISE, len(shapes)) * full, cycle)[:count]
    codes = np.rint(shapes[number] * level[:, None] + sigma[:, None] * rng.normal(size=(count, shapes.shape[1])))
    gaps = np.rint(period * (1 + JITTER * rng.uniform(-1, 1, count))).astype(np.int64)
    return Stream(codes.astype(np.int64), np.arange(count), gaps, sigma, design.adc.bits, period)


Plant = Callable[[Stream, int, int, np.random.Generator], None]
"""Plants a fault of a taxel into a stream, from a slot on."""


def _taxel(change: Callable[[Stream, slice, int, np.random.Generator], Ints | int]) -> Plant:
    """A fault that changes the words of a taxel as long as it lasts."""

    def plant(stream: Stream, at: int, taxel: int, rng: np.random.Generator) -> None:
        slots = slice(at, at + stream.last)
        stream.words[slots, taxel] = change(stream, slots, taxel, rng)

    return plant


def _louder(times: float) -> Plant:
    def change(stream: Stream, slots: slice, taxel: int, rng: np.random.Generator) -> Ints:
        more = np.rint(times * stream.sigma[slots] * rng.normal(size=stream.last)).astype(np.int64)
        return np.asarray(np.clip(stream.words[slots, taxel] + more, stream.low, -stream.low - 1))

    return _taxel(change)


def _floating(stream: Stream, slots: slice, taxel: int, rng: np.random.Generator) -> Ints:
    return np.rint(stream.sigma[slots] * rng.normal(size=stream.last)).astype(np.int64)


def _beyond(stream: Stream, at: int, taxel: int, rng: np.random.Generator) -> None:
    stream.words[at, taxel] ^= 1 << int(rng.integers(stream.bits, 16))


def _flipped(stream: Stream, at: int, taxel: int, rng: np.random.Generator) -> None:
    half = -stream.low
    bit = 1 << int(rng.integers(stream.bits))
    stream.words[at, taxel] = (((stream.words[at, taxel] & (2 * half - 1)) ^ bit) ^ half) - half


def _frozen(stream: Stream, at: int, taxel: int, rng: np.random.Generator) -> None:
    stream.words[at : at + stream.last] = stream.words[at - 1]


def _lost(stream: Stream, at: int, taxel: int, rng: np.random.Generator) -> None:
    stream.odd[at] = stream.words[0, :0]


def _again(stream: Stream, at: int, taxel: int, rng: np.random.Generator) -> None:
    stream.words[at] = stream.words[at - 1]
    stream.users[at:] -= 1


def _copy(stream: Stream, at: int, taxel: int, rng: np.random.Generator) -> None:
    stream.words[at] = stream.words[at - 1]


def _late(stream: Stream, at: int, taxel: int, rng: np.random.Generator) -> None:
    _lost(stream, at, taxel, rng)
    stream.users[at:] -= 1
    stream.gaps[at] = round(stream.period * float(rng.uniform(*LATE)))


def _short(stream: Stream, at: int, taxel: int, rng: np.random.Generator) -> None:
    stream.odd[at] = stream.words[at, : int(rng.integers(1, stream.words.shape[1]))]


def _long(stream: Stream, at: int, taxel: int, rng: np.random.Generator) -> None:
    more = int(rng.integers(1, stream.words.shape[1] + 1))
    stream.odd[at] = np.concatenate([stream.words[at], stream.words[at + 1, :more]])


FAULTS: dict[str, Plant] = {
    "taxel stuck at its last word": _taxel(lambda stream, slots, taxel, _: stream.words[slots.start - 1, taxel]),
    "taxel stuck anywhere": _taxel(lambda stream, _, __, rng: int(rng.integers(stream.low + 1, -stream.low - 1))),
    "taxel dead: reads 0": _taxel(lambda *_: 0),
    "taxel dead: reads noise at rest": _taxel(_floating),
    "taxel noisy, 10 times": _louder(10),
    "taxel noisy, 100 times": _louder(100),
    "taxel saturated": _taxel(lambda stream, _, __, rng: (stream.low, -stream.low - 1)[rng.integers(2)]),
    "word out of range": _beyond,
    "bit of a word wrong": _flipped,
    "frame lost": _lost,
    "frame repeated with its number": _again,
    "words of a frame repeated": _copy,
    "words stand still, numbers go on": _frozen,
    "frame late": _late,
    "frame short": _short,
    "frame long": _long,
}
"""Faults of the sensor and of its stream by name."""


def planted(stream: Stream, plant: Plant | None, rng: np.random.Generator) -> tuple[Ints, Ints]:
    """Plant a fault into every ``EVERY`` slots of ``stream``; the slots and the taxels, ``(k,)`` each."""
    starts = EVERY * np.arange(1, len(stream.words) // EVERY - 1)
    at = starts + rng.integers(EVERY - LAST - 8, size=len(starts))
    taxels = rng.integers(stream.words.shape[1], size=len(starts))
    for slot, taxel in zip(at.tolist(), taxels.tolist(), strict=True):
        if plant:
            plant(stream, slot, taxel, rng)
    return at, taxels


def same_words(sigma: float, frames: int) -> float:
    """How likely the last ``frames`` words of a taxel are the same, with the noise ``sigma`` in codes about a code."""
    normal = NormalDist(0, sigma)
    reach = range(-int(6 * sigma) - 1, int(6 * sigma) + 2)
    return float(sum((normal.cdf(code + 0.5) - normal.cdf(code - 0.5)) ** frames for code in reach))


def stuck_frames(sigma: float, words: float, alarms: float = 0.01) -> int:
    """The least STUCK.frames with fewer false ``alarms`` than that expected in so many ``words``; 0 if none will do."""
    enough = (frames for frames in range(2, OLDEST + 1) if words * same_words(sigma, frames) < alarms)
    return next(enough, 0)
