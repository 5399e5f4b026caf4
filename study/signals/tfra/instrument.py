"""The instrument for TFRA: signals of its bit-accurate model beside the same stages in float64."""

from collections.abc import Iterator

import numpy as np

from tfra.model.arrays import Bools, Floats, Ints
from tfra.model.fixed.butterfly import butterfly, to_quads
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.fixed.tfra.pipeline import FixedTfra, Trace
from tfra.model.tfra import TIE, Status, Tfra
from tfra.study.signals.tfra.observation import catalogue, observe
from tfra.study.signals.tfra.reference import Decisions, Reference, Values
from tfra.study.signals.tfra.signals import last_bits, only, stage_of, words
from tfra.study.signals.words import Observed


class TfraInstrument:
    """See :class:`tfra.study.signals.instrument.Instrument`."""

    def __init__(self, design: TfraDesign) -> None:
        self._design = design
        self._model = FixedTfra(design)
        self._reference = Reference(design)
        self._float = Tfra.of(design, design.exact_operators)
        one_each = to_quads(design, np.eye(design.sensor.taxels, dtype=np.int64))
        self._carries = butterfly(one_each).any(axis=0)  # on middle lines the odd parities are no words at all
        self.catalogue = catalogue(design)

    def stage(self, signal: str) -> str:
        """The stage of ``signal``."""
        return stage_of(signal)

    def traces(self, codes: Ints) -> Iterator[Trace]:
        """Results of every block for converter codes ``(n, rows, columns)``."""
        return self._model.traces(codes)

    def observe(self, trace: Trace) -> dict[str, Observed]:
        """Every signal of the catalogue."""
        return observe(self._design, trace)

    def comparable(self, trace: Trace) -> Bools:
        """Frames that are swept, and whose results are all within their words."""
        return np.asarray(trace.frame.regular & ~trace.scaled.saturated)

    def compare(self, trace: Trace, frames: Bools) -> dict[tuple[str, str], tuple[Floats, Floats]]:
        """Float64 values and errors in LSB, by signal and reference."""
        trace = only(trace, frames)
        decided = Decisions.of(self._design, trace)
        by_name, lsb = words(self._design, trace), last_bits(self._design, trace)
        inputs: Values = {name: word * lsb.get(name, 1) for name, word in by_name.items()}
        inputs["codes"] = trace.codes
        references = {
            "codes": self._reference.from_codes(trace.codes, decided),
            "inputs": self._reference.from_inputs(inputs, decided),
        }
        compared = {}
        for name, word in by_name.items():
            for reference, values in references.items():
                exact = values[name] / lsb.get(name, 1)
                error = np.asarray(word - exact, dtype=np.float64)
                if word.shape[1:] == self._carries.shape:
                    exact, error = exact[:, self._carries], error[:, self._carries]
                compared[name, reference] = exact, error
        return compared

    def flips(self, trace: Trace) -> dict[str, Ints]:
        """Decisions of any frames, each compared where those before it agree."""
        codes, sensor, counts = trace.codes, self._design.sensor, {}
        exact = self._float(codes.reshape(len(codes), sensor.rows, sensor.columns) * self._design.adc.lsb)
        frame, direction = trace.frame, trace.direction

        def has(flag: Status) -> Bools:
            return np.asarray(exact.status & flag != 0)

        def count(decision: str, frames: Bools, same: Bools) -> Bools:
            """Count the ``frames`` that are compared, and those that differ; return those that agree."""
            counts[decision] = np.array([frames.sum(), (frames & ~same).sum()])
            return frames & same

        contact, swept = ~has(Status.NO_CONTACT), ~has(Status.NO_CONTACT | Status.COMPRESSION_ONLY)
        alike = count("contact", np.ones(len(codes), dtype=np.bool_), contact == frame.contact)
        alike = count("traction", alike & contact, swept == frame.regular) & swept
        alike = count("no direction", alike, has(Status.NO_DIRECTION) == direction.vanishing)
        cos, sin = self._reference.direction(codes, ~alike | direction.vanishing).T
        sweep_y = np.abs(sin) > np.abs(cos) * (1 + TIE)
        alike = count("swept variable", alike, sweep_y == direction.sweep_y)
        alike = count("sign", alike, (np.where(sweep_y, sin, cos) < 0) == direction.negative)
        alike = count("no denominator", alike, has(Status.VANISHING_DENOMINATOR) == trace.affine.vanishing)
        apart = np.abs(exact.sweep_index - trace.chosen.index)
        count("sweep index, by more than one step", alike, apart <= 1)
        alike = count("sweep index", alike, apart == 0)
        count("out of range", alike, has(Status.DEPENDENT_OUT_OF_RANGE) == trace.chosen.out_of_range)
        return counts
