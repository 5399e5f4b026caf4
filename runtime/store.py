"""Results in files: each is written in one step, and the hash in it reveals damage.

A :class:`Store` has named results of one computation.  :func:`cached` has those of any computation, within a limit of
their size; the modification time of such a file is its last use.  :func:`work_folder` is the folder of a long command,
which goes on there after any interruption.
"""

import atexit
import errno
import json
import os
import re
import warnings
import zlib
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from functools import cache
from hashlib import sha256
from importlib.metadata import version
from pathlib import Path
from typing import Any

from tfra.runtime.errors import InputError, Notice, quoted
from tfra.runtime.inputs import opened
from tfra.runtime.scratch import discard, locked, part, scratch, sweep, temporary, writing

Files = Mapping[str, bytes]
"""Contents by name."""

LIMIT_MB = 500
"""Limit for all entries of a cache together, unless the variable ``TFRA_CACHE_MB`` sets another."""

_HASH = sha256().digest_size

_ENTRY = re.compile(r"(?:core|build|gates|fem|yosys|route)-.*[0-9a-f]{16}")
"""Names of entries.  No other file in a cache is ever removed; it may be the user's."""

_RESULT = "result.json"
"""The file of an entry that has what a step returned."""


# Files


def put(folder: Path, name: str, data: bytes) -> None:
    """Write a file in one step; raises ``InputError``."""
    with writing(folder):
        sweep(folder)
        with locked(folder, name):
            _replace(folder / name, data)


def _replace(path: Path, data: bytes) -> None:
    """Put ``data`` at ``path``, whose lock is held; raises ``OSError``."""
    fresh = part(path.parent, path.name)
    try:
        discard(fresh)
        fresh.write_bytes(data)
        os.replace(fresh, path)
    except BaseException:
        with suppress(OSError):
            discard(fresh)
        raise


@dataclass(frozen=True)
class Store:
    """Results of the computation ``key`` in ``folder``; any process may add some.

    A file has a hash of the key, its name and the data, then the data: one that is damaged, of another computation or
    in another place is rejected.
    """

    folder: Path
    key: str = ""

    def create(self) -> None:
        """Make the folder if it is missing; raises ``InputError``."""
        with writing(self.folder):
            self.folder.mkdir(parents=True, exist_ok=True)

    def names(self) -> set[str]:
        """Names of all files in the folder, intact or not; raises ``InputError``."""
        try:
            return set(os.listdir(self.folder))
        except OSError as error:
            raise InputError(self.folder, "", f"cannot be read: {error.strerror}") from None

    def put(self, name: str, data: bytes) -> None:
        """Store a result in one step, in place of an older one; raises ``InputError`` when it can't be written."""
        put(self.folder, name, self._hash(name, data) + data)

    def get(self, name: str) -> bytes:
        """Load a result; raises ``InputError`` where its file is missing or not as it was written."""
        file = self.folder / name
        with opened(file) as stream:
            expected, data = stream.read(_HASH), stream.read()
        if expected != self._hash(name, data):
            raise InputError(file, "", "is not as it was written: remove it, to have it made again")
        return data

    def _hash(self, name: str, data: bytes) -> bytes:
        digest = sha256(f"{self.key} {name}\n".encode())
        digest.update(data)
        return digest.digest()


# A cache


def cache_directory(chosen: str | Path | None = None) -> Path:
    """Return ``chosen``, else the directory in the variable ``TFRA_CACHE``, else ``~/.cache/tfra``; it exists
    afterwards.

    If the default can't be used, a warning states so and a private directory replaces it until this process ends.
    Raises ``InputError`` if a named one can't be used.
    """
    named = chosen or os.environ.get("TFRA_CACHE")
    try:
        folder = Path(named).absolute() if named else Path.home() / ".cache" / "tfra"
        _require_writable(folder)
    except (OSError, RuntimeError) as error:  # the latter where there is no home
        reason = error.strerror if isinstance(error, OSError) else str(error)
        if not named:
            return _private(f"no cache in ~/.cache/tfra, nothing is kept between runs: {reason}")
        raise InputError(str(chosen or f"TFRA_CACHE: {named}"), "", f"cannot be used as cache: {reason}") from None
    return folder


