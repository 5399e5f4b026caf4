"""Words as they come from a bus: signs are extended, and what no field can hold is refused."""

import numpy as np
import pytest

from tfra.model.arrays import Ints
from tfra.model.choices import Architecture
from tfra.model.cover.scenes import contact_codes
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.fixed.words import decode, received
from tfra.model.sensor import SensorArray

DESIGN = TfraDesign(SensorArray(3, 4, 4e-3, 2e-3, 3e-3), architecture=Architecture(4, 1))
WORDS = DESIGN.model(contact_codes(DESIGN, 12, 3)).words


@pytest.mark.parametrize("bits", [DESIGN.word_bits, 32])
@pytest.mark.parametrize("kind", [np.int64, np.uint64, np.uint32])
def test_raw_words_are_extended(bits: int, kind: type) -> None:
    words = WORDS.copy()
    raw = (words & ((1 << bits) - 1)).astype(kind)
    np.testing.assert_array_equal(received(DESIGN, raw), words)


def test_words_at_the_ends_of_a_field() -> None:
    words = WORDS.copy()[:1]
    at, bits = {f.name: f for f in DESIGN.layout}["mu"].start, {f.name: f for f in DESIGN.layout}["mu"].bits
    for value in (-(1 << (bits - 1)), (1 << (bits - 1)) - 1, -1):
        words[0, at] = value
        for raw in (value, value & ((1 << DESIGN.word_bits) - 1), value & 0xFFFFFFFF):
            given = words.copy()
            given[0, at] = raw
            assert received(DESIGN, given)[0, at] == value
    for value in (1 << (bits - 1), -(1 << (bits - 1)) - 1, (1 << bits) - 1, 1 << 32, -1 << 40):
        words[0, at] = value
        with pytest.raises(ValueError, match=r"words: frame 0: mu is from -\d+ to \d+, got"):
            received(DESIGN, words)


@pytest.mark.parametrize(
    "words", [np.zeros((2, DESIGN.frame_words - 1), np.int64), np.zeros(DESIGN.frame_words, np.int64),
              np.zeros((2, DESIGN.frame_words)), np.full((1, DESIGN.frame_words), 1 << 63, np.uint64)]
)  # fmt: skip
def test_other_words_are_refused(words: Ints) -> None:
    with pytest.raises(ValueError, match="words: "):
        received(DESIGN, words)


def test_a_field_without_a_sign_has_no_negative_words() -> None:
    words = WORDS.copy()[:1]
    words[0, 0] = -1
    with pytest.raises(ValueError, match="words: frame 0: frame is from 0 to 65535, got -1"):
        decode(DESIGN, words)
