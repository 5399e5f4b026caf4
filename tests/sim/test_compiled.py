"""The engine ``c``: the words of the bit-accurate model, by any number of threads, for any codes."""

import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.codegen.c.cases import SMALL, frames
from tests.hdl.parallel.designs import make
from tests.marks import long
from tfra.codegen.c.shaped import shaped
from tfra.codegen.config.read import load
from tfra.model.choices import Adc, Formats
from tfra.model.fixed.design import Design
from tfra.runtime.errors import InputError
from tfra.sim import compiled
from tfra.sim.compiled import Compiled, Shaped, quickest

EXAMPLES = Path(__file__).parents[2] / "examples"


def example(name: str) -> Design:
    return load(EXAMPLES / f"{name}.toml").design


@pytest.mark.parametrize("case", ["3x5", *long(*(case for case in SMALL if case != "3x5"))])
def test_words(case: str) -> None:
    design = SMALL[case]
    codes = frames(design, 3000)
    np.testing.assert_array_equal(Compiled(design).words(codes), design.model(codes).words)


@pytest.mark.long
@pytest.mark.parametrize(
    "design",
    [
        pytest.param(make(2, 3, Formats("short", 8, 10, 4, 2), bits=8), id="2x3, 8 bits"),
        pytest.param(make(9, 7, Formats("24 bits", 24, 24, 8, 4), bits=16), id="9x7, 24 bits"),
        pytest.param(example("hertz_40x20"), id="hertz_40x20"),
        pytest.param(replace(example("learned_fast"), adc=Adc(12, 2e5)), id="learned 10x10"),
    ],
)
def test_words_of_a_hundred_thousand_frames(design: Design) -> None:
    called = Compiled(design)
    for seed in range(50):
        codes = frames(design, 2000, seed)
        np.testing.assert_array_equal(called.words(codes), design.model(codes).words, f"seed {seed}")


@pytest.mark.parametrize("case", ["5x4", "learned_4x6", *long("2x2", "3x5", "4x4", "learned_3x5")])
def test_words_of_a_shape(case: str) -> None:
    """What is built for one design gives the words of others, whose word lengths differ."""
    design = SMALL[case]
    codes = frames(design, 1000)
    one = Shaped(design)
    np.testing.assert_array_equal(one.words(codes), design.model(codes).words)
    shorter = replace(design, formats=replace(design.formats, coefficient=design.formats.coefficient - 1))
    assert shaped(shorter) == shaped(design)
    other = Shaped(shorter)
    np.testing.assert_array_equal(other.words(codes), shorter.model(codes).words)
    np.testing.assert_array_equal(one.words(codes), design.model(codes).words)


def test_any_number_of_threads(monkeypatch: pytest.MonkeyPatch) -> None:
    called, codes = Compiled(SMALL["3x5"]), frames(SMALL["3x5"], 2000)
    words = called.words(codes)
    for processors in (1, 5):
        monkeypatch.setattr(os, "sched_getaffinity", lambda _, few=processors: range(few))
        np.testing.assert_array_equal(called.words(codes), words)
    assert called.words(codes[:0]).shape == (0, SMALL["3x5"].frame_words)
    np.testing.assert_array_equal(called.words(codes[5:6, ::-1]), SMALL["3x5"].model(codes[5:6, ::-1]).words)


@pytest.mark.parametrize("case", ["3x5", *long("learned_3x5")])
def test_another_coefficient_is_noticed(case: str, monkeypatch: pytest.MonkeyPatch) -> None:
    design, codes = SMALL[case], frames(SMALL[case], 300)
    core = compiled.core

    def corrupted(*given):
        texts = core(*given)
        name = f"{design.name}_tables.c"
        head, last = texts[name].rsplit("= {\n    ", 1)
        number, rest = last.split(",", 1)
        return {**texts, name: f"{head}= {{\n    {int(number) ^ 64},{rest}"}

    monkeypatch.setattr(compiled, "core", corrupted)
    assert (Compiled(design).words(codes) != design.model(codes).words).any()


def test_without_a_compiler(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compiled, "COMPILER", "no-such-gcc")
    codes = frames(SMALL["2x2"], 30)
    np.testing.assert_array_equal(quickest(SMALL["2x2"])(codes), SMALL["2x2"].model(codes).words)
    with pytest.raises(InputError, match=r"^no-such-gcc: the engine c needs a C compiler: apt-get install gcc$"):
        Compiled(SMALL["2x2"])
