"""Opening a user's file: regular files only, with one line for every failure."""

import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

from tfra.runtime.errors import InputError

_KINDS = (
    (stat.S_ISFIFO, "a pipe"),
    (stat.S_ISSOCK, "a socket"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
)


@contextmanager
def opened(file: Path) -> Iterator[BinaryIO]:
    """Open the regular ``file``; raises ``InputError`` when it is none, or when an ``OSError`` ends the block.

    A pipe could block for ever, and opening a device may have an effect, so neither is opened.
    """
    try:
        _require_regular(file, os.stat(file).st_mode)
        with open(file, "rb", opener=_without_waiting) as stream:
            _require_regular(file, os.fstat(stream.fileno()).st_mode)
            yield stream
    except OSError as error:
        raise InputError(file, "", f"cannot be read: {error.strerror or error}") from None
    except MemoryError as error:
        raise no_memory(file, error) from None


def no_memory(file: Path, error: MemoryError) -> InputError:
    """Return the error that ``file`` is too large for this machine; NumPy's ``error`` states the size."""
    return InputError(file, "", f"there is not enough memory for it{f': {error}' if str(error) else ''}")


def memory() -> int:
    """Bytes of memory that this machine has."""
    return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")


def _without_waiting(path: str, flags: int) -> int:
    """Check the open file again: it may have become a pipe since the first check."""
    return os.open(path, flags | os.O_NONBLOCK)


def _require_regular(file: Path, mode: int) -> None:
    kind = next((name for test, name in _KINDS if test(mode)), None)
    if kind is not None:
        raise InputError(file, "", f"is not a regular file but {kind}")
