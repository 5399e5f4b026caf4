"""The researcher's hour of docs/first_hour.md, replayed: every command, every answer, and the forces at its end."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from bench.contacts import recording
from bench.contacts.first_hour import BLOCK, PAGE, answer, executed

TEXT = PAGE.read_text(encoding="utf-8")


def test_the_page_shows_what_happens() -> None:
    assert executed(TEXT) == TEXT
    assert len(BLOCK.findall(TEXT)) == TEXT.count("\n$ ") <= 10


def test_another_answer_is_noticed() -> None:
    changed = TEXT.replace("median 25.4", "median 25.5")
    assert changed != TEXT
    assert executed(changed) == TEXT


def test_the_forces_are_those_of_the_contact(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """While the ball is dragged; TFRA's own errors are of this size."""
    monkeypatch.chdir(tmp_path)
    for found in BLOCK.finditer(TEXT):
        answer(found["command"])
    with np.load("forces.npz") as result:
        drag = slice(recording.REST + recording.PRESS + 20, recording.REST + recording.PRESS + recording.DRAG)
        np.testing.assert_allclose(result["phi_deg"][drag], recording.PHI_DEG, atol=5)
        np.testing.assert_allclose(result["mu"][drag], recording.MU, atol=0.12)
        np.testing.assert_allclose(result["resultant"][drag, 2], recording.FORCE, rtol=0.15)
    assert Path("page.html").stat().st_size > 1e6


def test_the_recording_is_the_one_in_the_examples() -> None:
    assert recording.PATH.read_text() == recording.text()
