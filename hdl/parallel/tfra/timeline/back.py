"""Timeline of the blocks after the products: their events follow frame by frame from their inputs."""

from __future__ import annotations

from tfra.hdl.lib.streams import Buffer, PerFrameFifo
from tfra.hdl.parallel.tfra.sums_queue import SumsQueue
from tfra.hdl.parallel.tfra.timeline.events import NEVER, Events, Span
from tfra.hdl.parallel.tfra.timeline.products import Product

_NEXT_GAIN, _NEXT_FRAME = 2, 2
"""Cycles from a frame's gain, or last result word, to the first cycle of the next: it is taken, then seen as free."""


class Back:
    """Events that the results of each product cause."""

    def __init__(self, events: Events) -> None:
        self._events = events
        self._swept = -NEVER
        """Last quad of the frame before at the sweep."""

    def after(self, product: Product) -> None:
        """Follow the results of ``product``."""
        {"contact": self._contact, "residual": self._residual, "normal": self._normal, "force": self._force}[
            product.stack
        ](product)

    def _contact(self, product: Product) -> None:
        """Weights, and the sums of b."""
        frame, quads = self._events.frames[product.frame], self._events.design.quads
        frame.n = product.results[quads - 1] + self._events.blocks.weights
        frame.sums_b = product.results[quads]

    def _residual(self, product: Product) -> None:
        """The sums of n, which come first, with those of b to alpha and beta."""
        events, wait = self._events, self._events.blocks
        frame, before = events.frames[product.frame], events.before(product.frame)
        frame.residual = product.results[-1] + events.design.cycles_per_quad - 1
        taken = max(frame.sums_b + SumsQueue.latency, before.affine + 1 if before else 0)
        for cycle in product.results[:3]:
            taken = max(cycle + SumsQueue.latency, taken + SumsQueue.interval)
        frame.affine = max(taken, frame.direction + Buffer.latency + PerFrameFifo.latency - 1) + wait.dependent
        events.spans.append(Span("dependent", "alpha, beta", product.frame, taken, frame.affine))

    def _normal(self, product: Product) -> None:
        """p or q; after both the sweep."""
        frame, design = self._events.frames[product.frame], self._events.design
        frame.normal += [cycle + design.cycles_per_quad - 1 for cycle in product.results]
        if len(frame.normal) == 2 * design.quads:
            self._sweep(product.frame)
            self._scalars(product.frame)

    def _force(self, product: Product) -> None:
        """Products enter the vector updates beat by beat; then the updates are done with the frame."""
        events, beats = self._events, self._events.design.cycles_per_quad
        frame = events.frames[product.frame]
        frame.force = [cycle + beats - 1 for cycle in product.results]
        events.force_beats |= {cycle + beat for cycle in product.results for beat in range(beats)}
        events.frame_tokens.give(frame.force[-1] + 1)
        events.spans.append(Span("combine", "forces", product.frame, product.results[0], frame.force[-1] + 1))
        self._words(product.frame)

    def _sweep(self, number: int) -> None:
        """The winner's index."""
        frame, wait, quads = self._events.frames[number], self._events.blocks, self._events.design.quads
        entered = self._swept + wait.quad - wait.e0
        for cycle in frame.normal[:quads]:
            entered = max(cycle, entered + wait.e0)
        start = entered = max(entered + wait.turn - wait.quad, self._swept + wait.frame_interval - wait.quad)
        for cycle in frame.normal[quads:]:
            entered = max(cycle, entered + wait.quad)
        self._swept = entered
        frame.index = entered + wait.sweep
        self._events.spans.append(Span("sweep", "candidates", number, start + wait.quad, frame.index))

    def _scalars(self, number: int) -> None:
        """Events after the index: friction, resultant, gain."""
        events, wait = self._events, self._events.blocks
        frame, before = events.frames[number], events.before(number)
        frame.chosen = frame.index + wait.friction
        begin = max(frame.chosen + PerFrameFifo.latency, before.total + 1 if before else 0)
        frame.total = begin + wait.resultant
        begin = max(frame.total + PerFrameFifo.latency, before.gain + _NEXT_GAIN if before else 0)
        frame.gain = begin + wait.gain
        events.spans.append(Span("gain", "gain", number, begin, frame.gain))

    def _words(self, number: int) -> None:
        """Result words: the header after the gain, forces as their planes come, never two in a cycle."""
        events, design, wait = self._events, self._events.design, self._events.blocks
        frame, before = events.frames[number], events.before(number)
        cycle = frame.gain + PerFrameFifo.latency + wait.scaling - 1
        if before:
            cycle = max(cycle, before.words[-1] + _NEXT_FRAME)
        header = next(field.start for field in design.layout if field.name == "forces")
        taxels = design.sensor.taxels
        for word in range(design.frame_words):
            cycle += 1
            plane, taxel = divmod(word - header, taxels)
            if taxel == 0 and 0 <= plane < 3:
                cycle = max(cycle, frame.force[(plane + 1) * design.quads - 1] + wait.plane)
            frame.words.append(cycle)
        events.plane_tokens.give(frame.words[header + 3 * taxels - 1] - wait.read + 1)
        events.spans.append(Span("scaling", "result", number, frame.words[0], frame.words[-1] + 1))
