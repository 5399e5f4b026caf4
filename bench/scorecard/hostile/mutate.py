"""Changes of valid inputs by chance: of bytes, of text, and of arrays in archives."""

import re
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from io import BytesIO
from random import Random
from typing import Any

import numpy as np

Draw = Callable[[Random], bytes]
"""An input by chance."""

NUMBERS = (
    *(b"nan", b"-inf", b"inf", b"NaN", b"1e400", b"-1e-400", b"-0", b"0", b"-1", b"1", b"1e308", b"5e-324", b"0x1p9"),
    *(b"1e15", b"9223372036854775808", b"-9223372036854775808", b"4294967296", b"9" * 400, b"9" * 5000, b"1_000"),
    *("٣".encode(), "²".encode(), "１２".encode(), "½".encode(), b"+5", b".5", b"5.", b"1,5", b"", b"1e", b"--1"),
)
"""In place of a number."""
VALUES = (
    *(b"true", b'""', b"''", b'"a"', b"[]", b"{}", b"[[]]", b"[{}]", b"{a = 1}", b"[1, 2]", b"1979-05-27", b"07:32:00"),
    *(b"[" * 3000, b"[" * 90 + b"]" * 90, b'"\\u0000"', b'"' + b"x" * 3000 + b'"', b'"\\ud800"', b"null", b"[nan]"),
    *(b"{start = 0, stop = 360, step = 1e-9}", b'"../../x"', b'"."', b'"/dev/null"', b"{from = 0, to = 1e9}"),
)
"""In place of a value."""
TEXTS = (
    *(b"\0", b"\r", b"\n", b"\xef\xbb\xbf", b"\xff\xfe", b"\x80", b'"', b"'", b"\\", b"#", b";", b"\t", b" ", b","),
    *(b"\xc2\x85", "\u2028".encode(), b"\x1c", b"\x0c", b'"' + b"1" * 140_000, b"," * 3000, b"{", b"}", b"[", b"]"),
    *(b"%s%n", b"a.b.c.d.e = 1\n", b"[a]\n", b"[[contact]]\n", b"=", b"-", b"|", b"12:30:00"),
)
"""Put anywhere."""
INTEGERS = (
    0,
    1,
    2,
    0x7F,
    0x80,
    0xFF,
    0x7FFF,
    0xFFFF,
    0x7FFF_FFFF,
    0x8000_0000,
    0xFFFF_FFFF,
    2**40,
    2**63 - 1,
    2**64 - 1,
)
"""In place of a count or a size."""

_NUMBER = re.compile(rb"-?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?")
_WORD = re.compile(rb"[A-Za-z_]\w*")
_VALUE = re.compile(rb"(?<=[=:])[^\n]*")


def changed_bytes(data: bytes, rng: Random, seeds: Sequence[bytes]) -> bytes:
    """``data`` with one change at a place by chance; parts of ``seeds`` may come into it."""
    at = rng.randrange(len(data) + 1)
    end = min(len(data), at + int(rng.expovariate(0.05)) + 1)
    match rng.randrange(8):
        case 0:
            return data[:at]
        case 1:
            return data[:at] + data[end:]
        case 2:
            return data[:end] + data[at:]
        case 3:
            return data[:at] + rng.randbytes(end - at) + data[end:]
        case 4:
            other = rng.choice(seeds)
            return data[:at] + other[rng.randrange(len(other) + 1) :]
        case 5:
            size = rng.choice((1, 2, 4, 8))
            word = (rng.choice(INTEGERS) % (1 << 8 * size)).to_bytes(size, rng.choice(("little", "big")))
            return data[:at] + word + data[at + size :]
        case 6:
            return data[:at] + rng.choice(TEXTS) + data[at:]
        case _:
            return data[:at] + bytes(byte ^ 1 << rng.randrange(8) for byte in data[at : at + 1]) + data[at + 1 :]


