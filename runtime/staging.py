"""Atomic outputs: made in a hidden directory in the same folder, then exchanged with the old output in one step.

A staging directory ``.tfra-TOKEN-CHECK`` holds, at most,

    new      the output being written; all of it is this process's
    ready    what is complete, then what was exchanged for it: only what the program wrote is removed
    old      the same on file systems without an exchange, where two renames have to do
    target   a link that names the output, for a run that has to put ``old`` back

and its owner holds the lock of that name.  Every later output beside it removes those whose owner has died.
"""

import ctypes
import errno
import os
import secrets
import warnings
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from hashlib import sha256
from pathlib import Path

from tfra.runtime import scratch
from tfra.runtime.errors import Notice
from tfra.runtime.ownership import discard
from tfra.runtime.scratch import locked, reserve

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
    with suppress(FileNotFoundError):
        target.lstat()  # raises what a name that can't be one raises
    name = _name(secrets.token_hex(4))
    staging = target.parent / f".tfra-{name}"
    with ExitStack() as stack:
        stack.enter_context(locked(target.parent, name))
        with locked(target.parent, _name("exchange")):
            _sweep(target.parent)
            if os.path.lexists(target):
                check(target)
        staging.mkdir(mode=0o700)
        stack.callback(_recover, staging)
        stack.enter_context(reserve())
        (staging / "target").symlink_to(target.name)
        yield staging / "new"
        ready = staging / "ready"
        os.rename(staging / "new", ready)
        with locked(target.parent, _name("exchange")):
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


def _name(token: str) -> str:
    """A name that nothing has by chance: the second half follows from the ``token`` of eight characters."""
    return f"{token}-{sha256(os.fsencode(f'tfra staging {token}')).hexdigest()[:8]}"


def _sweep(parent: Path) -> None:
    """Remove the staging directories, and locks, of owners that have died."""
    with suppress(OSError):
        for name in {file.removeprefix(".tfra-").removesuffix(".lock") for file in os.listdir(parent)}:
            if name == _name(name[:8]):
                with suppress(OSError), locked(parent, name, wait=False) as free:
                    if free and not (staging := parent / f".tfra-{name}").is_symlink():
                        _recover(staging)


def _recover(staging: Path) -> None:
    """Remove ``staging``, and restore an output that was moved only half of the way; files of others stay in it."""
    old, link = staging / "old", staging / "target"
    scratch.discard(staging / "new")
    if os.path.lexists(old) and not os.path.lexists(target := staging.parent / os.readlink(link)):
        os.rename(old, target)
    if discard(staging / "ready") and discard(old):
        link.unlink(missing_ok=True)
        with suppress(FileNotFoundError):
            staging.rmdir()
    else:
        found = "holds files that tfra did not write, and that it found in its way"
        warnings.warn(f"{staging}: {found}", Notice, stacklevel=2)


def _rename(source: Path, target: Path, flag: int) -> None:
    """Rename by renameat2(2): with ``_EXCHANGE`` the two change places, with ``_NOREPLACE`` nothing is replaced."""
    call = getattr(ctypes.CDLL(None, use_errno=True), "renameat2", None)
    if call is None:
        raise OSError(errno.ENOSYS, os.strerror(errno.ENOSYS))
    if call(_AT_FDCWD, os.fsencode(source), _AT_FDCWD, os.fsencode(target), ctypes.c_uint(flag)):
        code = ctypes.get_errno()
        raise OSError(code, os.strerror(code), str(target))
