"""Lines on standard error."""

import sys
from contextlib import suppress


def print_error(message: str) -> None:
    """Print a line on standard error; do nothing if its reader is gone."""
    with suppress(OSError):
        print(message, file=sys.stderr, flush=True)
