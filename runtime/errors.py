"""The exception for every mistake of a user, and for missing packages; the warning."""

import reprlib
from importlib.util import find_spec
from pathlib import Path

LONGEST_FILE, LONGEST_KEY, LONGEST_REASON = 1000, 60, 230
"""Most characters of the parts of a line; a longer part is cut, and its length stated."""

LONGEST_VALUE = 60
"""Most characters of a value that a reason quotes."""

_MODULES = {"pyserial": "serial", "systemrdl-compiler": "systemrdl"}
"""Modules whose names differ from those of their packages by more than hyphens."""


class InputError(ValueError):
    """Bad input, stated in one line: ``file: key: reason``, or ``file: reason`` without a key.

    Characters that would break the line (a file name may hold any) are shown escaped, long parts shortened.
    """

    def __init__(self, file: str | Path, key: str, reason: str) -> None:
        parts = shortened(str(file), LONGEST_FILE), shortened(key, LONGEST_KEY), shortened(reason, LONGEST_REASON)
        super().__init__(": ".join(part for part in parts if part))

    def __reduce__(self) -> "tuple[type[InputError], tuple[str, str, str]]":
        """Pickles as its line, to pass between processes."""
        return InputError, (str(self), "", "")


class Notice(UserWarning):
    """A warning to the user in one line; the work continues."""


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


def require(where: str | Path, extra: str, *packages: str) -> None:
    """Raise ``InputError`` about ``where`` for the first of ``packages`` that is missing; ``extra`` installs it."""
    for package in packages:
        if find_spec(_MODULES.get(package, package.replace("-", "_"))) is None:
            raise InputError(where, "", f"{package} is missing, please run: pip install 'tfra[{extra}]'")
