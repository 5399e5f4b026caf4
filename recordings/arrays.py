"""Reading arrays of real numbers from .npy and .npz files, malformed ones included.

NumPy reads the header.  Type, shape, and that the file holds exactly the bytes that the header promises are checked
before anything is allocated or read.
"""

import lzma
import math
import os
import struct
import tokenize
import warnings
import zipfile
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import IO

import numpy as np
import numpy.typing as npt

from tfra.model.arrays import Floats
from tfra.runtime.errors import InputError, quoted, shortened
from tfra.runtime.inputs import memory, opened

Array = npt.NDArray[np.generic]
Shape = tuple[int, ...]

NeededShape = tuple[int | None, ...]
"""A shape, in which None stands for any number."""

CheckShape = Callable[[Shape], str | None]
"""Function that states what is wrong with a shape, or returns None."""

_DAMAGE = (
    *(ValueError, EOFError, RuntimeError, OverflowError, LookupError),
    *(zipfile.BadZipFile, zlib.error, lzma.LZMAError, struct.error),
)
"""Exceptions of ``zipfile`` for damaged, encrypted and unknown archives."""

_HEADERS = {
    (1, 0): np.lib.format.read_array_header_1_0,
    (2, 0): np.lib.format.read_array_header_2_0,
    (3, 0): np.lib.format.read_array_header_2_0,  # differs in names of fields alone
}
"""NumPy's readers of a header by the format's version."""

_WRONG_HEADER = (ValueError, SyntaxError, TypeError, LookupError, MemoryError, RecursionError, tokenize.TokenError)
"""Exceptions of NumPy's readers."""

_LONGEST_TEXT = 1 << 20
"""Bytes of a text."""


def fits(needed: NeededShape) -> CheckShape:
    """Return the check for a ``needed`` shape."""

    def check(shape: Shape) -> str | None:
        if len(shape) == len(needed) and all(n in (None, m) for n, m in zip(needed, shape, strict=True)):
            return None
        wanted = ", ".join("n" if n is None else str(n) for n in needed) + "," * (len(needed) == 1)
        return f"shape ({wanted}) is needed, got {shortened(str(shape))}"

    return check


def doubles(array: Array) -> Floats:
    """Return ``array`` in double precision."""
    with np.errstate(all="ignore"):  # a long double may be infinite as a double
        return np.asarray(array, dtype=np.float64)


def read_npy(file: Path, key: str, check: CheckShape) -> Array:
    """Return the array of the .npy ``file``; complaints about it name ``key``.

    Raises ``InputError`` for a file that is damaged or no .npy file, and for an array that is not made of real numbers
    or whose shape ``check`` refuses.
    """
    with opened(file) as stream:
        return _read(file, key, stream, os.fstat(stream.fileno()).st_size, check)


@dataclass(frozen=True, slots=True)
class Archive:
    """An open .npz file."""

    file: Path
    zip: zipfile.ZipFile

    @property
    def keys(self) -> list[str]:
        """Names of the arrays."""
        return [name.removesuffix(".npy") for name in self.zip.namelist()]

    def read(self, key: str, check: CheckShape = lambda shape: None) -> Array:
        """Return the array called ``key``; raises ``InputError`` as ``read_npy`` and for a damaged archive."""
        with self._member(key) as (stream, size):
            return _read(self.file, key, stream, size, check)

    def text(self, key: str) -> str:
        """Return the text of ``key``, an array without axes; raises ``InputError`` for anything else."""
        with self._member(key) as (stream, size):
            if size > _LONGEST_TEXT:
                raise InputError(self.file, key, f"a text of at most {_LONGEST_TEXT:,} bytes is needed")
            return str(_read(self.file, key, stream, size, fits(()), "U")[()])

    @contextmanager
    def _member(self, key: str) -> Iterator[tuple[IO[bytes], int]]:
        """Open the member of ``key``, whose size is given, too; raises ``InputError``, also for damage in the block."""
        if self.keys.count(key) > 1:
            raise InputError(self.file, key, "the archive holds this key more than once")
        member = self.zip.infolist()[self.keys.index(key)]
        if member.flag_bits & 1:
            raise InputError(self.file, key, "is encrypted")
        try:
            with self.zip.open(member) as stream:
                yield stream, member.file_size
        except InputError:
            raise
        except NotImplementedError as error:
            raise InputError(self.file, key, f"cannot be unpacked: {error}") from None
        except (*_DAMAGE, OSError) as error:
            if isinstance(error, OSError) and error.errno:  # bzip2 raises its own without
                raise
            raise InputError(self.file, key, f"is damaged: {error or 'the data ends early'}") from None


