"""Atomic outputs: made in a hidden directory in the same folder, then exchanged with the old output in one step.

A staging directory ``.tfra-TOKEN-CHECK`` holds, at most,

    new      the output being written; all of it is this process's
    ready    what is complete, then what was exchanged for it: only what the program wrote is removed
    old      the same on file systems without an exchange, where two renames have to do
    target   a link that names the output, for a run that has to put ``old`` back

and is locked while its owner lives.  Every later output beside it removes those whose owner has died.
"""

import ctypes
import errno
import fcntl
import os
import secrets
import shutil
import warnings
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, nullcontext, suppress
from hashlib import sha256
from pathlib import Path

from tfra.runtime.errors import Notice
from tfra.runtime.ownership import discard

_NOREPLACE, _EXCHANGE = 1, 2
"""Flags of renameat2(2)."""

_AT_FDCWD = -100
_UNSUPPORTED = (errno.EINVAL, errno.ENOSYS, errno.EOPNOTSUPP)

Check = Callable[[Path], None]
"""Raises an exception if what is at the path must stay."""


@contextmanager
def staged(target: Path, check: Check) -> Iterator[Path]:
    """Yield a free path; the file or folder that the block makes there becomes ``target``.

    ``check`` is called for the present ``target`` now and before it is moved, and for what was moved; if it raises
    then, the move is undone.  An exception in the block leaves ``target`` alone.  Raises ``OSError``.
    """
    with _locked_staging(target, check) as staging:
        yield staging / "new"
        ready = staging / "ready"
        os.rename(staging / "new", ready)
        with _locked(target.parent):
            _place(ready, target, check)


def _place(ready: Path, target: Path, check: Check) -> None:
    while True:
        try:
            if not os.path.lexists(target):
                _rename(ready, target, _NOREPLACE)
                return
            check(target)
            _rename(ready, target, _EXCHANGE)
            break
        except (FileExistsError, FileNotFoundError):  # another process made or removed it just now
            if not os.path.lexists(ready):
                raise
        except OSError as error:
            if error.errno not in _UNSUPPORTED:
                raise
            _place_by_renames(ready, target, check)
            return
    try:
        check(ready)
    except BaseException:
        _rename(ready, target, _EXCHANGE)
        raise


def _place_by_renames(ready: Path, target: Path, check: Check) -> None:
    """The same on a file system without an exchange: for a moment there is nothing at ``target``."""
    old = ready.with_name("old")
    if os.path.lexists(target):
        check(target)
        os.rename(target, old)
    try:
        if os.path.lexists(old):
            check(old)
        os.rename(ready, target)
    except BaseException:
        if os.path.lexists(old):
            os.rename(old, target)
        raise


@contextmanager
def _locked_staging(target: Path, check: Check) -> Iterator[Path]:
    """Make a staging directory after removing those of dead owners, and remove it in the end."""
    with suppress(FileNotFoundError):
        target.lstat()  # raises what a name that can't be one raises
    staging = target.parent / _name(secrets.token_hex(4))
    with ExitStack() as stack:
        with _locked(target.parent):  # no process takes a new directory for a leftover before it is locked
            _sweep(target.parent)
            if os.path.lexists(target):
                check(target)
            staging.mkdir(mode=0o700)
            stack.enter_context(_locked(staging))
            stack.callback(_recover, staging)
        (staging / "target").symlink_to(target.name)
        yield staging


def _name(token: str) -> str:
    """A name that no directory has by chance: the second half follows from the first."""
    return f".tfra-{token}-{sha256(f'tfra staging {token}'.encode()).hexdigest()[:8]}"


def _sweep(parent: Path) -> None:
    """Remove the staging directories of owners that have died."""
    with suppress(OSError):
        for name in os.listdir(parent):
            token = name.removeprefix(".tfra-")[:8]
            if name == _name(token) and not (staging := parent / name).is_symlink():
                with suppress(OSError), _locked(staging, wait=False):
                    _recover(staging)


def _recover(staging: Path) -> None:
    """Remove ``staging``, and restore an output that was moved only half of the way; files of others stay in it."""
    new, old, link = (staging / name for name in ("new", "old", "target"))
    if new.is_dir() and not new.is_symlink():
        shutil.rmtree(new)
    else:
        new.unlink(missing_ok=True)
    if os.path.lexists(old) and not os.path.lexists(target := staging.parent / os.readlink(link)):
        os.rename(old, target)
    if discard(staging / "ready") and discard(old):
        link.unlink(missing_ok=True)
        with suppress(FileNotFoundError):
            staging.rmdir()
    else:
        found = "holds files that tfra did not write, and that it found in its way"
        warnings.warn(f"{staging}: {found}", Notice, stacklevel=2)


@contextmanager
def _locked(directory: Path, wait: bool = True) -> Iterator[None]:
    """Hold the lock of ``directory``, which vanishes with the process; go without on file systems that have none.

    Without ``wait``, raise ``OSError`` where another process holds it, or locks do not exist.
    """
    handle = os.open(directory, os.O_RDONLY | os.O_DIRECTORY)
    try:
        with suppress(OSError) if wait else nullcontext():
            fcntl.flock(handle, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
        yield
    finally:
        os.close(handle)


def _rename(source: Path, target: Path, flag: int) -> None:
    """Rename by renameat2(2): with ``_EXCHANGE`` the two change places, with ``_NOREPLACE`` nothing is replaced."""
    call = getattr(ctypes.CDLL(None, use_errno=True), "renameat2", None)
    if call is None:
        raise OSError(errno.ENOSYS, os.strerror(errno.ENOSYS))
    if call(_AT_FDCWD, os.fsencode(source), _AT_FDCWD, os.fsencode(target), ctypes.c_uint(flag)):
        code = ctypes.get_errno()
        raise OSError(code, os.strerror(code), str(target))
