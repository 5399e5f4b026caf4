"""The error by source: identical frames with one more influence at a time.

==========  =========================================================  =================================
Step        What is estimated, and from what                           Its own share of the error
==========  =========================================================  =================================
method      the estimator in float on exact stress                     the method's, against the truth
noise       the same on stress with noise and offset                   of noise and offset
converter   the same on codes of the converter times its LSB           of rounding and clipping
arithmetic  the bit-accurate model on the same codes                   of the word lengths
==========  =========================================================  =================================

All four have the same contact threshold, search and plateau tolerance.  A step has two errors in each quantity:
``total`` is its result less the truth, ``own`` its result less that of the step before, in the same unit.  Own shares
of signed quantities add up to the total.
"""

from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from functools import lru_cache

import numpy as np
import numpy.typing as npt
import polars as pl

from tfra.model.arrays import Bools, Floats, Ints
from tfra.model.choices import Adc
from tfra.model.converter import convert, saturated
from tfra.model.fixed.design import Design
from tfra.model.fixed.tfra.centroids import centroids
from tfra.model.fixed.words import decode
from tfra.model.metrics import rotation_deg
from tfra.model.tfra import TIE, Result, Status
from tfra.sim.compiled import quickest
from tfra.study.frames.block import Block, with_noise


class Step(StrEnum):
    """Influences in their order."""

    METHOD = "method"
    NOISE = "noise"
    CONVERTER = "converter"
    ARITHMETIC = "arithmetic"


class View(StrEnum):
    """Reference of an error: the ground truth, or the step before."""

    TOTAL = "total"
    OWN = "own"


SIGNED = {
    "phi_deg": True,
    "mu": True,
    "force_x_n": True,
    "force_y_n": True,
    "force_z_n": True,
    "force_modulus_percent_of_true_force": True,
    "force_difference_percent_of_true_force": False,
    "taxel_forces_percent_of_true_taxel_forces": False,
}
"""Every quantity, with its unit, and whether its error has a sign.

The last two are lengths of differences: of the resultants over |F|, and of the vectors of all taxels' forces, both of
their true lengths.
"""

Estimate = Result | Block
"""A result, or the truth."""


@dataclass(frozen=True)
class _Float:
    """The float estimator of a design; those of one kind with the same settings are the same."""

    settings: tuple[Hashable, ...]
    design: Design = field(compare=False)

    @classmethod
    def of(cls, design: Design) -> "_Float":
        return cls((design.estimator, *design.float_settings), design)

    @property
    def model(self) -> Callable[[npt.ArrayLike], Result]:
        """Made when it is asked for, since most designs share results that are there."""
        return self.design.float_model


class Cascade:
    """The steps of any designs for the same sensor on one ``block``; float results that they share are computed once.

    ``normal`` returns the noise of the block at unit deviation, for designs with other noise than the frames' own.
    """

    def __init__(self, block: Block, normal: Callable[[], Floats] | None = None) -> None:
        self._exact, self._normal = block, normal
        # Few of each are stored: designs that follow each other share most.
        self._block = lru_cache(maxsize=1)(self._with_noise)
        self._method = lru_cache(maxsize=4)(self._make_method)
        self._noise = lru_cache(maxsize=4)(self._make_noise)
        self._converted: dict[tuple[_Float, float | None, Adc], Result] = {}  # the last one alone

    def __call__(
        self, design: Design, compared: Sequence[Step] = tuple(Step), noise: float | None = None
    ) -> pl.DataFrame:
        """A row each frame: errors by :func:`error_column`, decisions by :func:`decision_column`, ``frame``.

        Errors are those of the steps ``compared``, in single precision; a frame with all takes some 290 bytes.
        ``noise`` is a deviation as a share of the frame's peak instead of the frame's own.  A table does not depend on
        other blocks or designs, so those of all blocks, concatenated in order, are that of a part, bit for bit, if BLAS
        has the same number of threads in all processes.
        """
        block = self._block(noise)
        codes = convert(design, block.noisy)
        columns: dict[str, Floats | Ints | Bools] = {"frame": block.start + np.arange(len(block))}
        before: Estimate = block
        for step, result in self._results(design, noise, codes).items():
            decisions = _decisions(design, step, codes, result)
            columns |= {decision_column(key, step): values for key, values in decisions.items()}
            for view, reference in ((View.TOTAL, block), (View.OWN, before)) if step in compared else ():
                errors = differences(block, reference, result)
                columns |= {error_column(key, step, view): values for key, values in errors.items()}
            before = result
        types = {key: kind for key, kind in _TYPES.items() if key in columns}
        return pl.DataFrame(columns).with_columns(pl.col(key).cast(kind) for key, kind in types.items())

    def _results(self, design: Design, noise: float | None, codes: Ints) -> dict[Step, Result]:
        in_float = _Float.of(design)
        key = in_float, noise, design.adc
        if key not in self._converted:
            result = in_float.model(codes * design.adc.lsb)
            clipped = np.where(saturated(design, codes), Status.INPUT_SATURATED, 0)  # which float can't detect itself
            self._converted = {key: replace(result, status=result.status | clipped)}
        return {
            Step.METHOD: self._method(in_float),
            Step.NOISE: self._noise(in_float, noise),
            Step.CONVERTER: self._converted[key],
            Step.ARITHMETIC: decode(design, quickest(design)(codes)),
        }

    def _with_noise(self, noise: float | None) -> Block:
        exact = self._exact
        if noise is None:
            return exact
        assert self._normal is not None
        drawn = "offset_share_of_peak" in exact.truth.columns
        offset = exact.truth["offset_share_of_peak"].to_numpy() if drawn else 0.0
        return replace(exact, noisy=with_noise(exact.stress, noise, offset, self._normal()))

    def _make_method(self, in_float: _Float) -> Result:
        return in_float.model(self._exact.stress)

    def _make_noise(self, in_float: _Float, noise: float | None) -> Result:
        return in_float.model(self._block(noise).noisy)


