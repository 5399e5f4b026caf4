"""Coefficient memories hold every row of every operator where the lanes look for it."""

from __future__ import annotations

import numpy as np
import pytest

from tfra.hdl.parallel.matvec.images import bases, lane_images, passes
from tfra.model.choices import FORMATS, Architecture
from tfra.model.fixed.design import Design
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.fixed.tfra.operators import STACKS
from tfra.model.sensor import SensorArray


def make(rows: int, columns: int, lanes: int, name: str = "standard") -> Design:
    sensor = SensorArray(rows, columns, 4e-3, 2e-3, 3e-3)
    return TfraDesign(sensor, formats=FORMATS[name], architecture=Architecture(mac_lanes=lanes))


@pytest.mark.parametrize(
    "design", [make(2, 2, 4), make(4, 6, 8), make(5, 7, 4), make(5, 7, 20, "wide"), make(10, 10, 100)], ids=str
)
def test_every_coefficient_is_in_its_place_and_all_else_is_zero(design):
    lanes, q = design.architecture.mac_lanes, design.quads
    image, base = lane_images(design), bases(design)
    assert image.shape == (lanes, sum(passes(design, name) * q for name in STACKS))
    left = image.copy()
    for name in STACKS:
        quad = 0
        for op in design.stacks[name].operators:
            for i in range(op.quads):
                for parity in range(4):
                    row = 4 * quad + (parity ^ op.flip)
                    start = base[name] + row // lanes * q
                    assert np.array_equal(image[row % lanes, start : start + q], op.rows[i, parity])
                    left[row % lanes, start : start + q] = 0
                quad += 1
    assert not left.any()


def test_images_of_a_small_design_are_what_they_were_when_checked_by_hand():
    design = make(2, 2, 4)
    contact, sums = design.stacks["contact"].operators
    image = lane_images(design)
    assert image.shape == (4, 2 + 6 + 1 + 3)
    assert image[:, 0].tolist() == contact.rows[0, :, 0].tolist()
    assert image[:, 1].tolist() == sums.rows[0, :, 0].tolist()
    c31 = design.stacks["residual"].operators[2]
    assert c31.flip == 1
    assert image[:, 6].tolist() == c31.rows[0, [1, 0, 3, 2], 0].tolist()
