"""The smallest core that is fast enough: lanes and words from bounds on time, as FINN's ``target_fps``."""

from __future__ import annotations

from bisect import bisect_left
from dataclasses import dataclass, replace
from functools import cache

from tfra.hdl.cores import microarchitecture
from tfra.model.choices import VECTOR_WORDS, Architecture
from tfra.model.fixed.design import Design
from tfra.synth.estimate import estimate, misfits
from tfra.synth.targets import Target


@dataclass(frozen=True, slots=True)
class Bounds:
    """What a core must reach at ``clock_mhz``: frames per second, and microseconds from last taxel to last word."""

    clock_mhz: float
    frames_per_second: float
    latency_us: float


@dataclass(frozen=True, slots=True)
class Speed:
    """What a core reaches: cycles from frame to frame, and from a frame's last taxel to its last result word."""

    interval: int
    frame_latency: int

    def frames_per_second(self, clock_mhz: float) -> float:
        """Frames per second at ``clock_mhz``."""
        return 1e6 * clock_mhz / self.interval

    def latency_us(self, clock_mhz: float) -> float:
        """Microseconds from a frame's last taxel to its last word at ``clock_mhz``."""
        return self.frame_latency / clock_mhz

    def misses(self, bounds: Bounds) -> list[str]:
        """Sentences on every bound that is not met."""
        fps, latency = self.frames_per_second(bounds.clock_mhz), self.latency_us(bounds.clock_mhz)
        found = []
        if fps < bounds.frames_per_second:
            found.append(f"frames_per_second: {bounds.frames_per_second:g} are wanted, {fps:.1f} is the best")
        if latency > bounds.latency_us:
            found.append(f"latency_us: {bounds.latency_us:g} is wanted, {latency:.3f} is the best")
        return found


@dataclass(frozen=True, slots=True)
class Sized:
    """The chosen parallelism, what it reaches, and the estimated resources."""

    architecture: Architecture
    speed: Speed
    resources: dict[str, int]


def speed(design: Design) -> Speed:
    """What ``design`` reaches, from its timing."""
    core = microarchitecture(design)
    return Speed(core.initiation_interval, core.frame_latency)


def size(design: Design, target: Target, bounds: Bounds) -> Sized:
    """The core of fewest LUTs among the smallest for each ``vector_words``, which meet ``bounds`` and fit ``target``.

    Raises ``ValueError``, which says what is reached at best or what is lacking, when none does.
    """
    choices = microarchitecture(design).lane_choices
    if not choices:
        raise ValueError(f"architecture.kind: the {design.architecture.kind} core has no lanes to choose")
    best = Architecture(choices[-1], max(VECTOR_WORDS))
    if missed := speed(replace(design, architecture=best)).misses(bounds):
        raise ValueError(f"{missed[0]}, at {bounds.clock_mhz:g} MHz with {best.mac_lanes} MAC lanes")
    found: list[Sized] = []
    lacks: list[str] = []
    for words in VECTOR_WORDS:
        smallest = _smallest(design, target, bounds, words)
        if isinstance(smallest, Sized):
            found.append(smallest)
        else:
            lacks = lacks or smallest
    if not found:
        raise ValueError(f"{lacks[0]}, for the smallest core that is fast enough")
    return min(found, key=lambda sized: sized.resources["LUT"])


def _smallest(design: Design, target: Target, bounds: Bounds, words: int) -> Sized | list[str]:
    """The core of fewest lanes, or what all that are fast enough lack, which may be none.

    More lanes are taken never to be slower, and to need less of nothing but block memories, whose depth they share.
    """
    choices = microarchitecture(design).lane_choices

    @cache
    def reached(lanes: int) -> Speed:
        return speed(replace(design, architecture=Architecture(lanes, words)))

    lacks: list[str] = []
    for lanes in choices[bisect_left(choices, True, key=lambda lanes: not reached(lanes).misses(bounds)) :]:
        chosen = Architecture(lanes, words)
        resources = estimate(replace(design, architecture=chosen), target.family).total
        lacking = misfits(resources, target)
        if not lacking:
            return Sized(chosen, reached(lanes), resources)
        lacks = lacks or lacking
        if not all(sentence.startswith("BRAM:") for sentence in lacking):
            break
    return lacks