def changed_text(data: bytes, rng: Random, seeds: Sequence[bytes]) -> bytes:
    """The same of a text: mostly whole numbers, values, words and lines."""
    match rng.randrange(8):
        case 0:
            return changed_bytes(data, rng, seeds)
        case 1 | 2:
            return _replaced(_NUMBER, data, rng, rng.choice(NUMBERS))
        case 3:
            return _replaced(_VALUE, data, rng, b" " + rng.choice((*VALUES, *NUMBERS)))
        case 4:
            return _replaced(_WORD, data, rng, rng.choice(_WORD.findall(rng.choice(seeds)) or [b"x"]))
        case 5:
            at = rng.randrange(len(data) + 1)
            return data[:at] + rng.choice(TEXTS) + data[at:]
        case _:
            lines, others = data.splitlines(keepends=True), rng.choice(seeds).splitlines(keepends=True)
            at = rng.randrange(len(lines) + 1)
            more = rng.choice(
                ((), rng.sample(others, min(1, len(others))), lines[at : at + 1] * rng.choice((2, 2, 40)))
            )
            return b"".join((*lines[:at], *more, *lines[at + 1 :]))


def _replaced(form: re.Pattern[bytes], data: bytes, rng: Random, new: bytes) -> bytes:
    """``data`` with ``new`` in place of one part of this ``form``."""
    places = [found.span() for found in form.finditer(data)]
    if not places:
        return data + new
    start, end = rng.choice(places)
    return data[:start] + new + data[end:]


Change = Callable[[bytes, Random, Sequence[bytes]], bytes]


def of(seeds: Sequence[bytes], change: Change = changed_text) -> Draw:
    """Inputs of one to four changes each."""

    def draw(rng: Random) -> bytes:
        data = rng.choice(seeds)
        for _ in range(rng.choice((1, 1, 1, 2, 2, 3, 4))):
            data = change(data, rng, seeds)
        return data

    return draw


def archived(arrays: Mapping[str, Any]) -> bytes:
    """The bytes of an archive."""
    stream = BytesIO()
    np.savez(stream, allow_pickle=False, **arrays)
    return stream.getvalue()


def of_arrays(stored: Sequence[Mapping[str, Any]]) -> Draw:
    """Whole archives, in which one to three arrays have other values, types, shapes or names."""

    def draw(rng: Random) -> bytes:
        arrays = dict(rng.choice(stored))
        for _ in range(rng.choice((1, 1, 2, 3))):
            key = rng.choice(list(arrays) or ["frames"])
            array = np.asarray(arrays.pop(key, 0.0))
            if rng.randrange(8):
                with suppress(ValueError, TypeError, RuntimeError):  # a type that does not become the other
                    array = changed_array(array, rng)
                arrays[key if rng.randrange(12) else rng.choice(list(arrays) or [key])] = array
        return archived(arrays)

    return draw


def changed_array(array: Any, rng: Random) -> Any:
    """``array`` with one change."""
    if array.dtype.kind == "U":
        text = str(array).encode()
        return np.array(changed_text(text, rng, [text]).decode(errors="replace"))
    match rng.randrange(7):
        case 0:
            kind = rng.choice(("f2", "f4", ">f8", "g", "i1", "u8", "c16", "?", "S3", "U2", "M8[s]", "V4"))
            with np.errstate(all="ignore"), suppress(OverflowError):  # text of a number that the kind lacks
                return np.zeros(array.shape, kind) if kind in ("M8[s]", "V4") else array.astype(kind)
            return array
        case 1:
            return array[..., :-1] if array.ndim else array.reshape(1)
        case 2:
            return rng.choice((array[None], array.T, array.ravel(), array[:0] if array.ndim else array))
        case 3:
            return np.concatenate([array, array]) if array.ndim else np.array("x")
        case 4:
            return -array if array.dtype.kind in "if" else array
        case _:
            wrong = array.astype(np.float64)
            if wrong.size:
                wrong.flat[rng.randrange(wrong.size)] = float(rng.choice(NUMBERS[:19]).replace(b"0x1p9", b"512")[:300])
            return wrong
