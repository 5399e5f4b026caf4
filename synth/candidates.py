"""Candidate cores for a part and two bounds: speed, size, and why each was chosen or not."""

from collections.abc import Mapping
from dataclasses import dataclass

from tfra.families import Target
from tfra.hdl.interface.microarchitecture import Microarchitecture
from tfra.model.choices import Architecture
from tfra.model.fixed.design import Design


@dataclass(frozen=True, slots=True)
class Bounds:
    """Required speed at ``clock_mhz``: frames per second, and microseconds from last taxel to last word."""

    clock_mhz: float
    frames_per_second: float
    latency_us: float


@dataclass(frozen=True, slots=True)
class Speed:
    """Speed of a core: cycles from frame to frame, and from a frame's last taxel to its last result word."""

    interval: int
    frame_latency: int

    @classmethod
    def of(cls, core: Microarchitecture) -> "Speed":
        """As ``core`` states it, without being built."""
        return cls(core.initiation_interval, core.frame_latency)

    def frames_per_second(self, clock_mhz: float) -> float:
        """Frames per second at ``clock_mhz``."""
        return 1e6 * clock_mhz / self.interval

    def latency_us(self, clock_mhz: float) -> float:
        """Microseconds from a frame's last taxel to its last word at ``clock_mhz``."""
        return self.frame_latency / clock_mhz

    def misses(self, bounds: Bounds) -> tuple[str, ...]:
        """A phrase for every bound that is not met."""
        fps, latency = self.frames_per_second(bounds.clock_mhz), self.latency_us(bounds.clock_mhz)
        found = []
        if fps < bounds.frames_per_second:
            found.append(f"too slow: {fps:,.1f} frames/s, {bounds.frames_per_second:,.10g} are wanted")
        if latency > bounds.latency_us:
            found.append(f"too late: {latency:,.3f} us to the last word, {bounds.latency_us:,.10g} is wanted")
        return tuple(found)


@dataclass(frozen=True)
class Candidate:
    """One core.  ``resources`` are estimated only if it is fast enough; a core that can't be built has neither."""

    architecture: Architecture
    design: Design | None
    speed: Speed | None
    resources: Mapping[str, int] | None
    objections: tuple[str, ...]
    """Phrases why it can't be chosen."""
    least: int = 0
    """A lower bound on the lookup tables of cores with more lanes in the same line."""

    @property
    def title(self) -> str:
        """The core in a few words."""
        lanes, words = self.architecture.mac_lanes, self.architecture.vector_words
        return f"{self.architecture.kind}, {lanes} lanes, {words} word{'s' * (words > 1)}" if lanes else "serial"

    @property
    def line(self) -> tuple[str, int]:
        """The line: cores that differ only in their lanes."""
        return self.architecture.kind, self.architecture.vector_words


@dataclass(frozen=True)
class Sizing:
    """All cores considered for ``design`` on ``target``; those of one line are in the order of their lanes."""

    design: Design
    target: Target
    bounds: Bounds
    candidates: tuple[Candidate, ...]

    @property
    def chosen(self) -> Candidate | None:
        """The suitable core with the fewest lookup tables, if there is one."""
        good = [(found["LUT"], c) for c in self.candidates if (found := c.resources) and not c.objections]
        return min(good, key=lambda pair: pair[0])[1] if good else None

    @property
    def others(self) -> tuple[tuple[Candidate, str], ...]:
        """The nearest core of every other line, and why it was not chosen."""
        chosen = self.chosen
        lines: dict[tuple[str, int], list[Candidate]] = {}
        for candidate in self.candidates:
            lines.setdefault(candidate.line, []).append(candidate)
        nearest = [self._nearest(line) for name, line in lines.items() if not chosen or name != chosen.line]
        return tuple((candidate, self._why_not(candidate)) for candidate in nearest)

    def _nearest(self, line: list[Candidate]) -> Candidate:
        """The first suitable core, else the first that is fast enough, else the one with the most frames a second."""
        fast = [candidate for candidate in line if candidate.resources]
        good = [candidate for candidate in fast if not candidate.objections]
        return next(iter(good or fast), None) or min(line, key=lambda c: c.speed.interval if c.speed else 0)

    def _why_not(self, candidate: Candidate) -> str:
        if candidate.objections or not (candidate.resources and self.chosen and self.chosen.resources):
            return candidate.objections[0]
        used, least = candidate.resources["LUT"], self.chosen.resources["LUT"]
        return f"larger: {used:,} LUT, {used / least - 1:.1%} more"

    @property
    def refusal(self) -> str:
        """Why no core was chosen: the bound that none reaches, or what the smallest fast enough core lacks."""
        fast = [(found["LUT"], candidate) for candidate in self.candidates if (found := candidate.resources)]
        if fast:
            smallest = min(fast, key=lambda pair: pair[0])[1]
            return f"{smallest.objections[0]}, for the smallest core that is fast enough ({smallest.title})"
        clock, bounds = self.bounds.clock_mhz, self.bounds
        timed = [(candidate.speed, candidate) for candidate in self.candidates if candidate.speed]
        quickest, often = min(timed, key=lambda pair: pair[0].interval)
        soonest, early = min(timed, key=lambda pair: pair[0].frame_latency)
        most, least = quickest.frames_per_second(clock), soonest.latency_us(clock)
        if most < bounds.frames_per_second:
            wanted, best, core = f"frames_per_second: {bounds.frames_per_second:g} are wanted", f"{most:.1f}", often
        elif least > bounds.latency_us:
            wanted, best, core = f"latency_us: {bounds.latency_us:g} is wanted", f"{least:.3f}", early
        else:
            both = f"{often.title} reaches {most:.1f} frames/s, {early.title} {least:.3f} us"
            return f"frames_per_second, latency_us: no core reaches both at {clock:g} MHz: {both}"
        return f"{wanted}, {best} is the best, at {clock:g} MHz ({core.title})"