def _require_writable(folder: Path) -> None:
    """Make ``folder`` if it is missing; raises ``OSError`` where nothing can be written."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except FileExistsError:
        raise NotADirectoryError(errno.ENOTDIR, os.strerror(errno.ENOTDIR)) from None
    if not os.access(folder, os.R_OK | os.W_OK | os.X_OK):
        raise PermissionError(errno.EACCES, "it cannot be written")


@cache
def _private(warning: str) -> Path:
    warnings.warn(warning, Notice, stacklevel=3)
    stack = ExitStack()
    atexit.register(stack.close)
    return stack.enter_context(scratch(temporary()))


def cached(path: Path, make: Callable[[], Files]) -> dict[str, bytes]:
    """Return the files of the entry ``path`` of a cache, from ``make`` if it is missing or damaged in any way.

    If several processes need the same entry at once, one makes it and the others wait.  No process works inside an
    entry, so replacing it is safe.  An entry that can't be stored is used all the same, with a warning.
    """
    limit = _limit()
    if (files := _load(path)) is not None:
        return files
    with writing(path.parent):
        sweep(path.parent)
        with locked(path.parent, path.name):
            if (files := _load(path)) is None:
                files = dict(make())
                _keep(path, files)
                _prune(path.parent, limit, path.name)
    return files


def cached_step(
    name: str, key: str, directory: Path, step: Callable[[], dict[str, Any]]
) -> tuple[dict[str, Any], bool]:
    """Return the result of ``step``, plain JSON types, and whether it comes from the cache with the step's new files.

    ``name`` and ``key`` identify the step; its files are in ``directory`` afterwards, in either case.
    """
    results: list[dict[str, Any]] = []

    def make() -> Files:
        before = set(os.listdir(directory))
        results.append(step())
        new = {name: (directory / name).read_bytes() for name in sorted({*os.listdir(directory)} - before)}
        content = {_RESULT: json.dumps(results[0]).encode(), **new}
        return {name: zlib.compress(data, 1) for name, data in content.items()}

    files = cached(cache_directory() / f"{name}-{key}", make)
    if results:
        return results[0], False
    content = {name: zlib.decompress(data) for name, data in files.items()}
    result: dict[str, Any] = json.loads(content.pop(_RESULT))
    for file, data in content.items():
        (directory / file).write_bytes(data)
    return result, True


def _limit() -> int:
    """Limit of all entries in bytes; raises ``InputError`` for a variable that is no number of megabytes."""
    wanted = os.environ.get("TFRA_CACHE_MB", str(LIMIT_MB))
    if not re.fullmatch("[0-9]{1,9}", wanted) or not int(wanted):
        raise InputError("TFRA_CACHE_MB", "", f"a whole number of megabytes above 0 is needed, got {quoted(wanted)}")
    return 1_000_000 * int(wanted)


def _load(path: Path) -> dict[str, bytes] | None:
    """Return the files of an entry, which is used now; None if it is not exactly what was written."""
    try:
        content = Store(path.parent).get(path.name)
    except InputError:
        return None
    start = content.index(b"\n") + 1
    files = {}
    for name, length in json.loads(content[:start]).items():
        files[name] = content[start : start + length]
        start += length
    with suppress(OSError):
        os.utime(path)
    return files


def _keep(path: Path, files: Files) -> None:
    """Store the files of an entry, whose lock is held: their lengths as JSON, then their contents."""
    lengths = json.dumps({name: len(data) for name, data in files.items()})
    data = b"".join([lengths.encode(), b"\n", *files.values()])
    try:
        discard(path)
        _replace(path, Store(path.parent)._hash(path.name, data) + data)
    except OSError as error:
        warnings.warn(f"{path}: not kept for the next run: {error.strerror}", Notice, stacklevel=3)


def _prune(folder: Path, limit: int, fresh: str) -> None:
    """Remove entries until all have ``limit`` bytes or fewer, the longest unused first; ``fresh`` stays."""
    entries = []
    with os.scandir(folder) as files:
        for file in files:
            with suppress(OSError):  # another process has removed it
                if _ENTRY.fullmatch(file.name) and file.is_file(follow_symlinks=False):
                    about = file.stat(follow_symlinks=False)
                    entries.append((file.name == fresh, about.st_mtime_ns, about.st_size, file.path))
    total = sum(size for _, _, size, _ in entries)
    for newest, _, size, path in sorted(entries):
        if total <= limit or newest:
            return
        with suppress(OSError):
            os.unlink(path)
            total -= size


# Folders of long commands


@contextmanager
def work_folder(folder: Path, kind: str, sources: str) -> Iterator[None]:
    """Reserve ``folder``, which is made if it is missing, for one process and one ``kind`` of work during the block.

    ``sources`` is the hash of what decides the results.  Raises ``InputError`` where the folder has other contents, is
    of other sources, or is in use.
    """
    about = f"{kind}.json"
    with writing(folder):
        folder.mkdir(parents=True, exist_ok=True)
        empty = not os.listdir(folder)
    if empty:
        content = {"generator": f"tfra {version('tfra')}", "sources": sources}
        put(folder, about, (json.dumps(content, indent=1) + "\n").encode())
    try:
        with opened(folder / about) as stream:
            content = json.loads(stream.read())
        generator, its_sources = str(content["generator"]), content["sources"]
    except (InputError, ValueError, LookupError, TypeError, RecursionError):
        raise InputError(folder, "", f"is not the folder of a {kind}: choose another one by --work") from None
    if its_sources != sources:
        reason = f"has work of {generator} with other sources, which is kept: choose another one by --work"
        raise InputError(folder, "", reason)
    with locked(folder, kind, wait=False) as free:
        if not free:
            raise InputError(folder, "", "is in use by another run: wait for it, or choose another folder by --work")
        yield
