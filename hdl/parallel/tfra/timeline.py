"""Timeline of TFRA's core."""

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, field

from tfra.hdl.lib.streams import Buffer, PerFrameFifo, Router
from tfra.hdl.parallel.core import timeline as engine
from tfra.hdl.parallel.core.timeline import IDLE, NEVER, SEEN, Decision, last_entry, visible
from tfra.hdl.parallel.tfra.blocks import PLAN
from tfra.hdl.parallel.tfra.combine.store import FRAMES, MEASURE
from tfra.hdl.parallel.tfra.forces import PLANES
from tfra.hdl.parallel.tfra.sums_queue import SumsQueue
from tfra.model.fixed.design import Design

_NEXT_FRAME = 3
"""Cycles from the last beat of a frame's vectors to the choice of the next frame's: its store's place moves on."""

_NEXT_GAIN = 2
"""Cycles from a frame's gain to the first cycle of the next: it is taken, then seen as free."""

_NEXT_HEADER = 3
"""Cycles from a frame's last result word to the first of the next."""


@dataclass
class Frame(engine.Frame):
    """Cycles of one frame's events, in dataflow order."""

    direction: int = 0
    sums_b: int = 0
    affine: int = 0
    residual: int = 0
    """Last beat of d2 at the vector updates."""
    e1: int = 0
    normal: list[int] = field(default_factory=list)
    """Quads of p and q at the queue of the sweep."""
    index: int = 0
    chosen: int = 0
    total: int = 0
    gain: int = 0


class Updates:
    """The vector updates: e0, e1 and d begin when all their inputs are available and a bank is free.

    d of an older frame goes before e0 and e1.
    """

    def __init__(self, timeline: "TfraTimeline") -> None:
        self._timeline = timeline
        self.candidates: deque[int] = deque()
        """Frames that wait for e0 and e1."""
        self.winners: deque[int] = deque()
        """Frames that wait for d."""
        self.force_beats: set[int] = set()
        """Cycles in which products of forces enter."""
        self._e1_is_next = False
        # Cycles from which any vector may begin; e0 or e1 of the next frame; its d.
        self._begin_from = self._candidates_from = self._winners_from = -NEVER

    def decide(self) -> Decision:
        """The next vector."""
        frames, ready = self._timeline.frames, []
        if self.winners:
            frame = frames[self.winners[0]]
            fact = frame.chosen + PerFrameFifo.latency + SEEN
            ready.append((max(fact, frame.e1 + MEASURE, self._winners_from), "d"))
        if self.candidates:
            frame = frames[self.candidates[0]]
            facts = max(frame.affine, frame.direction) + Buffer.latency + PerFrameFifo.latency + SEEN
            seen = max(facts, frame.residual + MEASURE, self._candidates_from)
            ready.append((seen, "e1" if self._e1_is_next else "e0"))
        if not ready:
            return IDLE
        bank = visible(self._timeline.tokens["bank_token"])
        cycle = max(self._begin_from, min(seen for seen, _ in ready), bank)
        vector = next(name for seen, name in ready if seen <= cycle)
        return Decision(cycle, lambda: self._run(cycle, vector))

    def _run(self, cycle: int, vector: str) -> None:
        """Beats of a vector enter where none of a product of forces does."""
        timeline, entry = self._timeline, cycle
        timeline.tokens["bank_token"].popleft()
        for _ in range(timeline.design.quads * timeline.design.cycles_per_quad):
            entry += 1
            while entry in self.force_beats:
                entry += 1
        self._begin_from = entry + 1
        last_quad = entry + timeline.cycles["combine.force_latency"]
        waiting = self.winners if vector == "d" else self.candidates
        number = waiting[0]
        timeline.products.add("force" if vector == "d" else "normal", number, last_quad)
        if vector == "e0":
            self._e1_is_next = True
            return
        waiting.popleft()
        if vector == "d":
            self._winners_from = entry + _NEXT_FRAME
        else:
            self._e1_is_next = False
            self._candidates_from = entry + _NEXT_FRAME
            timeline.frames[number].e1 = last_quad - 1


