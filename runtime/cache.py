"""Results that take long to compute are kept between runs, each in a file with a hash that reveals damage.

The modification time of a file is its last use.  Above the size limit, the least recently used files are removed first.
"""

from __future__ import annotations

import atexit
import errno
import hashlib
import json
import os
import re
import stat
import warnings
from collections.abc import Callable, Mapping
from contextlib import ExitStack, suppress
from functools import cache
from pathlib import Path

from tfra.runtime.errors import InputError, Notice, quoted
from tfra.runtime.scratch import discard, locked, part, scratch, sweep, temporary, writing

Files = Mapping[str, bytes]
"""Contents by name."""

_HASH = hashlib.sha256().digest_size

_ENTRY = re.compile(r"(?:core|build|gates|fem|yosys|route)-.*[0-9a-f]{16}")
"""Names of entries.  No other file in the folder is ever removed; it may be the user's."""

LIMIT_MB = 500
"""Limit for all entries together, unless the variable ``TFRA_CACHE_MB`` sets another."""


def cache_directory(chosen: str | Path | None = None) -> Path:
    """Return ``chosen``, else the directory in the variable ``TFRA_CACHE``, else ``~/.cache/tfra``; it exists
    afterwards.

    If the default can't be used, a warning states so and a private directory replaces it until this process ends.
    Raises ``InputError`` if a named one can't be used.
    """
    named = chosen or os.environ.get("TFRA_CACHE")
    try:
        place = Path(named).absolute() if named else Path.home() / ".cache" / "tfra"
        _prepare(place)
    except (OSError, RuntimeError) as error:  # the latter where there is no home
        reason = error.strerror if isinstance(error, OSError) else str(error)
        if not named:
            return _private(f"no cache in ~/.cache/tfra, nothing is kept between runs: {reason}")
        place_named = str(chosen or f"TFRA_CACHE: {named}")
        raise InputError(place_named, "", f"cannot be used as cache: {reason}") from None
    return place


def _prepare(place: Path) -> None:
    """Make ``place`` if it is missing; raises ``OSError`` where nothing can be written."""
    try:
        place.mkdir(parents=True, exist_ok=True)
    except FileExistsError:
        raise NotADirectoryError(errno.ENOTDIR, os.strerror(errno.ENOTDIR)) from None
    if not os.access(place, os.R_OK | os.W_OK | os.X_OK):
        raise PermissionError(errno.EACCES, "it cannot be written")


@cache
def _private(warning: str) -> Path:
    warnings.warn(warning, Notice, stacklevel=3)
    stack = ExitStack()
    atexit.register(stack.close)
    return stack.enter_context(scratch(temporary()))


def kept(place: Path, make: Callable[[], Files]) -> dict[str, bytes]:
    """Return the files of the entry ``place`` of a cache, from ``make`` if it is missing or damaged in any way.

    If several processes need the same entry at once, one makes it and the others wait.  No process works inside an
    entry, so replacing it is safe.
    """
    limit = _limit()
    if (found := _read(place)) is not None:
        return found
    folder = place.parent
    with writing(folder):
        sweep(folder)
        with locked(folder, place.name):
            if (found := _read(place)) is not None:
                return found
            files = dict(make())
            _write(place, files)
            _prune(folder, limit, place)
    return files


def _limit() -> int:
    """Limit of all entries in bytes; raises ``InputError`` for a variable that is no number of megabytes."""
    wanted = os.environ.get("TFRA_CACHE_MB", str(LIMIT_MB))
    if not wanted.isdecimal() or not int(wanted):
        raise InputError("TFRA_CACHE_MB", "", f"a whole number of megabytes above 0 is needed, got {quoted(wanted)}")
    return 1_000_000 * int(wanted)


def _prune(folder: Path, limit: int, fresh: Path) -> None:
    """Remove entries until all have ``limit`` bytes or fewer, the longest unused first; ``fresh`` stays."""
    found = []
    with os.scandir(folder) as entries:
        for entry in entries:
            with suppress(OSError):  # another process has removed it
                if _ENTRY.fullmatch(entry.name) and entry.is_file(follow_symlinks=False):
                    about = entry.stat(follow_symlinks=False)
                    found.append((entry.name == fresh.name, about.st_mtime_ns, about.st_size, entry.path))
    total = sum(size for _, _, size, _ in found)
    for newest, _, size, path in sorted(found):
        if total <= limit or newest:
            return
        with suppress(OSError):
            os.unlink(path)
            total -= size


def _write(place: Path, files: Files) -> None:
    """Store ``files`` as the entry ``place``; on failure, a warning states why."""
    manifest = json.dumps({name: len(content) for name, content in files.items()})
    body = b"".join([manifest.encode(), b"\n", *files.values()])
    fresh = part(place.parent, place.name)
    try:
        discard(fresh)
        fresh.write_bytes(_hash(place, body) + body)
        discard(place)
        os.replace(fresh, place)
    except OSError as error:
        warnings.warn(f"{place}: not kept for the next run: {error.strerror}", Notice, stacklevel=2)
        with suppress(OSError):
            discard(fresh)


def _read(place: Path) -> dict[str, bytes] | None:
    """Return the files of the entry ``place``, or None if it is not exactly what was written."""
    try:
        if not stat.S_ISREG(place.lstat().st_mode):
            return None
        content = place.read_bytes()
    except (OSError, MemoryError):
        return None
    body = memoryview(content)[_HASH:]
    if content[:_HASH] != _hash(place, body):
        return None
    start = content.index(b"\n", _HASH) + 1
    files = {}
    for name, length in json.loads(content[_HASH:start]).items():
        files[name] = content[start : start + length]
        start += length
    with suppress(OSError):
        os.utime(place)  # it was used now
    return files


def _hash(place: Path, body: bytes | memoryview) -> bytes:
    """Hash of an entry's name and content, so that an intact entry under another name is rejected, too."""
    hashed = hashlib.sha256(place.name.encode() + b"\n")
    hashed.update(body)
    return hashed.digest()
