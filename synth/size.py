"""The smallest core that is fast enough: lanes from bounds on time, as FINN's ``target_fps``."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cache

from tfra.hdl.timing import Timing
from tfra.model.design import Architecture, Design
from tfra.synth.estimate import estimate, misfits
from tfra.synth.targets import Family, Target


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
    """The chosen lanes, what they reach, and the estimated resources."""

    architecture: Architecture
    speed: Speed
    resources: dict[str, int]


def speed(design: Design) -> Speed:
    """What ``design`` reaches, from its timing."""
    timing = Timing(design)
    return Speed(timing.initiation_interval, timing.frame_latency)


def mac_choices(design: Design) -> list[int]:
    """Every number of MAC lanes that the sensor allows, upwards."""
    return [1, 2, *range(4, 4 * design.quads + 1, 4)]


def sweep_choices(design: Design) -> list[int]:
    """Every number of sweep lanes that no smaller one equals in passes, upwards."""
    return sorted({-(-design.candidates // passes) for passes in range(1, design.candidates + 1)})


def size(design: Design, target: Target, bounds: Bounds) -> Sized:
    """The core of fewest estimated lookup tables that meets ``bounds`` and fits ``target``.

    Raises ``ValueError``, which says what is reached at best, when none does.  More lanes are taken never to be
    slower: only the smallest number of sweep lanes is looked at for every number of MAC lanes.
    """
    macs, sweeps = mac_choices(design), sweep_choices(design)

    @cache
    def reached(architecture: Architecture) -> Speed:
        return speed(replace(design, architecture=architecture))

    def good(mac: int, sweep: int) -> bool:
        return not reached(Architecture(mac, sweep)).misses(bounds)

    if missed := reached(Architecture(macs[-1], sweeps[-1])).misses(bounds):
        raise ValueError(f"{missed[0]}, at {bounds.clock_mhz:g} MHz with {macs[-1]} MAC and {sweeps[-1]} sweep lanes")
    cost = _cost(design, target.family)
    lacks: list[str] = []
    for candidate in sorted(staircase(macs, sweeps, good), key=cost):
        resources = estimate(replace(design, architecture=candidate), target.family).total
        lacking = misfits(resources, target)
        if not lacking:
            return Sized(candidate, reached(candidate), resources)
        lacks = lacks or lacking
    raise ValueError(f"{lacks[0]}, for the smallest core that is fast enough")


def staircase(macs: list[int], sweeps: list[int], good: Callable[[int, int], bool]) -> Iterator[Architecture]:
    """The corners of what is ``good``: for every number of MAC lanes that makes a difference the fewest sweep lanes.

    ``good(macs[-1], sweeps[-1])`` is taken for granted, and that more lanes of either kind are as good.
    """
    first = _first(len(macs), lambda place: good(macs[place], sweeps[-1]))
    end = len(sweeps)

    def fewest_sweeps(mac: int) -> int:
        return _first(end, lambda place: good(mac, sweeps[place]))

    for mac in macs[first:]:
        fewest = fewest_sweeps(mac)
        if fewest < end:
            yield Architecture(mac, sweeps[fewest])
        end = min(end, fewest)
        if end == 0:
            return


def _first(count: int, holds: Callable[[int], bool]) -> int:
    """The first of ``0 ... count - 1`` for which ``holds``, by bisection; ``count`` when none does."""
    low, high = 0, count
    while low < high:
        middle = (low + high) // 2
        low, high = (low, middle) if holds(middle) else (middle + 1, high)
    return low


def _cost(design: Design, family: Family) -> Callable[[Architecture], float]:
    """Estimated lookup tables, taken to grow evenly with the lanes of either kind."""

    def tables(mac: int, sweep: int) -> int:
        return estimate(replace(design, architecture=Architecture(mac, sweep)), family).total["LUT"]

    macs, sweeps = mac_choices(design)[-2:], sweep_choices(design)[:2]
    mac, sweep = min(macs[0], 4), sweeps[0]
    base = tables(mac, sweep)
    more_mac, more_sweep = min(mac + 4, macs[1]), sweeps[-1]
    per_mac = (tables(more_mac, sweep) - base) / max(1, more_mac - mac)
    per_sweep = (tables(mac, more_sweep) - base) / max(1, more_sweep - sweep)
    return lambda chosen: per_mac * chosen.mac_lanes + per_sweep * chosen.sweep_lanes
