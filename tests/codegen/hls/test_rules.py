"""HLS tools' rules: the cores keep them, and each rule can be broken."""

from functools import cache

import pytest

from tests.codegen.c.cases import SMALL
from tests.codegen.hls.rules import broken
from tfra.codegen.blocks.constants import constants
from tfra.codegen.config.read import load
from tfra.codegen.hls.files import files
from tfra.codegen.hls.lanes import lane_constants
from tfra.model.fixed.design import Design


@cache
def firmware(design: Design) -> dict[str, str]:
    return {name: text for name, text in files(design).items() if name.startswith("firmware/")}


def values(design: Design) -> dict[str, int]:
    own = {"WORDS": design.frame_words} | lane_constants(design)
    return {name: n for section in constants(design).values() for name, n in section.items()} | own


@pytest.mark.parametrize("case", SMALL)
def test_cores_keep_them(case: str) -> None:
    design = SMALL[case]
    assert broken(firmware(design), design.name, values(design)) == []


@pytest.mark.parametrize(
    ("file", "old", "new", "complaint"),
    [
        ("blocks/numbers.h", "length += step;", "length += step * 1.0f + (double)x;", "floating point: double"),
        (
            "blocks/taxels.h",
            "const vector_t planes[4 * QUADS]",
            "const vector_t *planes[4]",
            "pointer to pointer: *planes[4],",
        ),
        ("blocks/taxels.h", "planes[4 * QUADS]", "**planes", "pointer to pointer: **"),
        ("blocks/taxels.h", "{\n", "{\n    int *more = new int[4];\n", "heap: new"),
        ("blocks/taxels.h", "{\n", "{\n    goto end;\n", "jump: goto"),
        ("blocks/taxels.h", "{\n", "{\n    throw 1;\n", "virtual: throw"),
        ("blocks/taxels.h", "static void", "void", "tops: ['NAME', 'to_taxels']"),
        ("blocks/taxels.h", "{\n", "{\n    to_taxels(planes, taxels);\n", "recursion: to_taxels"),
        (
            "blocks/taxels.h",
            "t < TAXELS",
            "t < planes[0]",
            "loop (int t = 0; t < planes[0]; t++): ",
        ),
        (
            "blocks/cordic.h",
            "for (int i = 0; i < CORDIC; i++)",
            "while (y != 0)",
            "loop (y != 0): ",
        ),
        ("blocks/taxels.h", "to_taxels(", "elsewhere(", "unused: elsewhere"),
        (
            "blocks/estimate.h",
            "contact(codes, &seen, stress,",
            "contact(codes, &seen, p,",
            "channel estimate.p: ['writes', 'writes', 'reads']",
        ),
        ("blocks/estimate.h", "e0, e1, c33, p, q)", "e0, kept_e1, c33, p, q)", "channel estimate.e1: ['writes']"),
    ],
)
def test_each_can_be_broken(file: str, old: str, new: str, complaint: str) -> None:
    design = SMALL["3x5"]
    texts = dict(firmware(design))
    text = texts[f"firmware/{file}"]
    assert old in text
    texts[f"firmware/{file}"] = text.replace(old, new, 1)
    found = broken(texts, design.name, values(design))
    assert any(one.startswith(complaint.replace("NAME", design.name)) for one in found), found


@pytest.mark.long
@pytest.mark.parametrize("name", ["fast", "balanced", "small", "learned_fast", "learned_resultant", "learned_small"])
def test_presets_keep_them(name: str) -> None:
    design = load(f"examples/{name}.toml").design
    assert broken(firmware(design), design.name, values(design)) == []
