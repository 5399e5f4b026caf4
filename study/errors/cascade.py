"""The error by source: identical frames with one more influence at a time.

==========  =========================================================  =================================
Step        What is estimated, and from what                           Its own share of the error
==========  =========================================================  =================================
method      float TFRA on exact stress                                 the algorithm's, against the truth
noise       float TFRA on stress with noise and offset                 of noise and offset
converter   float TFRA on codes of the converter times its LSB         of rounding and clipping
arithmetic  the bit-accurate model on the same codes                   of the word lengths
==========  =========================================================  =================================

All four have the same contact threshold, search and plateau tolerance.  A step has two errors in each quantity:
``total`` is its result less the truth, ``own`` its result less that of the step before, in the same unit.  Own shares
of signed quantities add up to the total.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from enum import StrEnum
from typing import Protocol

import numpy as np
import polars as pl

from tfra.model.arrays import Bools, Floats, Ints
from tfra.model.converter import convert, saturated
from tfra.model.fixed.design import Design
from tfra.model.fixed.tfra.centroids import centroids
from tfra.model.fixed.words import decode
from tfra.model.metrics import Contact, rotation_deg
from tfra.model.tfra import TIE, Result, Status, Tfra
from tfra.study.frames.block import Block


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


class Estimate(Contact, Protocol):
    """A result, or the truth."""

    @property
    def forces(self) -> Floats:
        """``(n, 3, rows, columns)`` N."""


class Cascade:
    """All steps of one design."""

    def __init__(self, design: Design) -> None:
        self.design = design
        self._tfra = Tfra.of(design)

    def __call__(self, block: Block) -> pl.DataFrame:
        """Return a row each frame: errors by :func:`error_column`, decisions by :func:`decision_column`, ``frame``.

        A table does not depend on other blocks, so the tables of blocks, concatenated in order, are that of a part, bit
        for bit, if BLAS has the same number of threads in all processes. Errors are in single precision; a frame takes
        some 290 bytes.
        """
        codes = convert(self.design, block.noisy)
        return scores(self.design, block, codes, self.results(block, codes))

    def results(self, block: Block, codes: Ints) -> dict[Step, Result]:
        """Estimates of each step for ``block``, whose converter codes are ``codes``."""
        return {
            Step.METHOD: self._tfra(block.stress),
            Step.NOISE: self._tfra(block.noisy),
            Step.CONVERTER: from_codes(self.design, self._tfra, codes),
            Step.ARITHMETIC: decode(self.design, self.design.model(codes).words),
        }


def from_codes(design: Design, tfra: Tfra, codes: Ints) -> Result:
    """Estimate of float arithmetic from ``codes``, flagged where the converter clipped, which it cannot detect
    itself."""
    found = tfra(codes * design.adc.lsb)
    clipped = np.where(saturated(design, codes), Status.INPUT_SATURATED, 0)
    return replace(found, status=found.status | clipped)


def scores(
    design: Design, block: Block, codes: Ints, results: Mapping[Step, Result], compared: Sequence[Step] = tuple(Step)
) -> pl.DataFrame:
    """One row a frame, as a cascade returns it, with the errors of the steps ``compared`` only.

    ``codes`` are the input of the fixed-point result of ``results``.
    """
    columns: dict[str, Floats | Ints | Bools] = {"frame": block.start + np.arange(len(block))}
    before: Estimate = block
    for step, found in results.items():
        exact = centroids(design, codes.reshape(len(codes), -1)) if step is Step.ARITHMETIC else None
        decided = _decided(found) if exact is None else _decided_in_words(exact.cos, exact.sin, exact.sweep_y)
        decided |= {"status": found.status, "sweep_index": found.sweep_index}
        columns |= {decision_column(key, step): values for key, values in decided.items()}
        for view, reference in ((View.TOTAL, block), (View.OWN, before)) if step in compared else ():
            errors = differences(block, reference, found)
            columns |= {error_column(key, step, view): values for key, values in errors.items()}
        before = found
    return pl.DataFrame(columns).with_columns(pl.col(key).cast(kind) for key, kind in _TYPES.items() if key in columns)


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
swept, whether over [-1, 0], and the winner's index."""

_TYPES = {
    **{error_column(key, step, view): pl.Float32 for key in SIGNED for step in Step for view in View},
    **{decision_column(key, step): kind for key, kind in DECISIONS.items() for step in Step},
}


def _field(estimate: Estimate) -> Floats:
    """Forces of all taxels as one vector, ``(n, 3 m)``."""
    return estimate.forces.reshape(len(estimate.forces), -1)


def _percent(part: Floats, whole: Floats) -> Floats:
    return 100.0 * np.divide(part, whole, out=np.full_like(part, np.nan), where=whole > 0)


def _decided(found: Result) -> dict[str, Ints | Bools]:
    """Decisions after a direction in degrees, which float arithmetic keeps well within ``TIE``."""
    cos, sin = np.cos(np.radians(found.phi_deg)), np.sin(np.radians(found.phi_deg))
    sweep_y = np.abs(sin) > np.abs(cos) * (1 + TIE)
    quadrant = (found.phi_deg // 90.0).astype(np.int64)
    return {"quadrant": quadrant, "sweep_y": sweep_y, "negative": np.where(sweep_y, sin, cos) < 0}


def _decided_in_words(cos: Ints, sin: Ints, sweep_y: Bools) -> dict[str, Ints | Bools]:
    """The same after the words of a direction; phi as a result word would be rounded."""
    quadrant = np.select([(cos > 0) & (sin >= 0), (cos <= 0) & (sin > 0), (cos < 0) & (sin <= 0)], [0, 1, 2], 3)
    return {"quadrant": quadrant, "sweep_y": sweep_y, "negative": np.where(sweep_y, sin, cos) < 0}
