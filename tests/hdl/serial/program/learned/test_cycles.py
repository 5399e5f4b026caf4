"""The cycles of docs/serial.md are those of the program."""

import re
from collections import Counter
from dataclasses import replace
from itertools import islice
from pathlib import Path

import numpy as np
import pytest

from tests.hdl.serial.designs import LEARNED_TEN
from tfra.hdl.cores import as_serial, program
from tfra.hdl.serial.trace import trace

DOCS = Path(__file__).parents[5] / "docs"
PAGE = (DOCS / "serial.md").read_text(encoding="utf-8").split("## The learned estimator")[1]

PHASES = {
    "taxels in": ("normaliser.codes",),
    "normalise, fold": ("normaliser.normaliser", "normaliser.fold"),
    "first layer": ("layers.first",),
    "second layer": ("layers.second",),
    "read-out": ("layers.read", "layers.total"),
    "resultant, plausibility, φ, μ": (
        "resultant.resultant", "resultant.plausible", "friction.angle", "friction.friction",
    ),
    "header, status": ("words.header", "words.resultant_words", "words.status"),
    "field": ("field.shear", "field.unfold"),
    "shares, three planes": ("share.share", "share.forces"),
}  # fmt: skip
"""The stages of each row."""


def rows():
    """Numbers of each row of the table, by its name: cycles without and with forces, and of products."""
    found = re.findall(r"^\| \**(.+?)\** \| \**([\d,]*)\** \| \**([\d,]+)\** \| ([\d,]*) \|$", PAGE, re.MULTILINE)
    return {name: [int(each.replace(",", "") or 0) for each in numbers] for name, *numbers in found}


def cycles(taxel_forces):
    """Cycles of a frame, and of these the ones of products, by stage."""
    design = replace(LEARNED_TEN, taxel_forces=taxel_forces)
    seen, products = Counter(), Counter()
    steps = trace(as_serial(design), np.zeros((1, 10, 10), dtype=np.int64))
    for traced in islice(steps, 1, program(design).interval + 1):  # after the one that follows a reset
        stage, _, routine = traced.stage.partition(", ")
        seen[stage] += 1
        products[stage] += routine.startswith("matvec.parities")
    return seen, products


@pytest.mark.parametrize("taxel_forces", [False, True])
def test_every_phase(taxel_forces):
    seen, products = cycles(taxel_forces)
    told = rows()
    assert list(told) == [*PHASES, "whole frame"]
    if taxel_forces:
        assert sorted(seen) == sorted(stage for stages in PHASES.values() for stage in stages)
    for phase, stages in PHASES.items():
        assert told[phase][taxel_forces] == sum(seen[stage] for stage in stages), phase
        if taxel_forces:
            assert told[phase][2] == sum(products[stage] for stage in stages), phase


def test_the_frame():
    designs = LEARNED_TEN, replace(LEARNED_TEN, taxel_forces=True)
    assert rows()["whole frame"][:2] == [program(design).interval for design in designs]
    (latency,) = re.findall(r"first word is ([\d,]+) cycles", PAGE)
    assert int(latency.replace(",", "")) == as_serial(LEARNED_TEN).latency
    (instructions, words, store) = re.findall(r"([\d,]+) instructions, ([\d,]+) words of data and ([\d,]+)", PAGE)[0]
    assert int(instructions) == len(program(LEARNED_TEN).instructions)
    assert int(words) == len(program(LEARNED_TEN).memory)
    assert int(store.replace(",", "")) == len(as_serial(LEARNED_TEN).coefficients)
