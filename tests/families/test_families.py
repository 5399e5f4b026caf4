"""Facts of all families, against each other and against the gateware."""

import re

import pytest

from tfra.families import FAMILIES, TARGETS, Family, find, part_names, targets_of
from tfra.hdl.primitives import cell_models
from tfra.hdl.primitives.gateware import GATEWARE
from tfra.model.choices import TARGETS as DESIGN_TARGETS


def test_targets() -> None:
    assert find("ecp5-45") is find("ecp5-45-6")
    assert find("ecp5-45-8").speed == ("--speed", "8")
    assert find("ecp5-85").available["DSP"] == 156
    for name in ("ecp5", "ecp5-12", "ecp5-45-9", ""):
        with pytest.raises(ValueError, match=r"one of ecp5-25-6, .*ice40up5k.* is needed"):
            find(name)
    grades = "ecp5-25, ecp5-45, ecp5-85 (suffix -6, -7 or -8: speed grade)"
    assert part_names() == f"{grades}, ice40up5k, gw2a-18, xc7, gatemate-a1"


@pytest.mark.parametrize("name", TARGETS)
def test_resources_of_a_target_are_those_of_its_family(name: str) -> None:
    target = find(name)
    assert target.available.keys() <= target.family.cells.keys()
    assert re.fullmatch(rf"{target.part}(-{target.grade})?", target.name)


@pytest.mark.parametrize("family", FAMILIES.values(), ids=FAMILIES)
def test_a_family_is_complete(family: Family) -> None:
    assert targets_of(family)
    assert "{top}" in family.synthesis
    assert (family.multiplier is None) == (family.product_luts is not None) == ("DSP" not in family.cells)
    if tool := family.place_and_route:
        assert tool.bels.keys() <= family.cells.keys()
    else:
        assert family.timing


def test_the_gateware_has_the_cells_that_families_state() -> None:
    assert tuple(GATEWARE) == DESIGN_TARGETS
    for name, gateware in GATEWARE.items():
        stated = set(FAMILIES[name].gateware) if name in FAMILIES else set()
        assert {primitive for primitive, made in vars(gateware).items() if made} == stated
        assert all(file.exists() for file in cell_models(name, *stated))


def test_words_of_block_memories() -> None:
    depths = {
        "ecp5": {36: 512, 18: 1024, 9: 2048, 4: 4096, 2: 8192, 1: 16384},
        "ice40": {16: 256, 8: 512, 4: 1024, 2: 2048},
        "xilinx": {72: 512, 36: 1024, 18: 2048, 9: 4096, 4: 8192, 2: 16384, 1: 32768},
        "gatemate": {40: 512, 20: 1024, 10: 2048, 5: 4096, 2: 8192, 1: 16384},
    }
    for name, expected in depths.items():
        memory = FAMILIES[name].memory
        assert {width: memory.depth(width) for width in memory.widths} == expected


@pytest.mark.parametrize(
    ("widths", "luts"), [((8, 8), 107), ((18, 18), 312), ((34, 18), 488), ((35, 35), 933), ((9, 13), 168)]
)
def test_multipliers_of_logic(widths: tuple[int, int], luts: int) -> None:
    """As many half CPEs as nextpnr 0.11.1 takes."""
    product = FAMILIES["gatemate"].product_luts
    assert product
    assert product(*widths) == pytest.approx(luts, rel=0.02)
