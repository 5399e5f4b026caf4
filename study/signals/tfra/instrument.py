"""The instrument for TFRA: measures of its signals, frame by frame."""

import numpy as np

from tfra.model.arrays import Bools, Ints
from tfra.model.fixed.butterfly import butterfly, to_quads
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.fixed.tfra.pipeline import FixedTfra, Trace
from tfra.model.tfra import TIE, Status, Tfra
from tfra.study.signals.measures import REFERENCES, Measures, Row, errors_of, range_of, total
from tfra.study.signals.tfra.observation import observe
from tfra.study.signals.tfra.reference import Decisions, Reference, Values
from tfra.study.signals.tfra.signals import last_bits, only, words


class Instrument:
    """The signals inside the bit-accurate model of ``design``, beside float64."""

    def __init__(self, design: TfraDesign) -> None:
        self._design = design
        self._model = FixedTfra(design)
        self._reference = Reference(design)
        self._float = Tfra.of(design, design.exact_operators)
        one_each = to_quads(design, np.eye(design.sensor.taxels, dtype=np.int64))
        self._carries = butterfly(one_each).any(axis=0)  # on middle lines the odd parities are no words at all

    def measure(self, codes: Ints) -> Measures:
        """All measures over converter codes ``(n, rows, columns)``."""
        parts = (self.ranges, self.errors, self.flips)
        return total(part(trace) for trace in self._model.traces(codes) for part in parts)

    def ranges(self, trace: Trace) -> Measures:
        """Use of the words of every signal of the catalogue."""
        observed = observe(self._design, trace) if len(trace.codes) else {}
        return {"ranges": {signal: range_of(words) for signal, words in observed.items()}}

    def errors(self, trace: Trace) -> Measures:
        """Errors against both references, of frames that are swept, and whose results are all within their words."""
        comparable = np.asarray(trace.frame.regular & ~trace.scaled.saturated)
        if not comparable.any():
            return {}
        trace = only(trace, comparable)
        decided = Decisions.of(self._design, trace)
        by_name, lsb = words(self._design, trace), last_bits(self._design, trace)
        inputs: Values = {name: word * lsb.get(name, 1) for name, word in by_name.items()}
        inputs["codes"] = trace.codes
        values = self._reference.from_codes(trace.codes, decided), self._reference.from_inputs(inputs, decided)
        errors: dict[str, dict[str, Row]] = {reference: {} for reference in REFERENCES}
        for name, word in by_name.items():
            for reference, of_reference in zip(REFERENCES, values, strict=True):
                exact = of_reference[name] / lsb.get(name, 1)
                error = np.asarray(word - exact, dtype=np.float64)
                if word.shape[1:] == self._carries.shape:
                    exact, error = exact[:, self._carries], error[:, self._carries]
                errors[reference][name] = errors_of(exact, error)
        return errors

    def flips(self, trace: Trace) -> Measures:
        """Decisions of any frames, each compared where those before it agree."""
        codes, sensor, rows = trace.codes, self._design.sensor, {}
        exact = self._float(codes.reshape(len(codes), sensor.rows, sensor.columns) * self._design.adc.lsb)
        frame, direction = trace.frame, trace.direction

        def has(flag: Status) -> Bools:
            return np.asarray(exact.status & flag != 0)

        def count(decision: str, frames: Bools, same: Bools) -> Bools:
            """Count the ``frames`` that are compared, and those that differ; return those that agree."""
            rows[decision] = {"frames": int(frames.sum()), "flips": int((frames & ~same).sum())}
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
        return {"flips": rows}
