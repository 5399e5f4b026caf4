"""The instrument for TFRA."""

from collections.abc import Mapping

import numpy as np

from tfra.model.arrays import Bools, Floats, Ints
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.fixed.tfra.pipeline import Trace
from tfra.model.tfra import TIE, Status, Tfra
from tfra.study.signals.instrument import Counter, Instrument
from tfra.study.signals.measures import Measures, Observed, Word
from tfra.study.signals.tfra.observation import catalogue, observe
from tfra.study.signals.tfra.reference import Decisions, Reference
from tfra.study.signals.tfra.signals import FOLDED, last_bits, stage_of, words


class TfraInstrument(Instrument[TfraDesign]):
    """The signals inside TFRA; errors are those of frames that are swept."""

    over_array = FOLDED
    reference: Reference

    def __init__(self, design: TfraDesign) -> None:
        super().__init__(design)
        self.reference = Reference(design)
        self._float = Tfra.of(design, design.exact_operators)

    @property
    def catalogue(self) -> Mapping[str, Word]:
        return catalogue(self.design)

    def stage_of(self, signal: str) -> str:
        return stage_of(signal)

    def observe(self, trace: Trace) -> Mapping[str, Observed]:
        return observe(self.design, trace)

    def comparable(self, trace: Trace) -> Bools:
        return np.asarray(trace.frame.regular & ~trace.scaled.saturated)

    def words(self, trace: Trace) -> Mapping[str, Ints]:
        return words(self.design, trace)

    def last_bits(self, trace: Trace) -> Mapping[str, Floats]:
        return last_bits(self.design, trace)

    def decisions(self, trace: Trace) -> Decisions:
        return Decisions.of(self.design, trace)

    def flips(self, trace: Trace) -> Measures:
        codes, sensor, count = trace.codes, self.design.sensor, Counter()
        exact = self._float(codes.reshape(len(codes), sensor.rows, sensor.columns) * self.design.adc.lsb)
        frame, direction = trace.frame, trace.direction

        def has(flag: Status) -> Bools:
            return np.asarray(exact.status & flag != 0)

        contact, swept = ~has(Status.NO_CONTACT), ~has(Status.NO_CONTACT | Status.COMPRESSION_ONLY)
        alike = count("contact", np.ones(len(codes), dtype=np.bool_), contact == frame.contact)
        alike = count("traction", alike & contact, swept == frame.regular) & swept
        alike = count("no direction", alike, has(Status.NO_DIRECTION) == direction.vanishing)
        cos, sin = self.reference.direction(codes, ~alike | direction.vanishing).T
        sweep_y = np.abs(sin) > np.abs(cos) * (1 + TIE)
        alike = count("swept variable", alike, sweep_y == direction.sweep_y)
        alike = count("sign", alike, (np.where(sweep_y, sin, cos) < 0) == direction.negative)
        alike = count("no denominator", alike, has(Status.VANISHING_DENOMINATOR) == trace.affine.vanishing)
        apart = np.abs(exact.sweep_index - trace.chosen.index)
        count("sweep index, by more than one step", alike, apart <= 1)
        alike = count("sweep index", alike, apart == 0)
        count("out of range", alike, has(Status.DEPENDENT_OUT_OF_RANGE) == trace.chosen.out_of_range)
        return {"flips": count.rows}
