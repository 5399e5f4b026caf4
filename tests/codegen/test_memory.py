"""The count of memory against the images, and the choice at the edge of a block."""

from dataclasses import replace

import pytest

from tests.model.cases import make_design
from tfra.codegen.memory import BLOCK, blocks, economical
from tfra.hdl.parallel.matvec.images import depth, lane_images
from tfra.model.cover.scenes import SENSORS
from tfra.model.design import Architecture, Design
from tfra.model.sparse import Filter

PAPER = SENSORS["10×10, 4×2 mm, h 3 mm"]


@pytest.mark.parametrize("name", SENSORS)
def test_depth_is_that_of_the_images(name):
    design = make_design(SENSORS[name])
    assert depth(design) == lane_images(design).shape[1]


@pytest.mark.parametrize(
    ("lanes", "pinv", "gram", "chosen"),
    [
        (16, 2, 2, "pinv"),  # 1,325 or 1,025 words: no block saved, so time decides
        (20, 2, 1, "gram"),  # 1,050 or 800 words
        (32, 1, 1, "pinv"),
    ],
)
def test_gram_is_chosen_where_it_saves_blocks(lanes, pinv, gram, chosen):
    design = Design(PAPER, architecture=Architecture(lanes))
    assert blocks(design) == lanes * pinv
    assert blocks(replace(design, operators="gram")) == lanes * gram
    assert economical(design).operators == chosen
    assert economical(economical(design)) == economical(design)
    assert economical(replace(design, operators="gram")).operators == chosen
    assert (pinv - 1) * BLOCK < depth(design) <= pinv * BLOCK


def test_sparse_operators_stay_as_they_are():
    design = Design(PAPER, architecture=Architecture(20), sparse=Filter("F2", 1))
    assert economical(design) is design
