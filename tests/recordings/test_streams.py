"""Streams of text: their lines, and what is said of those that are not there."""

import os
import socket
import threading
from collections.abc import Iterator

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tfra.recordings.streams import LONGEST, Stream, is_stream, open_stream
from tfra.runtime.errors import InputError


def stream_of(*pieces: bytes, midway: bool = False) -> Stream:
    waiting = iter(pieces)
    return Stream("here", lambda: next(waiting, b""), midway)


@given(st.lists(st.binary(max_size=9).filter(lambda line: b"\n" not in line)), st.integers(1, 7))
def test_lines_do_not_depend_on_how_they_come(lines: list[bytes], size: int) -> None:
    text = b"".join(line + b"\n" for line in lines)
    pieces = [text[at : at + size] for at in range(0, len(text), size)]
    assert list(stream_of(*pieces).lines()) == list(enumerate(lines, 1))


def test_the_last_line_needs_no_end_and_a_stream_without_a_beginning_has_no_first_line() -> None:
    assert list(stream_of(b"1\n2").lines()) == [(1, b"1"), (2, b"2")]
    assert list(stream_of(b"1\n2\n3", midway=True).lines()) == [(2, b"2"), (3, b"3")]
    assert list(stream_of(midway=True).lines()) == []


def test_a_line_without_end_is_not_kept() -> None:
    found = list(stream_of(*[bytes(LONGEST // 2)] * 5, b"\n1\n").lines())
    assert [len(line) for _, line in found] == [3 * LONGEST // 2, LONGEST, 1]


@pytest.mark.parametrize("name", ["-", "tcp://host:1", "serial:/dev/ttyACM0"])
def test_names_of_streams(name: str) -> None:
    assert is_stream(name)
    assert not is_stream(f"./{name}")


@pytest.fixture
def listening() -> Iterator[tuple[socket.socket, int]]:
    with socket.create_server(("127.0.0.1", 0)) as server:
        yield server, server.getsockname()[1]


def test_a_connection(listening: tuple[socket.socket, int]) -> None:
    server, port = listening

    def send() -> None:
        with server.accept()[0] as peer:
            peer.sendall(b"1,2\n3")
            peer.sendall(b",4\n")

    threading.Thread(target=send, daemon=True).start()
    stream = open_stream(f"tcp://127.0.0.1:{port}")
    assert stream.name == f"tcp://127.0.0.1:{port}"
    assert list(stream.lines()) == [(1, b"1,2"), (2, b"3,4")]


def test_a_serial_port() -> None:
    ours, theirs = os.openpty()
    stream = open_stream(f"serial:{os.ttyname(theirs)}?baud=9600")
    os.write(ours, b"art of a line\n1,2\n3,4\n")
    lines = stream.lines()
    assert [next(lines), next(lines)] == [(2, b"1,2"), (3, b"3,4")]
    os.close(theirs)
    os.close(ours)
    with pytest.raises(OSError, match=r"Input/output error|disconnected"):
        next(lines)


def refused(source: str) -> str:
    with pytest.raises(InputError) as caught:
        open_stream(source)
    return str(caught.value)


@pytest.mark.parametrize(
    "source", ["tcp://host", "tcp://:5", "tcp://host:x", "tcp:host:5", "tcp://host:5/a", "tcp://host:99999", "serial:"]
)
def test_addresses_that_are_none(source: str) -> None:
    assert refused(source) == f"{source}: tcp://HOST:PORT or serial:/dev/NAME?baud=N is needed"


def test_what_is_not_there(listening: tuple[socket.socket, int], monkeypatch: pytest.MonkeyPatch) -> None:
    server, port = listening
    server.close()
    assert refused(f"tcp://127.0.0.1:{port}") == f"tcp://127.0.0.1:{port}: no connection: Connection refused"
    assert refused("serial:/dev/nobody") == "serial:/dev/nobody: no serial port: No such file or directory"
    assert refused("serial:/dev/nobody?baud=x") == "serial:/dev/nobody?baud=x: baud: a whole number is needed, got 'x'"
    monkeypatch.setattr("tfra.runtime.errors.find_spec", lambda name: None)
    line = "serial:/dev/nobody: pyserial is missing, please run: pip install 'tfra[live]'"
    assert refused("serial:/dev/nobody") == line
    monkeypatch.setattr(os, "isatty", lambda descriptor: True)
    assert refused("-") == "standard input: is a terminal: pipe a program's output into it, one frame a line"
