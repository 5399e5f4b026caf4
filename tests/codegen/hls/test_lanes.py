"""Lanes of HLS cores: each operator's divide its rows, all are as many as the architecture has at most."""

from dataclasses import replace

import pytest

from tests.codegen.c.cases import SMALL
from tfra.codegen.config.read import load
from tfra.codegen.hls.lanes import lane_constants, lanes
from tfra.model.choices import SERIAL
from tfra.model.fixed.design import Design


def slowest(design: Design) -> float:
    """Cycles of the products of the slowest stack."""
    found = lanes(design)
    return max(sum(op.rows.size / found[op.name] for op in stack.operators) for stack in design.stacks.values())


@pytest.mark.parametrize("name", ["fast", "learned_fast", "learned_resultant"])
def test_shares(name: str) -> None:
    design = load(f"examples/{name}.toml").design
    found, constants = lanes(design), lane_constants(design)
    assert sum(found.values()) <= design.architecture.mac_lanes
    for stack in design.stacks.values():
        for op in stack.operators:
            assert found[op.name] * constants[f"REUSE_{op.name.upper()}"] == stack.operand_quads
    more = replace(design, architecture=replace(design.architecture, mac_lanes=4 * design.quads))
    assert slowest(more) < slowest(design)
    assert max(lanes(replace(design, architecture=SERIAL)).values()) == 1


def test_one_each_at_least() -> None:
    assert set(lanes(replace(SMALL["3x5"], architecture=SERIAL)).values()) == {1}
