"""Timeline of the learned estimator's core."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from tfra.hdl.lib.streams import PerFrameFifo
from tfra.hdl.parallel.core import timeline as engine
from tfra.hdl.parallel.core.timeline import SEEN
from tfra.hdl.parallel.learned.plan import FRAMES, UNITS, plan
from tfra.model.fixed.learned.design import LearnedDesign


@dataclass
class Frame(engine.Frame):
    """Cycles of one frame's events, in dataflow order."""

    friction: int = 0
    begun: int = 0
    """The first word enters the field."""
    mantissas: list[int] = field(default_factory=list)


class LearnedTimeline(engine.Timeline[Frame]):
    """The events of ``number`` frames; ``cycles`` are those of the blocks, by the names of ``stated``.

    ======= ==================================================================================================
    product what follows from its results
    ======= ==================================================================================================
    first   units: the operands of the second product, and of the field's
    second  units: the operand of the read-out
    read    total -> resultant -> angle, friction -> ``friction`` -> header
    field   field, from ``begun`` -> share -> ``mantissas`` -> forces -> ``words``
    ======= ==================================================================================================
    """

    stated = (
        "normaliser.latency",
        "activation.latency",
        "total.latency",
        "resultant.latency",
        "friction.latency",
        "field.vectors_latency",
        "field.latency",
        "field.interval",
        "share.latency",
        "share.interval",
        "forces.latency",
        "words.latency",
    )

    def __init__(self, design: LearnedDesign, cycles: Mapping[str, int], number: int) -> None:
        tokens = {"frame_token": FRAMES, "scalars_token": 1}
        super().__init__(design, plan(design), cycles, [Frame() for _ in range(number)], tokens)
        self._sources = {source.name: source.stacks[0] for source in plan(design).sources}
        self.run()

    def after(self, stack: str, number: int, results: list[int]) -> None:
        """Follow the results of a product."""
        if stack == "read":
            self._read(number, results)
        elif stack == "field":
            self._field(number, results)
        else:
            self._units(stack, number, results)

    def _units(self, stack: str, number: int, results: list[int]) -> None:
        """Units at the buffers of the next products."""
        last = -1
        for op in self.design.stacks[stack].operators:
            last += op.quads
            if op.name in UNITS:
                next_stack = self._sources[UNITS[op.name]]
                self.products.add(next_stack, number, results[last] + self.cycles["activation.latency"])

    def _read(self, number: int, results: list[int]) -> None:
        """Outputs, and the scalars of the header."""
        blocks = ("total.latency", "resultant.latency", "friction.latency")
        frame = self.frames[number]
        frame.friction = results[0] + sum(self.cycles[block] for block in blocks)
        self.tokens["scalars_token"].append(frame.friction + SEEN)
        if "field" not in self.design.stacks:
            self._words(number)

    def _field(self, number: int, results: list[int]) -> None:
        """The field begins after the one before, and so do the mantissas."""
        cycles, frame, before = self.cycles, self.frames[number], self.before(number)
        begin = [results[-1] + cycles["field.vectors_latency"], frame.friction + PerFrameFifo.latency]
        if before:
            begin += [before.begun + cycles["field.interval"], before.mantissas[-1]]
        frame.begun = max(begin)
        first = frame.begun + cycles["field.latency"] + cycles["share.latency"]
        frame.mantissas = [first + axis * cycles["share.interval"] for axis in range(3)]
        self._words(number)

    def _words(self, number: int) -> None:
        """Result words: the header when it is complete, each plane after its mantissa."""
        frame, cycles, before = self.frames[number], self.cycles, self.before(number)
        way = PerFrameFifo.latency + cycles["words.latency"]
        header = max(frame.friction + way, before.words[-1] + 1 if before else 0)
        planes = [mantissa + way + cycles["forces.latency"] for mantissa in frame.mantissas]
        frame.words = self.result_words(header, planes)
        self.tokens["frame_token"].append(frame.words[-1] + SEEN)
