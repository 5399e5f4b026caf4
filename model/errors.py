"""The one exception for everything a user can get wrong."""

from __future__ import annotations

from pathlib import Path


class InputError(ValueError):
    """Bad input, told in one line: ``file: key: reason``, or ``file: reason`` without a key.

    Characters that would break the line (a file name may hold any) are shown escaped.
    """

    def __init__(self, file: str | Path, key: str, reason: str) -> None:
        message = ": ".join(part for part in (str(file), key, reason) if part)
        super().__init__("".join(c if c.isprintable() else ascii(c)[1:-1] for c in message))
