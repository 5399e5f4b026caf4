"""The one exception for everything a user can get wrong, and the one warning."""

from __future__ import annotations

import reprlib
from pathlib import Path

LONGEST_FILE, LONGEST_KEY, LONGEST_REASON = 1000, 60, 230
"""Characters of the parts of a line; what is longer is cut, and its length told."""

LONGEST_VALUE = 60
"""Characters of a value that a reason repeats."""


class InputError(ValueError):
    """Bad input, told in one line: ``file: key: reason``, or ``file: reason`` without a key.

    Characters that would break the line (a file name may hold any) are shown escaped, long parts shortened.
    """

    def __init__(self, file: str | Path, key: str, reason: str) -> None:
        parts = shortened(str(file), LONGEST_FILE), shortened(key, LONGEST_KEY), shortened(reason, LONGEST_REASON)
        super().__init__(": ".join(part for part in parts if part))

    def __reduce__(self) -> tuple[type[InputError], tuple[str, str, str]]:
        """It travels between processes as the line that it is."""
        return InputError, (str(self), "", "")


class Notice(UserWarning):
    """Something that the user should know, in one line, while the work goes on."""


def shortened(text: str, most: int = LONGEST_VALUE) -> str:
    """Return ``text`` on one line of at most ``most`` characters; one that was cut ends in its length."""
    shown = "".join(c if c.isprintable() else ascii(c)[1:-1] for c in text[: most + 1])
    if len(shown) <= most:
        return shown
    length = f"… ({len(text):,} characters)"
    return shown[: most - len(length)] + length


def quoted(value: object) -> str:
    """Return ``repr(value)``, shortened, whatever the value is."""
    if isinstance(value, str):
        return shortened(repr(value))
    try:
        return shortened(reprlib.repr(value))
    except ValueError:  # more digits than Python converts
        return "a number of thousands of digits"