def differences(truth: Estimate, start: Estimate, end: Estimate) -> dict[str, Floats]:
    """Return the differences between two estimates, by the keys of ``SIGNED``, ``(n,)`` each.

    Percentages are of the ``truth``; undefined and unknown values are nan.
    """
    force, field = end.resultant - start.resultant, _field(end) - _field(start)
    modulus, length = (np.linalg.norm(vectors, axis=1) for vectors in (truth.resultant, _field(truth)))
    longer = np.linalg.norm(end.resultant, axis=1) - np.linalg.norm(start.resultant, axis=1)
    values = (
        rotation_deg(start.phi_deg, end.phi_deg),
        end.mu - start.mu,
        *force.T,
        _percent(longer, modulus),
        _percent(np.linalg.norm(force, axis=1), modulus),
        _percent(np.linalg.norm(field, axis=1), length),
    )
    return dict(zip(SIGNED, values, strict=True))


def error_column(quantity: str, step: Step, view: View) -> str:
    """Name of the column of an error."""
    return f"{quantity}.{step}.{view}"


def decision_column(decision: str, step: Step) -> str:
    """Name of the column of a decision, one of ``DECISIONS``."""
    return f"{decision}.{step}"


DECISIONS = {
    "status": pl.Int16,
    "quadrant": pl.Int8,
    "sweep_y": pl.Boolean,
    "negative": pl.Boolean,
    "sweep_index": pl.Int16,
}
"""The decisions of a step, and their coding: status bits, quadrant of the tangential force (0 to 3), whether mu_y is
swept, whether over [-1, 0], and the winner's index; the last three of estimators that sweep."""

_TYPES = {
    **{error_column(key, step, view): pl.Float32 for key in SIGNED for step in Step for view in View},
    **{decision_column(key, step): kind for key, kind in DECISIONS.items() for step in Step},
}


def _field(estimate: Estimate) -> Floats:
    """Forces of all taxels as one vector, ``(n, 3 m)``."""
    return estimate.forces.reshape(len(estimate.forces), -1)


def _percent(part: Floats, whole: Floats) -> Floats:
    return 100.0 * np.divide(part, whole, out=np.full_like(part, np.nan), where=whole > 0)


def _decisions(design: Design, step: Step, codes: Ints, result: Result) -> dict[str, Ints | Bools]:
    """Decisions of a step; an estimator that sweeps nothing has the first two alone."""
    decisions: dict[str, Ints | Bools] = {
        "status": result.status,
        "quadrant": (result.phi_deg // 90.0).astype(np.int64),
    }
    if not design.sweeps:
        return decisions
    decisions["sweep_index"] = result.sweep_index
    if step is Step.ARITHMETIC:
        exact = centroids(design, codes.reshape(len(codes), -1))
        return decisions | _decisions_of_words(exact.cos, exact.sin, exact.sweep_y)
    cos, sin = np.cos(np.radians(result.phi_deg)), np.sin(np.radians(result.phi_deg))
    sweep_y = np.abs(sin) > np.abs(cos) * (1 + TIE)  # float keeps a direction in degrees well within TIE
    return decisions | {"sweep_y": sweep_y, "negative": np.where(sweep_y, sin, cos) < 0}


def _decisions_of_words(cos: Ints, sin: Ints, sweep_y: Bools) -> dict[str, Ints | Bools]:
    """The same after the words of a direction; phi as a result word would be rounded."""
    quadrant = np.select([(cos > 0) & (sin >= 0), (cos <= 0) & (sin > 0), (cos < 0) & (sin <= 0)], [0, 1, 2], 3)
    return {"quadrant": quadrant, "sweep_y": sweep_y, "negative": np.where(sweep_y, sin, cos) < 0}
