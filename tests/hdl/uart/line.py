"""A serial line and its frames, as the other side has them."""

from collections.abc import Iterable

from tfra.hdl.uart.slip import END, ESC, ESC_END, ESC_ESC


def framed(content: bytes) -> bytes:
    """``content`` as a SLIP frame, with an END before and after it."""
    body = content.replace(bytes([ESC]), bytes([ESC, ESC_ESC])).replace(bytes([END]), bytes([ESC, ESC_END]))
    return bytes([END]) + body + bytes([END])


def frames(line: bytes) -> list[bytes]:
    """The frames of a line, without the empty ones; raises ``AssertionError`` for an escape that no frame has."""
    found = []
    for body in line.split(bytes([END])):
        pieces = body.split(bytes([ESC]))
        assert all(piece[:1] in (bytes([ESC_END]), bytes([ESC_ESC])) for piece in pieces[1:])
        starts = {ESC_END: bytes([END]), ESC_ESC: bytes([ESC])}
        found.append(pieces[0] + b"".join(starts[piece[0]] + piece[1:] for piece in pieces[1:]))
    return [content for content in found if content]


def little_endian(words: Iterable[int], size: int) -> bytes:
    """Words as bytes, the lowest first."""
    mask = (1 << 8 * size) - 1
    return b"".join((int(word) & mask).to_bytes(size, "little") for word in words)
