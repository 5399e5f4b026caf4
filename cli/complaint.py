"""A line for who reads standard error."""

from __future__ import annotations

import sys
from contextlib import suppress


def say(message: str) -> None:
    """Print a line on standard error, if somebody is left to be told."""
    with suppress(OSError):
        print(message, file=sys.stderr, flush=True)
