"""All libraries give the words of the bit-accurate model, and a wrong one would be noticed."""

from __future__ import annotations

import numpy as np
import pytest

from bench.speed import libraries
from tfra.model.cover.scenes import contact_codes
from tfra.model.fixed.tfra.stages import Stage


@pytest.mark.parametrize("library", [libraries.in_apytypes, libraries.in_fxpmath])
def test_words_are_the_models(library) -> None:
    operands = libraries.vectors(3)
    found, expected = libraries.products(library(), operands), libraries.in_model(operands)
    assert [words.shape for words in found] == [words.shape for words in expected]
    assert all((a == b).all() for a, b in zip(found, expected, strict=True))


def test_a_wrong_word_ends_it(monkeypatch: pytest.MonkeyPatch) -> None:
    right = libraries.in_apytypes()
    monkeypatch.setattr(libraries, "in_apytypes", lambda: lambda *arguments: right(*arguments) + 1)
    monkeypatch.setattr(libraries, "FRAMES", dict.fromkeys(libraries.FRAMES, 1))
    monkeypatch.setattr(libraries, "store", lambda *_: None)
    monkeypatch.setattr(libraries, "insert", lambda *_: None)
    with pytest.raises(AssertionError, match="apytypes"):
        libraries.main()


def test_operands_are_those_of_the_frames() -> None:
    """What the stage of products sent, product by product."""
    design = libraries.DESIGN
    sent = design.model(contact_codes(design, 4, seed=1)).stages[Stage.MATVEC]
    assert (np.concatenate(libraries.in_model(libraries.vectors(4)), axis=1) == sent).all()
