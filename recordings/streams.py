"""Streams of text: standard input, a connection, a serial port.  Their lines come as they are sent."""

import os
import re
import socket
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from urllib.parse import parse_qsl, urlsplit

from tfra.runtime.errors import InputError, quoted, require, shortened

STDIN = "-"

BAUD = 115_200

LONGEST = 1 << 20
"""Bytes of a line: no frame has as many."""

PATIENCE = 5.0
"""Seconds until a host that does not answer is not there."""

_CHUNK = 1 << 16
_SHAPES = "tcp://HOST:PORT or serial:/dev/NAME?baud=N"


@dataclass(frozen=True)
class Stream:
    """``read`` waits for bytes and returns them, none at the end; it raises ``OSError`` when the stream breaks.

    ``midway``: it has no beginning, so that its first line is a part of one.
    """

    name: str
    read: Callable[[], bytes]
    midway: bool = False

    def lines(self) -> Iterator[tuple[int, bytes]]:
        """The lines and their numbers, from 1; one longer than ``LONGEST`` comes in pieces, none of them a frame."""
        for number, line in enumerate(self._lines(), 1):
            if number > 1 or not self.midway:
                yield number, line

    def _lines(self) -> Iterator[bytes]:
        waiting = bytearray()  # grows in place: a long line may come byte by byte
        while data := self.read():
            first, *others = data.split(b"\n")
            waiting += first
            for other in others:
                yield bytes(waiting)
                waiting = bytearray(other)
            if len(waiting) > LONGEST:
                yield bytes(waiting)
                waiting = bytearray()
        if waiting:
            yield bytes(waiting)


def is_stream(source: str) -> bool:
    """Whether ``source`` names a stream; everything else is a file."""
    return source == STDIN or re.match("(tcp|serial):", source) is not None


def open_stream(source: str) -> Stream:
    """Open the stream that ``source`` names: ``-``, ``tcp://HOST:PORT`` or ``serial:DEVICE?baud=N``.

    Raises ``InputError`` for one that is not there, or that needs something to be installed.
    """
    if source == STDIN:
        return _standard_input()
    return _connection(source) if source.startswith("tcp:") else _serial_port(source)


def _standard_input() -> Stream:
    if sys.stdin is None or os.isatty(0):
        raise InputError("standard input", "", "is a terminal: pipe a program's output into it, one frame a line")
    # Not sys.stdin: a thread that waits in its buffer would keep Python from ending.
    return Stream("standard input", lambda: os.read(0, _CHUNK))


def _connection(source: str) -> Stream:
    try:
        parts = urlsplit(source)
        host, port = parts.hostname, parts.port
    except ValueError:
        host = port = None
    if not host or not port or source != f"tcp://{parts.netloc}":
        raise InputError(source, "", f"{_SHAPES} is needed")
    try:
        connection = socket.create_connection((host, port), PATIENCE)
    except (OSError, UnicodeError) as error:
        raise InputError(source, "", f"no connection: {reason(error)}") from None
    connection.settimeout(None)
    return Stream(source, lambda: connection.recv(_CHUNK))


def _serial_port(source: str) -> Stream:
    device, _, query = source.removeprefix("serial:").partition("?")
    baud = dict(parse_qsl(query, keep_blank_values=True)).get("baud", str(BAUD)) if query else str(BAUD)
    if not device or (query and query != f"baud={baud}"):
        raise InputError(source, "", f"{_SHAPES} is needed")
    if not (baud.isascii() and baud.isdigit() and 0 < int(baud[:9]) == int(baud)):
        raise InputError(source, "baud", f"a whole number is needed, got {quoted(baud)}")
    require(source, "live", "pyserial")
    import serial

    try:
        port = serial.Serial(device, int(baud), timeout=None)
    except (OSError, ValueError) as error:
        raise InputError(source, "", f"no serial port: {reason(error)}") from None
    return Stream(source, lambda: bytes(port.read(max(1, port.in_waiting))), midway=True)


def reason(error: Exception) -> str:
    """What the system says, without the words of libraries around it."""
    code = getattr(error, "errno", None)
    if isinstance(error, TimeoutError):
        return f"no answer within {PATIENCE:g} s"
    if isinstance(code, int) and code > 0:
        return os.strerror(code)
    return shortened(getattr(error, "strerror", None) or str(error), 120)
