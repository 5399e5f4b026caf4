"""Candidate cores for a part and two bounds: speed, size, and why each was chosen or not."""

from collections.abc import Mapping
from dataclasses import dataclass

from tfra.families import Target
from tfra.hdl.interface.microarchitecture import Microarchitecture
from tfra.hdl.skin.timing import SkinTiming
from tfra.model.choices import Architecture
from tfra.model.fixed.design import Design
from tfra.model.skin.skin import Skin


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
    def of(cls, core: Microarchitecture, array: Design | Skin | None = None) -> "Speed":
        """As ``core`` states it, without being built; behind a skin, that of a frame of its contacts."""
        timed = SkinTiming.of(array, core) if isinstance(array, Skin) else None
        return cls(timed.interval, timed.frame_latency) if timed else cls(core.initiation_interval, core.frame_latency)

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
    def luts(self) -> int:
        """Lookup tables of a core that is fast enough."""
        assert self.resources
        return self.resources["LUT"]

    @property
    def line(self) -> tuple[str, int]:
        """The line: cores that differ only in their lanes."""
        return self.architecture.kind, self.architecture.vector_words

    @property
    def distance(self) -> tuple[int, int]:
        """Least for a suitable core, then for one that is fast enough, then for the most frames a second."""
        if self.resources:
            return bool(self.objections), 0
        return 2, self.speed.interval if self.speed else 0


@dataclass(frozen=True)
class Sizing:
    """All cores considered for ``design`` on ``target``; those of one line are in the order of their lanes."""

    design: Design
    target: Target
    bounds: Bounds
    candidates: tuple[Candidate, ...]

    @property
    def fast(self) -> list[Candidate]:
        """Cores that are fast enough, those with the fewest lookup tables first."""
        return sorted((core for core in self.candidates if core.resources), key=lambda core: core.luts)

    @property
    def chosen(self) -> Candidate:
        """The suitable core with the fewest lookup tables; raises ``ValueError`` with the reason if there is none."""
        if good := next((core for core in self.fast if not core.objections), None):
            return good
        raise ValueError(self._refusal())

    @property
    def others(self) -> tuple[tuple[Candidate, str], ...]:
        """The nearest core of every other line, and why it was not chosen."""
        lines: dict[tuple[str, int], list[Candidate]] = {}
        for core in self.candidates:
            lines.setdefault(core.line, []).append(core)
        del lines[self.chosen.line]
        nearest = [min(line, key=lambda core: core.distance) for line in lines.values()]
        return tuple((core, core.objections[0] if core.objections else self._larger(core)) for core in nearest)

    def _larger(self, core: Candidate) -> str:
        return f"larger: {core.luts:,} LUT, {core.luts / self.chosen.luts - 1:.1%} more"

    def _refusal(self) -> str:
        """Why no core is chosen: the bound that none reaches, or what the smallest fast enough core lacks."""
        for core in self.fast:
            return f"{'; '.join(core.objections)}, for the smallest core that is fast enough ({core.title})"
        clock, bounds = self.bounds.clock_mhz, self.bounds
        timed = [(core.speed, core) for core in self.candidates if core.speed]
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
