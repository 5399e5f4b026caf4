"""Temporary folders, and locks that reveal whether the process that made one is still alive.

A folder ``.tfra-NAME.part`` belongs to the process that holds the lock file ``.tfra-NAME.lock`` in the same place.  Its
owner removes both at the end.  The system releases the lock of a killed owner, so a later run can remove its folder.
"""

import errno
import fcntl
import os
import re
import secrets
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

from tfra.runtime.errors import InputError

_OWN = re.compile(r"\.tfra-(.+)\.(?:lock|part)")
_DEPTH = 8
"""Deepest folder that is removed without further file handles."""

_NOT_A_LOCK = (errno.EISDIR, errno.ELOOP, errno.ENXIO)
"""Errors of opening a folder, a link or a socket."""


def temporary() -> Path:
    """Return the system's folder for temporary files; raises ``InputError`` where there is none."""
    try:
        return Path(tempfile.gettempdir())
    except OSError:
        raise InputError("TMPDIR", "", "no folder for temporary files can be written") from None


@contextmanager
def scratch(parent: Path) -> Iterator[Path]:
    """Make a folder in ``parent`` for the block; folders that killed processes left there are removed.

    Raises ``InputError`` where it can't be made.
    """
    with ExitStack() as stack:
        with writing(parent):
            sweep(parent)
            name = secrets.token_hex(8)
            stack.enter_context(locked(parent, name))
            place = part(parent, name)
            stack.callback(shutil.rmtree, place, ignore_errors=True)
            stack.enter_context(reserve())
            place.mkdir(mode=0o700)
        yield place


@contextmanager
def reserve() -> Iterator[None]:
    """Keep file handles in the block for its clean-up, which needs some when all others are in use.

    Raises ``OSError`` if there are not enough.
    """
    with ExitStack() as stack:
        first = os.open(os.devnull, os.O_RDONLY)
        stack.callback(os.close, first)
        for _ in range(_DEPTH):
            stack.callback(os.close, os.dup(first))
        yield


@contextmanager
def writing(place: str | Path) -> Iterator[None]:
    """Raise ``InputError`` that names ``place`` when something can't be written in the block."""
    try:
        yield
    except OSError as error:
        raise InputError(place, "", f"cannot be written: {error.strerror or error}") from None


def sweep(parent: Path) -> None:
    """Remove the parts in ``parent`` whose owners are certainly dead: their locks are free."""
    for name in {found[1] for file in os.listdir(parent) if (found := _OWN.fullmatch(file))}:
        with suppress(OSError), locked(parent, name, wait=False) as held:
            if held:
                discard(part(parent, name))


def part(parent: Path, name: str) -> Path:
    """Return the folder of the owner of the lock ``name``."""
    return parent / f".tfra-{name}.part"


@contextmanager
def locked(parent: Path, name: str, wait: bool = True) -> Iterator[bool]:
    """Hold the lock ``name`` in ``parent``; without ``wait``, yields whether it was acquired.

    On a file system without locks, no process waits, and no owner counts as dead.
    """
    path = parent / f".tfra-{name}.lock"
    descriptor = _acquire(path, wait)
    try:
        yield descriptor is not None
    finally:
        if descriptor is not None:
            with suppress(OSError):
                path.unlink()  # before the release: a waiting process sees that it is gone, and makes another
            os.close(descriptor)


def _acquire(path: Path, wait: bool) -> int | None:
    while True:
        descriptor = _open(path, wait)
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
        except OSError:  # held by another, or no locks here
            if not wait:
                os.close(descriptor)
                return None
        except BaseException:
            os.close(descriptor)
            raise
        with suppress(OSError):
            if os.path.samestat(os.fstat(descriptor), os.lstat(path)):
                return descriptor
        os.close(descriptor)


def _open(path: Path, wait: bool) -> int:
    """Open the lock file ``path``; anything else in its place is removed."""
    while True:
        try:
            return os.open(path, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW | os.O_NONBLOCK, 0o666)
        except OSError as error:
            unreadable = wait and error.errno == errno.EACCES and os.path.lexists(path)
            if error.errno not in _NOT_A_LOCK and not unreadable:
                raise
        discard(path)


def discard(path: Path) -> None:
    """Remove the file, folder or link at ``path``, but never the target of a link."""
    try:
        path.unlink(missing_ok=True)
    except IsADirectoryError:
        path.chmod(0o700)
        shutil.rmtree(path)
