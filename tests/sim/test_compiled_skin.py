"""Skins in C against the model: every record, by any number of threads, for any codes and any settings."""

import ctypes
import os
from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from tests.codegen.c.skins import SKINS, frames, skin
from tests.marks import long
from tfra.codegen.c.skin import skin_core, skin_ram_bytes
from tfra.model.arrays import Ints
from tfra.model.skin.finding import Finding
from tfra.model.skin.records import header_bits, records
from tfra.model.skin.skin import Skin
from tfra.runtime.errors import InputError
from tfra.sim import compiled, compiled_skin
from tfra.sim.compiled import built, loaded
from tfra.sim.compiled_skin import CompiledSkin

HUNDRED_THOUSAND = {
    "12x20": (SKINS["12x20"], 90_000),
    "32x32": (skin("learned_4x6", 32, 32, Finding(gap=1)), 4_000),
    "64x64": (skin("learned_4x6", 64, 64), 1_500),
    "127x65": (skin("learned_3x5", 127, 65, Finding(most=64, threshold=0.02)), 200),
}
"""Skins, and how many of their frames are compared."""


@cache
def called(case: str) -> CompiledSkin:
    """The C of one of ``SKINS``."""
    return CompiledSkin(SKINS[case])


def modelled(skin: Skin, codes: Ints) -> Ints:
    return records(skin, codes, lambda cut: skin.window.model(cut).words)


@pytest.mark.parametrize("case", ["12x20", *long(*(case for case in SKINS if case != "12x20"))])
def test_records(case: str) -> None:
    codes = frames(SKINS[case], 1000)
    np.testing.assert_array_equal(called(case).words(codes), modelled(SKINS[case], codes))


def test_frames_have_all_that_is_special() -> None:
    """Every mark, alone and together; frames without contact, with one, and with more peaks than there may be."""
    skin = SKINS["12x20"]
    found, _ = skin.find(frames(skin, 1000))
    assert set(found.marks.tolist()) == {256 * marks for marks in range(8)}
    assert set(found.found.tolist()) == set(range(skin.choices.most + 1))
    assert (found.dropped > 0).any()
    assert found.taxels.max() == skin.sensor.taxels


@pytest.mark.long
@pytest.mark.parametrize("case", HUNDRED_THOUSAND)
def test_records_of_a_hundred_thousand_frames(case: str) -> None:
    skin, count = HUNDRED_THOUSAND[case]
    unit = CompiledSkin(skin)
    compared = 0
    for seed in range(100):
        codes = frames(skin, count // 100, seed)
        compared += len(codes)
        np.testing.assert_array_equal(unit.words(codes), modelled(skin, codes), f"seed {seed}")
    assert compared >= count


CODES = st.sampled_from((-32, -16, -8, -4, -2, -1, 0, 0, 0, 0, 3, 31))

SHIM = """\
#include "tfra_skin.h"

int run(tfra_skin *skin, int most, int threshold, int gap, const tfra_code *codes, int *words)
{
    static tfra_contact contacts[TFRA_SKIN_MOST];
    tfra_skin_init(skin);
    skin->settings.most = (uint16_t)most;
    skin->settings.threshold = (uint16_t)threshold;
    skin->settings.gap = (uint16_t)gap;
    const int found = tfra_skin_step(skin, codes, contacts);
    *words++ = skin->dropped;
    for (int i = 0; i < found; i++) {
        *words++ = contacts[i].row;
        *words++ = contacts[i].column;
        *words++ = contacts[i].taxels;
        *words++ = contacts[i].top;
        *words++ = contacts[i].left;
        *words++ = contacts[i].marks << 8;
    }
    return found;
}
"""
SMALL = skin("2x2", 7, 9)


@cache
def finder() -> Callable[[int, int, int, Ints], list[int]]:
    """A function of settings and a frame of ``SMALL``: peaks that are left, then what each contact is."""
    run = loaded(built("shim", skin_core(SMALL) | {"calls.c": SHIM})).run
    state = ctypes.create_string_buffer(skin_ram_bytes(SMALL))

    def found(most: int, threshold: int, gap: int, codes: Ints) -> list[int]:
        words = np.zeros(1 + 6 * 64, dtype=np.int32)
        given = np.ascontiguousarray(codes, dtype=np.int16)
        count = run(state, most, threshold, gap, ctypes.c_void_p(given.ctypes.data), ctypes.c_void_p(words.ctypes.data))
        return words[: 1 + 6 * count].tolist()

    return found


def of_model(most: int, threshold: int, gap: int, codes: Ints) -> list[int]:
    found, _ = replace(SMALL, choices=Finding(most, threshold / 256, gap)).find(codes[None])
    each = np.stack([found.row, found.column, found.taxels, found.top, found.left, found.marks], axis=1)
    return [int(found.dropped[0]), *each.ravel().tolist()]


@settings(deadline=None)
@given(
    codes=arrays(np.int64, (SMALL.sensor.rows, SMALL.sensor.columns), elements=CODES),
    most=st.integers(1, 5),
    threshold=st.integers(1, 256),
    gap=st.integers(0, 4),
)
def test_contacts_with_any_settings(codes: Ints, most: int, threshold: int, gap: int) -> None:
    assert finder()(most, threshold, gap, codes) == of_model(most, threshold, gap, codes)


def test_settings_and_codes_are_limited() -> None:
    codes = frames(SMALL, 60)[13:]
    for frame in codes:
        assert finder()(0, 0, 0, frame) == of_model(1, 1, 0, frame)
        assert finder()(65535, 65535, 65535, 9 * frame) == of_model(64, 256, 4, np.clip(9 * frame, -32, 31))


def test_any_number_of_threads(monkeypatch: pytest.MonkeyPatch) -> None:
    unit, codes = called("narrow"), frames(SKINS["narrow"], 600)
    words = modelled(SKINS["narrow"], codes)
    for processors in (1, 5):
        monkeypatch.setattr(os, "sched_getaffinity", lambda _, few=processors: range(few))
        np.testing.assert_array_equal(unit.words(codes), words)
    assert unit.words(codes[:0]).shape == (0, words.shape[1])
    np.testing.assert_array_equal(unit.words(codes[5:6, ::-1]), modelled(SKINS["narrow"], codes[5:6, ::-1]))


def test_frames_and_windows_count_modulo_65536() -> None:
    words = called("narrow").words(np.zeros((65540, 3, 17), dtype=np.int64))
    assert words[-1, 0] == words[-1, len(header_bits(SKINS["narrow"]))] == 3


@pytest.mark.parametrize(
    ("right", "wrong"), [*long(("#define THRESHOLD 10", "#define THRESHOLD 11")), ("+ 2 * line[", "+ 3 * line[")]
)
def test_another_constant_is_noticed(right: str, wrong: str, monkeypatch: pytest.MonkeyPatch) -> None:
    skin = SKINS["12x20"]
    texts = skin_core(skin)
    name = f"{skin.window.name}_skin.c"
    corrupted = {**texts, name: texts[name].replace(right, wrong)}
    monkeypatch.setattr(compiled_skin, "skin_core", lambda _: corrupted)
    codes = frames(skin, 300)
    assert not np.array_equal(CompiledSkin(skin).words(codes), modelled(skin, codes))


def test_without_a_compiler(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compiled, "COMPILER", "no-such-gcc")
    with pytest.raises(InputError, match=r"^no-such-gcc: the engine c needs a C compiler: apt-get install gcc$"):
        CompiledSkin(SKINS["smallest"])
