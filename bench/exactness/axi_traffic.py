"""Frames for a core behind AXI, malformed ones among them, and what has to come back."""

from dataclasses import dataclass

import numpy as np

from tfra.model.arrays import Ints
from tfra.model.converter import saturated
from tfra.model.cover.scenes import contact_codes, directed_codes, wild_codes
from tfra.model.fixed.design import Design

SATURATION, SEQUENCE_GAP, OUT_OF_RANGE = 1 << 2, 1 << 5, 1 << 8
"""Faults in the second word of an output frame."""
FORMAT = 1 << 24

Frame = tuple[int, list[int]]
"""Number of a frame, and its beats."""


@dataclass(frozen=True)
class Traffic:
    """``sent`` are all frames, ``answers`` those that have to come back, word by word; ``counters`` by register."""

    sent: list[Frame]
    answers: list[list[int]]
    counters: dict[str, int]


def traffic(design: Design, count: int, seed: int, malformed: float = 0.3) -> Traffic:
    """``count`` random frames, contacts, noise and directed ones; a share of them is ``malformed``.

    Those are too short, too long or a single beat.  Numbers have gaps, and words bits beyond those of the converter.
    """
    rng = np.random.default_rng(seed)
    codes = _codes(design, count, rng)
    bad, wide, gap = (rng.random(count) < share for share in (malformed, 0.05, 0.05))
    users = np.cumsum(1 + gap * rng.integers(1, 1 << 16, count)) & 0xFFFF
    words = _words(design, codes, wide.astype(np.int64), rng)
    beats = [_beats(each, design.bus.taxels_per_beat, rng) for each in words]
    whole = len(beats[0])
    lengths = np.where(bad, [_length(whole, rng) for _ in beats], whole)
    sent = [(int(user), _resized(each, length, rng)) for user, each, length in zip(users, beats, lengths, strict=True)]
    good = lengths == whole
    jumps = np.flatnonzero(np.diff(users) & 0xFFFF != 1) + 1
    faults = SATURATION * saturated(design, codes) + OUT_OF_RANGE * wide
    faults[jumps] += SEQUENCE_GAP
    head = np.stack([np.arange(count) & 0xFFFF | users << 16, faults | FORMAT], axis=1)[good]
    results = design.model(codes[good]).words & 0xFFFFFFFF
    status = results[:, -1] & (32 | 64)
    counters = {
        "FRAMES_IN": int(good.sum()),
        "FRAMES_OUT": int(good.sum()),
        "FRAMES_DROPPED": int((~good).sum()),
        "FRAMES_SATURATED": int(((faults[good] & SATURATION != 0) | (status != 0)).sum()),
    }
    return Traffic(sent, np.concatenate([head, results], axis=1).tolist(), counters)


def _codes(design: Design, count: int, rng: np.random.Generator) -> Ints:
    seed = int(rng.integers(1 << 31))
    contacts = contact_codes(design, min(count, 60), seed)
    frames = np.concatenate([contacts, directed_codes(design), wild_codes(design, count, seed)])
    return frames[rng.permutation(len(frames))[:count]]


def _words(design: Design, codes: Ints, wide: Ints, rng: np.random.Generator) -> Ints:
    """Slots of 16 bits; a taxel of each ``wide`` frame has a wrong bit beyond those of the converter."""
    words = codes.reshape(len(codes), -1) & 0xFFFF
    where = rng.integers(words.shape[1], size=len(words))
    words[np.arange(len(words)), where] ^= wide << rng.integers(design.adc.bits, 16, len(words))
    return words


def _beats(words: Ints, taxels: int, rng: np.random.Generator) -> list[int]:
    """Beats of that many taxels; the last one is filled up with anything."""
    filled = np.concatenate([words, rng.integers(1 << 16, size=-len(words) % taxels)]).reshape(-1, taxels)
    return [sum(int(word) << (16 * place) for place, word in enumerate(beat)) for beat in filled]


def _length(whole: int, rng: np.random.Generator) -> int:
    """Beats of a malformed frame."""
    choices = [1, whole - 1, int(rng.integers(1, whole)), whole + 1, int(rng.integers(whole + 1, 2 * whole + 2))]
    return int(rng.choice([length for length in choices if length > 0]))


def _resized(beats: list[int], length: int, rng: np.random.Generator) -> list[int]:
    more = rng.integers(1 << 16, size=max(0, length - len(beats)))
    return beats[:length] + [int(word) for word in more]
