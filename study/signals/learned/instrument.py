"""The instrument for the learned estimator."""

from collections.abc import Mapping

import numpy as np

from tfra.model.arrays import Bools, Floats, Ints
from tfra.model.fixed.learned.design import LearnedDesign
from tfra.model.fixed.learned.pipeline import Trace
from tfra.model.tfra import Status
from tfra.study.signals.instrument import Counter, Instrument
from tfra.study.signals.learned.observation import catalogue, observe
from tfra.study.signals.learned.reference import Decisions, Reference
from tfra.study.signals.learned.signals import FOLDED, last_bits, stage_of, words
from tfra.study.signals.measures import Measures, Observed, Word


class LearnedInstrument(Instrument[LearnedDesign]):
    """The signals inside the network and the forward model; errors are those of frames with a direction."""

    over_array = FOLDED
    reference: Reference

    def __init__(self, design: LearnedDesign) -> None:
        super().__init__(design)
        self.reference = Reference(design)
        self._float = design.float_model

    @property
    def catalogue(self) -> Mapping[str, Word]:
        return catalogue(self.design)

    def stage_of(self, signal: str) -> str:
        return stage_of(signal)

    def observe(self, trace: Trace) -> Mapping[str, Observed]:
        return observe(self.design, trace)

    def comparable(self, trace: Trace) -> Bools:
        limited = trace.judged.limited | trace.friction.overflow
        if trace.field is not None:
            limited = limited | trace.field.limited | trace.field.share.even
        return np.asarray(trace.frame.contact & ~trace.turned.still & ~limited)

    def words(self, trace: Trace) -> Mapping[str, Ints]:
        return words(self.design, trace)

    def last_bits(self, trace: Trace) -> Mapping[str, Floats]:
        return last_bits(self.design)

    def decisions(self, trace: Trace) -> Decisions:
        return Decisions.of(self.design, trace)

    def flips(self, trace: Trace) -> Measures:
        codes, sensor, count = trace.codes, self.design.sensor, Counter()
        exact = self._float(codes.reshape(len(codes), sensor.rows, sensor.columns) * self.design.adc.lsb)

        def has(flag: Status) -> Bools:
            return np.asarray(exact.status & flag != 0)

        contact = ~has(Status.NO_CONTACT)
        alike = count("contact", np.ones(len(codes), dtype=np.bool_), contact == trace.frame.contact) & contact
        count("no direction", alike, has(Status.NO_DIRECTION) == trace.turned.still)
        count("implausible", alike, has(Status.IMPLAUSIBLE) == trace.judged.implausible)
        return {"flips": count.rows}