class TfraTimeline(engine.Timeline[Frame]):
    """The events of ``number`` frames; ``cycles`` are those of the blocks, by the names of ``stated``.

    =========== ====================================================================================================
    product     what follows from its results
    =========== ====================================================================================================
    contact     weights: the operand of the residual product; the sums of b
    residual    sums of n -> dependent -> ``affine``; the vector updates begin e0 and e1
    normal      of e0 and e1: sweep -> ``index`` -> friction -> ``chosen`` -> resultant -> ``total`` -> gain -> ``gain``
    force       vector updates -> forces -> scaling -> ``words``
    =========== ====================================================================================================
    """

    stated = (
        "normaliser.latency",
        "centroids.latency",
        "weights.latency",
        "dependent.latency",
        "combine.force_latency",
        "sweep.latency",
        "sweep.turn",
        "sweep.e0_interval",
        "sweep.quad_interval",
        "sweep.frame_interval",
        "friction.latency",
        "resultant.latency",
        "gain.latency",
        "forces.latency",
        "forces.read_latency",
        "scaling.latency",
        "scaling.force_latency",
    )
    route_latency = Router.latency

    def __init__(self, design: Design, cycles: Mapping[str, int], number: int) -> None:
        tokens = {"frame_token": FRAMES, "plane_token": PLANES // 3}
        super().__init__(design, PLAN, cycles, [Frame() for _ in range(number)], tokens)
        self._updates = Updates(self)
        self.units.append(self._updates)
        self._swept = -NEVER
        """Last quad of the frame before at the sweep."""
        self.run()

    def last_taxel(self, number: int) -> int:
        """The centroids take it when the frame before has left them; the direction follows."""
        before = self.before(number)
        taken = max(before.taxel + self.design.sensor.taxels, before.direction + 1) if before else 0
        self.frames[number].direction = taken + self.cycles["centroids.latency"]
        return taken

    def after(self, stack: str, number: int, results: list[int]) -> None:
        """Follow the results of a product."""
        events = {"contact": self._contact, "residual": self._residual, "normal": self._normal, "force": self._force}
        events[stack](number, results)

    def _contact(self, number: int, results: list[int]) -> None:
        quads = self.design.quads
        self.products.add("residual", number, results[quads - 1] + self.cycles["weights.latency"])
        self.frames[number].sums_b = results[quads]

    def _residual(self, number: int, results: list[int]) -> None:
        """The sums of n come first; d1 and d2 go to the vector updates."""
        frame, before = self.frames[number], self.before(number)
        sums = (cycle + SumsQueue.latency for cycle in (frame.sums_b, *results[:3]))
        gathered = last_entry(sums, before.affine + 1 if before else -NEVER, SumsQueue.interval)
        direction = frame.direction + Buffer.latency + PerFrameFifo.latency
        frame.affine = max(gathered, direction - 1) + self.cycles["dependent.latency"]
        frame.residual = results[-1] + self.design.cycles_per_quad - 1
        self._updates.candidates.append(number)

    def _normal(self, number: int, results: list[int]) -> None:
        """p or q; after both the sweep."""
        frame = self.frames[number]
        frame.normal += [cycle + self.design.cycles_per_quad - 1 for cycle in results]
        if len(frame.normal) == 2 * self.design.quads:
            self._sweep(number)
            self._scalars(number)

    def _sweep(self, number: int) -> None:
        """The winner's index: e0 enters behind e1 of the frame before, e1 when that frame's sums have been used."""
        frame, cycles, quads = self.frames[number], self.cycles, self.design.quads
        e0, e1 = frame.normal[:quads], frame.normal[quads:]
        next_quad = cycles["sweep.quad_interval"]
        last_e0 = last_entry(e0, self._swept + next_quad, cycles["sweep.e0_interval"])
        first_e1 = max(last_e0 + cycles["sweep.turn"], self._swept + cycles["sweep.frame_interval"])
        self._swept = last_entry(e1, first_e1, next_quad)
        frame.index = self._swept + cycles["sweep.latency"]

    def _scalars(self, number: int) -> None:
        """Events after the index: friction, resultant, gain; the first is free when the sweep has an index."""
        frame, before, cycles = self.frames[number], self.before(number), self.cycles
        frame.chosen = frame.index + cycles["friction.latency"]
        begin = max(frame.chosen + PerFrameFifo.latency, before.total + 1 if before else 0)
        frame.total = begin + cycles["resultant.latency"]
        begin = max(frame.total + PerFrameFifo.latency, before.gain + _NEXT_GAIN if before else 0)
        frame.gain = begin + cycles["gain.latency"]
        self._updates.winners.append(number)

    def _force(self, number: int, results: list[int]) -> None:
        """Products enter the vector updates beat by beat; then the updates are done with the frame."""
        cycles, beats, quads = self.cycles, self.design.cycles_per_quad, self.design.quads
        self._updates.force_beats |= {cycle + beat for cycle in results for beat in range(beats)}
        end = results[-1] + beats
        self.tokens["frame_token"].append(end + SEEN)
        planes = [last + beats - 1 for last in results[quads - 1 :: quads]]
        self._words(number, planes)
        to_result = cycles["scaling.force_latency"] + cycles["forces.read_latency"]
        last_force = self.frames[number].words[-2]
        self.tokens["plane_token"].append(last_force - to_result + 1 + SEEN)

    def _words(self, number: int, planes: list[int]) -> None:
        """Result words: the header after the gain, forces as their ``planes`` come."""
        frame, before, cycles = self.frames[number], self.before(number), self.cycles
        header = frame.gain + PerFrameFifo.latency + cycles["scaling.latency"]
        if before:
            header = max(header, before.words[-1] + _NEXT_HEADER)
        way = cycles["combine.force_latency"] + cycles["forces.latency"] + cycles["scaling.force_latency"]
        frame.words = self.result_words(header, [plane + way for plane in planes])
