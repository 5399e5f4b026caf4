"""What is expected of a design is what its two models do."""

from dataclasses import replace

import numpy as np
import pytest

from tfra.model.boussinesq import boussinesq
from tfra.model.choices import FORMATS, Architecture
from tfra.model.fixed.accuracy_estimate import AccuracyEstimate, accuracy_estimate
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.sensor import SensorArray

DESIGN = TfraDesign(SensorArray(6, 8, 3e-3, 2e-3, 2e-3), architecture=Architecture(8))


def test_a_benign_sensor() -> None:
    estimate = accuracy_estimate(DESIGN)
    c33 = boussinesq(DESIGN.sensor)[2]
    values = np.linalg.svd(c33, compute_uv=False)
    assert estimate.condition == pytest.approx(values[0] / values[-1])
    assert estimate.contacts > 200
    assert estimate.equal >= 0.97
    assert not estimate.doubtful
    assert str(estimate) == (
        f"cond(C33) is {estimate.condition:.3g}; {100 * estimate.equal:.1f} % of {estimate.contacts} random contacts"
        " end at float's sweep index"
    )


def test_short_words_are_doubtful() -> None:
    """Six bits of coefficients."""
    formats = replace(FORMATS["standard"], name="custom", coefficient=6, vector_fraction=0)
    estimate = accuracy_estimate(replace(DESIGN, formats=formats))
    assert estimate.doubtful
    assert estimate.equal < 0.9


def test_nothing_swept_is_nothing_doubted() -> None:
    assert not AccuracyEstimate(None, 0, 1.0).doubtful
    assert str(AccuracyEstimate(None, 0, 1.0)).startswith("100.0 % of 0")