@contextmanager
def archive(file: Path) -> Iterator[Archive]:
    """Open the .npz ``file``; raises ``InputError`` for any other file."""
    magic = np.lib.format.MAGIC_PREFIX
    with opened(file) as stream:
        if stream.read(len(magic)) == magic:
            raise InputError(file, "", "is not a .npz file but a single array: call it .npy")
        try:
            opened_zip = zipfile.ZipFile(stream)
        except _DAMAGE as error:
            raise InputError(file, "", f"is not a readable .npz file: {error or 'it ends early'}") from None
        with opened_zip:
            yield Archive(file, opened_zip)


def _read(file: Path, key: str, stream: IO[bytes], size: int, check: CheckShape, kinds: str = "iuf") -> Array:
    """Return the array in the ``size`` bytes of ``stream``; it must be of one of the ``kinds`` of NumPy."""
    shape, fortran, dtype = _header(file, key, stream)
    if dtype.kind not in kinds:
        needed = "a text is" if kinds == "U" else "real numbers are"
        raise InputError(file, key, f"{needed} needed, got {'records' if dtype.kind == 'V' else dtype}")
    if any(count >= 1 << 63 for count in shape):
        raise InputError(file, key, f"the header promises the impossible shape {quoted(shape)}")
    if reason := check(shape):
        raise InputError(file, key, reason)
    promised, have = math.prod(shape) * dtype.itemsize, size - stream.tell()
    promise = f"the header promises {promised:,} bytes of numbers"
    if promised != have:
        raise InputError(file, key, f"{promise}, the file has {max(0, have):,}")
    if promised > memory() // 2:
        raise InputError(file, key, f"{promise}, more than half of this machine's memory")
    data = np.empty(promised, dtype=np.uint8)
    if stream.readinto(data) < promised:  # type: ignore[attr-defined]  # of files and members of archives
        raise InputError(file, key, f"{promise}, the file ends before them")
    return data.view(dtype).reshape(shape, order="F" if fortran else "C")


def _header(file: Path, key: str, stream: IO[bytes]) -> tuple[Shape, bool, np.dtype[np.generic]]:
    """Return shape, whether the order is Fortran's, and type of a .npy file."""
    start = stream.read(np.lib.format.MAGIC_LEN)
    if not start.startswith(np.lib.format.MAGIC_PREFIX) or len(start) < np.lib.format.MAGIC_LEN:
        other = ": it is a .npz file" if start.startswith(b"PK\3\4") else ""
        raise InputError(file, key, f"is not a .npy array{other}")
    version = start[-2], start[-1]
    if version not in _HEADERS:
        raise InputError(file, key, f"version 1, 2 or 3 of the .npy format is needed, got {version[0]}.{version[1]}")
    try:
        with warnings.catch_warnings(action="ignore"):
            shape, fortran, dtype = _HEADERS[version](stream)
        if not all(type(count) is int and count >= 0 for count in shape):
            raise ValueError(f"shape {shape}")
    except _WRONG_HEADER as error:
        raise InputError(file, key, f"the header is damaged: {shortened(str(error), 150)}") from None
    return shape, fortran, dtype
