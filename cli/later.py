"""Commands that are part of the contract but not written yet."""

from __future__ import annotations

from tfra.model.errors import InputError

SETTINGS = {"allow_extra_args": True, "ignore_unknown_options": True}
"""Any arguments will do: the answer is the same."""


def study() -> None:
    """Study the errors of word lengths (not available yet)."""
    raise InputError("tfra study", "", "not available yet")
