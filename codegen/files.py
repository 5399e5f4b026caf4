"""Output that is there completely or not at all."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt

from tfra.model.errors import InputError


@contextmanager
def atomic_write(path: str | Path) -> Iterator[BinaryIO]:
    """Open a temporary file beside ``path``, which takes its place when the block ends without an exception.

    Raises ``InputError`` when the file can't be written or when something other than a file is in the way.
    Keep only the writing inside the block: its ``OSError``s are told as trouble with ``path``.
    """
    target = Path(os.path.realpath(path))
    temporary = _aside(target, "tmp")
    try:
        if target.exists() and not target.is_file():
            raise InputError(path, "", "cannot be written: it is not a regular file")
        with open(temporary, "xb") as stream:
            yield stream
        os.replace(temporary, target)
    except OSError as error:
        raise InputError(path, "", f"cannot be written: {error.strerror}") from None
    finally:
        with suppress(OSError):
            temporary.unlink()


def check_writable(path: str | Path, suffix: str) -> None:
    """Raise ``InputError`` now if writing ``path`` would, or if its name does not end in ``suffix``.

    Worth knowing before a long computation.
    """
    if Path(path).suffix != suffix:
        raise InputError(path, "", f"the name of the output must end in {suffix}")
    with suppress(_Rehearsal), atomic_write(path):
        raise _Rehearsal


class _Rehearsal(Exception):
    pass


def write_npz(path: str | Path, arrays: Mapping[str, npt.NDArray[Any]]) -> None:
    """Write ``arrays`` as an uncompressed .npz; equal arrays give equal bytes (no dates, no pickles).

    Raises ``InputError`` as ``atomic_write``.
    """
    with atomic_write(path) as stream:
        np.savez(stream, allow_pickle=False, **dict(arrays))


@contextmanager
def atomic_directory(path: str | Path, sidecar: str) -> Iterator[Path]:
    """Make an empty directory beside ``path``, which takes its place when the block ends without exception.

    ``path`` may be missing, empty, or an earlier output: a directory with the JSON object ``sidecar`` whose
    ``"generator"`` starts with ``tfra``.  Anything else is left alone.  Raises ``InputError`` then, when the
    directory can't be written, and ``ValueError`` when the block did not write such a sidecar itself.
    """
    target = Path(os.path.realpath(path))
    _check_replaceable(path, target, sidecar)
    fresh = _aside(target, "tmp")
    try:
        fresh.mkdir()
        yield fresh
        if not _is_generated(fresh, sidecar):
            raise ValueError(f"{sidecar}: the sidecar with its generator is missing")
        _swap(fresh, target)
    except OSError as error:
        raise InputError(path, "", f"cannot be written: {error.strerror}") from None
    finally:
        shutil.rmtree(fresh, ignore_errors=True)


def _aside(target: Path, kind: str) -> Path:
    return target.with_name(f".{target.name}.{os.getpid()}.{kind}")


def _check_replaceable(path: str | Path, target: Path, sidecar: str) -> None:
    try:
        if not target.exists():
            return
        if not target.is_dir():
            raise InputError(path, "", "cannot be replaced: it is not a directory")
        if any(target.iterdir()) and not _is_generated(target, sidecar):
            reason = f"is not replaced: it is not empty and holds no {sidecar} written by tfra"
            raise InputError(path, "", reason)
    except OSError as error:
        raise InputError(path, "", f"cannot be read: {error.strerror}") from None


def _is_generated(directory: Path, sidecar: str) -> bool:
    try:
        content = json.loads((directory / sidecar).read_bytes())
    except (OSError, ValueError):
        return False
    return isinstance(content, dict) and str(content.get("generator", "")).startswith("tfra")


def _swap(fresh: Path, target: Path) -> None:
    """Put ``fresh`` in place of ``target``; the old content returns if that fails."""
    if not target.exists():
        os.rename(fresh, target)
        return
    old = _aside(target, "old")
    os.rename(target, old)
    try:
        os.rename(fresh, target)
    except OSError:
        os.rename(old, target)
        raise
    shutil.rmtree(old, ignore_errors=True)
