"""The front end's model against plain integers and fractions, taxel by taxel and frame by frame."""

from dataclasses import replace
from fractions import Fraction
from math import floor

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tfra.model.choices import Adc, Architecture
from tfra.model.fixed.design import Design
from tfra.model.fixed.front_end import FrontEnd, Settings, Tables, repair_places
from tfra.model.fixed.repair import HEADER, ONE, PLACE
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.sensor import SensorArray

M = 4


def make(bits: int = 14, rows: int = 2, columns: int = 2) -> Design:
    return TfraDesign(SensorArray(rows, columns, 4e-3, 2e-3, 3e-3), adc=Adc(bits), architecture=Architecture(4))


def limited(value: Fraction, bits: int) -> int:
    """Half up, within a word of ``bits``."""
    return max(-(1 << (bits - 1)), min((1 << (bits - 1)) - 1, floor(value + Fraction(1, 2))))


class Oracle:
    """The text of docs/front_end.md, a taxel at a time, in exact fractions of the converter's range."""

    def __init__(self, bits: int, chosen: Settings, tables: Tables) -> None:
        self.bits, self.chosen = bits, chosen
        self.offsets, self.gains = tables.offsets.tolist(), tables.gains.tolist()
        self.repairs = tables.repairs.tolist()
        self.mean: list[list[Fraction]] = []
        self.flags: list[set[str]] = []
        self.history: list[list[int]] = []
        self.user: int | None = None
        self.taring = False

    def tare(self) -> None:
        self.taring, self.mean, self.flags = True, [], []

    def frame(self, words: list[int], user: int, whole: bool) -> tuple[list[int], set[str]] | None:
        flags = set()
        if self.chosen.check_sequence:
            flags |= {"sequence_gap"} if self.user is not None and user != (self.user + 1) % 65536 else set()
            self.user = user
        if not whole:
            return None
        self.history.append(words)
        values = []
        for taxel, word in enumerate(words):
            value, faults = self.value(taxel, word)
            values.append(value)
            flags |= faults if self.gains[taxel] else set()
        self.mean.append(values)
        self.flags.append(flags)
        log2 = self.chosen.log2_tare if self.taring else self.chosen.log2_average
        if len(self.mean) < 2**log2:
            return None
        fine = [limited(sum(column) / len(self.mean) * 2**17, 19) for column in zip(*self.mean, strict=True)]
        flags = set().union(*self.flags)
        self.mean, self.flags = [], []
        if self.taring:
            self.taring, self.offsets = False, fine
            return None
        return self.cleaned(fine), flags

    def value(self, taxel: int, word: int) -> tuple[Fraction, set[str]]:
        bits, faults = self.chosen.word_bits, set()
        number = word % 2**bits
        if not self.chosen.is_unsigned and number >= 2 ** (bits - 1):
            number -= 2**bits
        lowest = 0 if self.chosen.is_unsigned else -(2 ** (bits - 1))
        faults |= {"saturation"} if number in (lowest, lowest + 2**bits - 1) else set()
        faults |= {"out_of_range"} if number % 65536 != word else set()
        last = [frame[taxel] for frame in self.history[-self.chosen.stuck_frames :]]
        if self.chosen.stuck_frames and len(last) == self.chosen.stuck_frames and len(set(last)) == 1:
            faults.add("stuck")
        return Fraction(number, 2**bits), faults

    def cleaned(self, fine: list[int]) -> list[int]:
        codes = []
        for mean, offset, gain in zip(fine, self.offsets, self.gains, strict=True):
            change = limited(Fraction(mean - offset), 18) * (-1 if self.chosen.invert else 1)
            codes.append(limited(Fraction(change * gain, 2 ** (32 - self.bits)), self.bits))
        written = [abs(code) for code in codes]
        target, total = None, Fraction(0)
        for word in [*self.repairs, HEADER]:
            if word & HEADER:
                if target is not None:
                    codes[target] = limited(total, self.bits)
                    written.append(abs(codes[target]))
                target, total = word >> PLACE & 0x1FFF, Fraction(0)
            else:
                weight = word % 2**18 - (2**18 if word & 2**17 else 0)
                total += Fraction(weight, 65536) * codes[word >> PLACE]
        silent = max(written) < self.chosen.contact
        return [0 if silent or abs(code) < self.chosen.dead_band else code for code in codes]


chosen_settings = st.builds(
    Settings,
    word_bits=st.integers(8, 16),
    is_unsigned=st.booleans(),
    invert=st.booleans(),
    log2_average=st.integers(0, 2),
    log2_tare=st.integers(0, 2),
    dead_band=st.sampled_from([0, 1, 20, 65535]),
    contact=st.sampled_from([0, 1, 300, 65535]),
    stuck_frames=st.integers(0, 4),
    check_sequence=st.booleans(),
)
entries = st.one_of(
    st.integers(0, M - 1).map(lambda taxel: HEADER | taxel << PLACE),
    st.tuples(st.integers(0, M - 1), st.integers(0, 2**18 - 1)).map(lambda two: two[0] << PLACE | two[1]),
)
chosen_tables = st.builds(
    lambda offsets, gains, repairs: Tables(*(np.array(each, dtype=np.int64) for each in (offsets, gains, repairs))),
    st.lists(st.one_of(st.integers(-100, 100), st.integers(-(2**17), 2**17 - 1)), min_size=M, max_size=M),
    st.lists(st.one_of(st.sampled_from([0, 1 << 15]), st.integers(0, 2**17 - 1)), min_size=M, max_size=M),
    st.lists(entries, max_size=8),
)
word = st.one_of(st.integers(0, 65535), st.sampled_from([0, 127, 128, 255, 32767, 32768, 65535]))
chosen_words = st.lists(word, min_size=M, max_size=M)
chosen_frames = st.lists(
    st.tuples(chosen_words, st.integers(0, 3), st.booleans(), st.sampled_from(["", "", "", "tare", "call"])),
    max_size=20,
)


