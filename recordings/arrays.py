"""Reading arrays of real numbers from .npy and .npz files, malformed ones included.

NumPy's own reader trusts a header: it allocates the stated size, and its exceptions for malformed files are not
documented.  Here the header is checked before anything is allocated or read: type, shape, and that the file holds
exactly the stated number of bytes.
"""

from __future__ import annotations

import ast
import lzma
import math
import os
import re
import struct
import zipfile
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import IO

import numpy as np
import numpy.typing as npt

from tfra.runtime.errors import InputError, quoted, shortened
from tfra.runtime.inputs import memory, opened

Array = npt.NDArray[np.generic]
Shape = tuple[int, ...]

CheckShape = Callable[[Shape], str | None]
"""Function that states what is wrong with a shape, or returns None."""

_DAMAGE = (
    ValueError,
    EOFError,
    RuntimeError,
    OverflowError,
    LookupError,
    zipfile.BadZipFile,
    zlib.error,
    lzma.LZMAError,
    struct.error,
)
"""Exceptions of ``zipfile`` for damaged, encrypted and unknown archives."""

_MAGIC = b"\x93NUMPY"
_LENGTH = {1: ("<H", "latin-1"), 2: ("<I", "latin-1"), 3: ("<I", "utf-8")}
"""Format of the header's length, and its encoding, by the format's major version."""

_MOST_HEADER = 10_000
"""Bytes; NumPy writes 118 for an array of numbers."""

_LONGEST_TEXT = 1 << 20
"""Bytes of a text."""

_TYPE = re.compile(r"[<>|=]?[?biufcmMOSUV][0-9]{0,9}(\[[a-zA-Z]{1,2}\])?")


@dataclass(frozen=True, slots=True)
class Header:
    """The content of a .npy header."""

    dtype: np.dtype[np.generic]
    fortran: bool
    shape: Shape

    @property
    def bytes(self) -> int:
        """Bytes of the array."""
        return math.prod(self.shape) * self.dtype.itemsize


def read_npy(file: Path, key: str, check: CheckShape) -> Array:
    """Return the array of the .npy ``file``; complaints about it name ``key``.

    Raises ``InputError`` for a file that is damaged or no .npy file, and for an array that is not made of real numbers
    or whose shape ``check`` refuses.
    """
    with opened(file) as stream:
        return _array(file, key, stream, os.fstat(stream.fileno()).st_size, check)


@dataclass(frozen=True, slots=True)
class Archive:
    """An open .npz file."""

    file: Path
    zip: zipfile.ZipFile

    @property
    def keys(self) -> list[str]:
        """Names of the arrays."""
        return [name.removesuffix(".npy") for name in self.zip.namelist()]

    def read(self, key: str, check: CheckShape) -> Array:
        """Return the array called ``key``; raises ``InputError`` as ``read_npy`` and for a damaged archive."""
        if self.keys.count(key) > 1:
            raise InputError(self.file, key, "the archive holds this key more than once")
        member = self.zip.infolist()[self.keys.index(key)]
        if member.flag_bits & 1:
            raise InputError(self.file, key, "is encrypted")
        try:
            with self.zip.open(member) as stream:
                return _array(self.file, key, stream, member.file_size, check)
        except InputError:
            raise
        except NotImplementedError as error:
            raise InputError(self.file, key, f"cannot be unpacked: {error}") from None
        except (*_DAMAGE, OSError) as error:
            if isinstance(error, OSError) and error.errno:  # bzip2 raises its own without
                raise
            raise InputError(self.file, key, f"is damaged: {error or 'the data ends early'}") from None

    def text(self, key: str) -> str:
        """Return the text of ``key``, an array without axes, whose header is checked before anything it promises is
        believed; raises ``InputError`` for anything else.
        """
        member = self.zip.getinfo(f"{key}.npy")
        if member.file_size > _LONGEST_TEXT:
            raise InputError(self.file, key, f"a text of at most {_LONGEST_TEXT:,} bytes is needed")
        try:
            with self.zip.open(member) as stream:
                np.lib.format.read_magic(stream)
                shape, _, kind = np.lib.format.read_array_header_1_0(stream)
                data = stream.read()
            if shape != () or kind.kind != "U" or kind.itemsize != len(data):
                raise ValueError(f"got shape {shape} of {kind}")
            return data.decode("utf-32-be" if kind.byteorder == ">" else "utf-32-le").rstrip("\0")
        except (ValueError, EOFError, RuntimeError, zipfile.BadZipFile, zlib.error) as error:
            raise InputError(self.file, key, f"a text is needed: {shortened(str(error), 120)}") from None


