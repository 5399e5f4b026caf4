"""Reading a user's file: regular files only, with one line for every failure; TOML becomes tables."""

import os
import re
import stat
import tomllib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO

from tfra.runtime.errors import InputError

MOST_BYTES = 2_000_000
"""tomllib takes two seconds for them."""

MOST_DOTS = 20
"""In a key: tomllib's time grows with their square, and a million takes hours."""

_COMMENT, _BETWEEN = re.compile(rb"#[^\n]*"), re.compile(rb"[,={}\n]")

_KINDS = {stat.S_IFIFO: "a pipe", stat.S_IFSOCK: "a socket", stat.S_IFCHR: "a device", stat.S_IFBLK: "a device"}


@contextmanager
def opened(file: Path) -> Iterator[BinaryIO]:
    """Open the regular ``file``; raises ``InputError`` when it is none, or when an ``OSError`` ends the block.

    A pipe could block for ever, and opening a device may have an effect, so neither is opened.
    """
    if "\0" in str(file):
        raise InputError(file, "", "cannot be read: no file has a NUL in its name")
    try:
        _require_regular(file, os.stat(file).st_mode)
        # It may have become a pipe since, so it is opened without waiting and checked again.
        with open(file, "rb", opener=lambda path, flags: os.open(path, flags | os.O_NONBLOCK)) as stream:
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


def _require_regular(file: Path, mode: int) -> None:
    if kind := _KINDS.get(stat.S_IFMT(mode)):
        raise InputError(file, "", f"is not a regular file but {kind}")


def read_toml(file: Path) -> dict[str, Any]:
    """Return the tables of ``file``; raises ``InputError`` naming the line that is no TOML."""
    with opened(file) as stream:
        data = stream.read(MOST_BYTES + 1)
    if len(data) > MOST_BYTES:
        raise InputError(file, "", f"at most {MOST_BYTES:,} bytes of TOML are supported")
    if any(part.count(b".") > MOST_DOTS for part in _BETWEEN.split(_COMMENT.sub(b"", data))):
        raise InputError(file, "", f"is not valid TOML: a key has more than {MOST_DOTS} dots")
    try:
        tables = tomllib.loads(data.decode("utf-8-sig"))
    except UnicodeDecodeError as error:
        line = data[: error.start].count(b"\n") + 1
        raise InputError(file, f"line {line}", "is not UTF-8 text") from None
    except tomllib.TOMLDecodeError as error:
        reason, _, place = str(error).removesuffix(")").rpartition(" (at ")
        last = data.count(b"\n") + 1
        place, reason = place.replace("end of document", f"line {last}"), reason + _toml_hint(file, data)
        raise InputError(file, place, reason) from None
    except (ValueError, RecursionError):  # an integer of thousands of digits, thousands of brackets
        raise InputError(file, "", "is not valid TOML") from None
    if (key := _too_long(tables)) is not None:
        raise InputError(file, key.removeprefix("."), "a whole number of at most 64 bits is needed")
    return tables


def _toml_hint(file: Path, data: bytes) -> str:
    """What may be behind a file that is no TOML."""
    if file.suffix != ".toml":
        return ": a file of TOML is needed here, in which keys have values"
    return ": numbers have decimal points, as 2.8" if re.search(rb"^\s*\w+\s*=\s*[-+]?\d+,\d", data, re.M) else ""


def _too_long(value: object) -> str | None:
    """Return the key below ``value`` of an integer of more than 64 bits, as TOML has none, or None."""
    if isinstance(value, int):
        return None if -1 << 63 <= value < 1 << 63 else ""
    if isinstance(value, dict):
        parts = ((f".{key}", each) for key, each in value.items())
    elif isinstance(value, list):
        parts = ((f"#{number}", each) for number, each in enumerate(value, 1))
    else:
        return None
    found = (f"{part}{key}" for part, each in parts if (key := _too_long(each)) is not None)
    return next(found, None)
