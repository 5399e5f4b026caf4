"""Candidate cores for a part and two bounds: speed, size, and why each was chosen or not."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from tfra.families import Target
from tfra.hdl.interface.microarchitecture import Microarchitecture
from tfra.hdl.skin.timing import SkinTiming
from tfra.model.choices import SERIAL, Architecture
from tfra.model.fixed.design import Design
from tfra.model.skin.skin import Skin


@dataclass(frozen=True, slots=True)
class Bounds:
    """Required speed: frames per second, and microseconds from last taxel to last word.

    ``clock_mhz`` is the clock of every core; None for what cores of a kind can count on (:mod:`tfra.synth.clocks`).
    """

    clock_mhz: float | None
    frames_per_second: float
    latency_us: float


@dataclass(frozen=True, slots=True)
class Speed:
    """Speed of a core: cycles from frame to frame, from a frame's last taxel to its last result word, and its clock."""

    interval: int
    frame_latency: int
    clock_mhz: float

    @classmethod
    def of(cls, core: Microarchitecture, clock_mhz: float, array: Design | Skin | None = None) -> "Speed":
        """As ``core`` states it, without being built; behind a skin, that of a frame of its contacts."""
        timed = SkinTiming.of(array, core) if isinstance(array, Skin) else None
        cycles = (timed.interval, timed.frame_latency) if timed else (core.initiation_interval, core.frame_latency)
        return cls(*cycles, clock_mhz)

    @property
    def frames_per_second(self) -> float:
        """Frames per second."""
        return 1e6 * self.clock_mhz / self.interval

    @property
    def latency_us(self) -> float:
        """Microseconds from a frame's last taxel to its last word."""
        return self.frame_latency / self.clock_mhz

    def misses(self, bounds: Bounds) -> tuple[str, ...]:
        """A phrase for every bound that is not met."""
        fps, latency = self.frames_per_second, self.latency_us
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
    least: Mapping[str, int] = field(default_factory=dict)
    """A lower bound on the resources of cores with more lanes in the same line."""

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
    serial_lacks: tuple[str, ...] = ()
    """What the part lacks for a serial core that is too slow, where no core is chosen."""

    @property
    def fast(self) -> list[Candidate]:
        """Cores that are fast enough, those with the fewest lookup tables first."""
        return sorted((core for core in self.candidates if core.resources), key=lambda core: core.luts)

    @property
    def best(self) -> Candidate | None:
        """The suitable core with the fewest lookup tables, if there is one."""
        return next((core for core in self.fast if not core.objections), None)

    @property
    def chosen(self) -> Candidate:
        """The same; raises ``ValueError`` with the reason if there is none."""
        if good := self.best:
            return good
        raise ValueError(self.refusal)

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

    @property
    def refusal(self) -> str | None:
        """Why no core is chosen: the bound that none reaches, or what the smallest fast enough core lacks.

        None if one is.  The serial core is named in any case: it may fit where the others do not.
        """
        if self.best:
            return None
        for core in self.fast:
            why = f"{'; '.join(core.objections)}, for the smallest core that is fast enough ({core.title})"
            return why if core.architecture == SERIAL else f"{why}; {self._serial()}"
        return f"{self._missed()}; {self._serial()}"

    def _serial(self) -> str:
        """What the serial core reaches on the part, if it can be built and fits."""
        core = next(each for each in self.candidates if each.architecture == SERIAL)
        if not core.speed:
            return f"no serial core: {core.objections[0]}"
        speed = f"{core.speed.frames_per_second:,.1f} frames/s, {core.speed.latency_us:,.3f} us to the last word"
        lacks = core.objections if core.resources else self.serial_lacks
        return f"the serial core {'does not fit' if lacks else 'fits'}: {'; '.join(lacks) or speed}"

    def _missed(self) -> str:
        """The bound that no core reaches, and the core that comes nearest."""
        bounds = self.bounds
        timed = [(core.speed, core) for core in self.candidates if core.speed]
        quickest, often = max(timed, key=lambda pair: pair[0].frames_per_second)
        soonest, early = min(timed, key=lambda pair: pair[0].latency_us)
        most, least = quickest.frames_per_second, soonest.latency_us
        if most < bounds.frames_per_second:
            wanted, best = f"frames_per_second: {bounds.frames_per_second:g} are wanted", f"{most:.1f}"
            return f"{wanted}, {best} is the best, at {quickest.clock_mhz:g} MHz ({often.title})"
        if least > bounds.latency_us:
            wanted, best = f"latency_us: {bounds.latency_us:g} is wanted", f"{least:.3f}"
            return f"{wanted}, {best} is the best, at {soonest.clock_mhz:g} MHz ({early.title})"
        first = f"{often.title} reaches {most:.1f} frames/s at {quickest.clock_mhz:g} MHz"
        second = f"{early.title} {least:.3f} us at {soonest.clock_mhz:g} MHz"
        return f"frames_per_second, latency_us: no core reaches both: {first}, {second}"