@contextmanager
def archive(file: Path) -> Iterator[Archive]:
    """Open the .npz ``file``; raises ``InputError`` for any other file."""
    with opened(file) as stream:
        if stream.read(len(_MAGIC)) == _MAGIC:
            raise InputError(file, "", "is not a .npz file but a single array: call it .npy")
        try:
            found = zipfile.ZipFile(stream)
        except _DAMAGE as error:
            raise InputError(file, "", f"is not a readable .npz file: {error or 'it ends early'}") from None
        with found:
            yield Archive(file, found)


def _array(file: Path, key: str, stream: IO[bytes], size: int, check: CheckShape) -> Array:
    """Return the array in the ``size`` bytes of ``stream``."""
    header, length = _header(file, key, stream)
    if header.dtype.kind not in "iuf":
        found = "records" if header.dtype.kind == "V" else header.dtype
        raise InputError(file, key, f"real numbers are needed, got {found}")
    if any(count >= 1 << 63 for count in header.shape):
        raise InputError(file, key, f"the header promises the impossible shape {quoted(header.shape)}")
    if reason := check(header.shape):
        raise InputError(file, key, reason)
    promise = f"the header promises {header.bytes:,} bytes of numbers"
    if header.bytes != size - length:
        raise InputError(file, key, f"{promise}, the file has {max(0, size - length):,}")
    if header.bytes > memory() // 2:
        raise InputError(file, key, f"{promise}, more than half of this machine's memory")
    data = _filled(stream, header.bytes)
    if data is None:
        raise InputError(file, key, f"{promise}, the file ends before them")
    return data.view(header.dtype).reshape(header.shape, order="F" if header.fortran else "C")


def _filled(stream: IO[bytes], size: int) -> npt.NDArray[np.uint8] | None:
    """Return the next ``size`` bytes of ``stream``, or None if there are fewer."""
    data, done = np.empty(size, dtype=np.uint8), 0
    while done < size:
        part = stream.read(min(size - done, 1 << 20))
        if not part:
            return None
        data[done : done + len(part)] = np.frombuffer(part, dtype=np.uint8)
        done += len(part)
    return data


def _header(file: Path, key: str, stream: IO[bytes]) -> tuple[Header, int]:
    """Return the header of a .npy file, and its length in bytes."""
    start = stream.read(8)
    if start[:6] != _MAGIC or len(start) < 8:
        found = ": it is a .npz file" if start.startswith(b"PK\3\4") else ""
        raise InputError(file, key, f"is not a .npy array{found}")
    if start[6] not in _LENGTH:
        raise InputError(file, key, f"version 1, 2 or 3 of the .npy format is needed, got {start[6]}.{start[7]}")
    code, encoding = _LENGTH[start[6]]
    field = stream.read(struct.calcsize(code)).ljust(4, b"\0")
    length = struct.unpack_from(code, field)[0]
    if length > _MOST_HEADER:
        raise InputError(file, key, f"a header of at most {_MOST_HEADER:,} bytes is supported, got {length:,}")
    text = stream.read(length)
    try:
        return _parsed(ast.literal_eval(text.decode(encoding).strip())), 8 + struct.calcsize(code) + len(text)
    except (ValueError, SyntaxError, TypeError, LookupError, MemoryError, RecursionError):
        shown = shortened(text.decode("latin-1").strip(), 150)
        raise InputError(file, key, f"the header is damaged: {shown}") from None


def _parsed(entries: dict[str, object]) -> Header:
    """Return the header; raises ``ValueError``, ``TypeError`` or ``LookupError`` for other bytes."""
    shape, fortran, kind = entries["shape"], entries["fortran_order"], entries["descr"]
    if not isinstance(shape, tuple) or not all(type(count) is int and count >= 0 for count in shape):
        raise ValueError("shape")
    if not isinstance(fortran, bool):
        raise ValueError("fortran_order")
    if isinstance(kind, list):
        return Header(np.dtype("V1"), fortran, shape)  # records, whatever their fields
    if not isinstance(kind, str) or not _TYPE.fullmatch(kind):
        raise ValueError("descr")
    return Header(np.dtype(kind), fortran, shape)
