"""What is advised fits, and the next value does not; what is expected of a design is what its two models do."""

from dataclasses import replace

import numpy as np
import pytest

import tfra.model.fixed.feasibility
import tfra.model.fixed.tfra.design
from tfra.model.boussinesq import boussinesq
from tfra.model.choices import FORMATS, Architecture
from tfra.model.fixed.feasibility import AccuracyEstimate, accuracy_estimate, advice, fits
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.sensor import SensorArray

DESIGN = TfraDesign(SensorArray(6, 8, 3e-3, 2e-3, 2e-3), architecture=Architecture(8))
DENSE = TfraDesign(SensorArray(10, 10, 1e-3, 1e-3, 3e-3))
"""A pitch of a third of the cover's thickness."""


def with_fraction(bits: int) -> TfraDesign:
    return replace(DENSE, formats=replace(DENSE.formats, name="custom", vector_fraction=bits))


def test_a_dense_array() -> None:
    assert not fits(DENSE)
    assert advice(DENSE) == "formats.vector_fraction_bits = 3 or sensor.thickness_mm = 2.88"
    assert fits(with_fraction(3))
    assert not fits(with_fraction(4))
    assert fits(replace(DENSE, sensor=replace(DENSE.sensor, thickness=2.88e-3)))


def test_a_third_of_all_lengths_is_advised_a_third_of_the_thickness() -> None:
    sensor = SensorArray(10, 10, 1e-3 / 3, 1e-3 / 3, 1e-3)
    assert advice(replace(DENSE, sensor=sensor)).endswith("sensor.thickness_mm = 0.96")


def test_just_what_is_advised_was_tried(monkeypatch: pytest.MonkeyPatch) -> None:
    tried: list[float] = []

    def remembered(design: TfraDesign) -> bool:
        tried.append(design.sensor.thickness)
        return fits(design)

    monkeypatch.setattr(tfra.model.fixed.feasibility, "fits", remembered)
    assert advice(DENSE).endswith("sensor.thickness_mm = 2.88")
    assert 2.88 / 1000 in tried


@pytest.mark.parametrize("name", FORMATS)
def test_what_fits_needs_no_advice(name: str) -> None:
    assert fits(TfraDesign(SensorArray(6, 8, 3e-3, 2e-3, 2e-3), formats=FORMATS[name]))


def test_sometimes_nothing_helps() -> None:
    """A cover ten times as thick as the pitch."""
    assert advice(replace(DENSE, sensor=replace(DENSE.sensor, thickness=20e-3))) == ""


def test_the_condition_of_a_large_array_is_not_computed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tfra.model.fixed.tfra.design, "MOST_TAXELS", DESIGN.sensor.taxels)
    assert DESIGN.condition
    monkeypatch.setattr(tfra.model.fixed.tfra.design, "MOST_TAXELS", DESIGN.sensor.taxels - 1)
    assert DESIGN.condition is None


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