def outcome(design: Design, chosen: Settings, tables: Tables, frames) -> tuple[list, list]:
    """Codes and flags of the model, in calls of several frames, and of the oracle."""
    unit, oracle = FrontEnd(design, chosen, tables), Oracle(design.adc.bits, chosen, tables)
    found, expected, users, block = [], [], 0, []

    def call() -> None:
        seen = unit(
            np.array([words for words, _, _ in block], dtype=np.int64).reshape(-1, 2, 2),
            [user for _, user, _ in block],
            np.array([whole for _, _, whole in block], dtype=bool),
        )
        for number, codes in enumerate(seen.codes):
            found.append((codes.ravel().tolist(), {name for name, flag in seen.flags.items() if flag[number]}))
        block.clear()

    for words, step, whole, what in frames:
        if what:
            call()
        if what == "tare":
            unit.tare()
            oracle.tare()
        users = (users + step) % 65536
        block.append((words, users, whole))
        result = oracle.frame(words, users, whole)
        expected += [] if result is None else [result]
    call()
    return found, expected


@given(st.sampled_from([8, 11, 14, 16]), chosen_settings, chosen_tables, chosen_frames)
@settings(max_examples=80, deadline=None)
def test_the_model_is_the_exact_arithmetic(bits, chosen, tables, frames):
    found, expected = outcome(make(bits), chosen, tables, frames)
    assert found == expected


def one(words: list[int], bits: int = 14, tables: Tables | None = None, **chosen) -> list[int]:
    unit = FrontEnd(make(bits), Settings(**({"word_bits": bits} | chosen)), tables)
    return unit(np.array(words).reshape(1, 2, 2)).codes.ravel().tolist()


def test_literal_values():
    """16 bits to 8 and back, unsigned words with an offset of half the range, the ends of gain and of deviation."""
    assert one([0x7FFF, 0x8000, 0x0080, 0xFF7F], 8, word_bits=16) == [127, -128, 1, -1]
    assert one([0x7F, 0x80, 1, 0xFF], 16, word_bits=8) == [127 << 8, -128 << 8, 1 << 8, -1 << 8]
    assert one([0, 0x1FFF, 0xE000, 0xFFFF]) == [0, 8191, -8192, -1]
    half = Tables(np.full(4, 1 << 16), np.full(4, 1 << 15), np.zeros(0, np.int64))
    assert one([0, 0x3FFF, 0x2000, 1], 14, half, is_unsigned=True) == [-8192, 8191, 0, -8191]
    largest = Tables(np.array([-(1 << 17), (1 << 17) - 1, 0, 0]), np.full(4, (1 << 17) - 1), np.zeros(0, np.int64))
    assert one([0x1FFF, 0x2000, 1, 0xFFFF], 14, largest) == [8191, -8192, 4, -4]
    assert one([0x1FFF, 0x2000, 1, 0xFFFF], 14, largest, invert=True) == [-8192, 8191, -4, 4]


def test_thresholds_at_their_edges():
    words = [5, -5 & 0xFFFF, 4, -6 & 0xFFFF]
    assert one(words, dead_band=5) == [5, -5, 0, -6]
    assert one(words, contact=6) == [5, -5, 4, -6]
    assert one(words, contact=7) == [0, 0, 0, 0]


def test_repairs_see_earlier_repairs():
    table = [HEADER, 1 << PLACE | ONE, HEADER | 1 << PLACE, ONE, 2 << PLACE | ONE >> 1, HEADER | 3 << PLACE]
    tables = replace(Tables.of(4), repairs=np.array(table))
    assert one([1, 20, 301, 9], tables=tables) == [20, 171, 301, 0]  # 20 + 150.5, half up; no source


@pytest.mark.parametrize(
    ("name", "value"),
    [
        *(("word_bits", 7), ("word_bits", 17), ("log2_average", 7), ("log2_tare", -1)),
        *(("dead_band", 65536), ("contact", -1), ("stuck_frames", 256)),
    ],
)
def test_settings_outside_their_range_are_refused(name, value):
    with pytest.raises(ValueError, match=rf"^{name}: \d+ to \d+ is supported, got {value}$"):
        Settings(**({"word_bits": 14} | {name: value}))


@pytest.mark.parametrize(
    ("name", "value"), [("offsets", 1 << 17), ("offsets", -(1 << 17) - 1), ("gains", -1), ("gains", 1 << 17)]
)
def test_numbers_that_a_table_cannot_hold_are_refused(name, value):
    words = np.array([0, 0, value, 0])
    with pytest.raises(ValueError, match=rf"^{name}: -?\d+ to \d+ is supported, taxel 2 has {value}$"):
        replace(Tables.of(4), **{name: words})


def test_a_table_of_repairs_that_is_too_long_is_refused():
    with pytest.raises(ValueError, match=r"^repairs: the table has 512 places, got 513 words$"):
        replace(Tables.of(4), repairs=np.full(513, HEADER))
    assert [repair_places(taxels) for taxels in (4, 390, 400, 1024)] == [512, 512, 1024, 2048]
