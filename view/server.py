"""A server of one page and its data, for browsers on this machine only."""

import errno
import select
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from urllib.parse import parse_qs, urlsplit

from tfra.runtime.errors import InputError
from tfra.view.feed import Feed

HOST = "127.0.0.1"

PATIENCE = 1.0
"""Seconds after which a page gets the state, even without new frames."""

_HEADERS = {
    "Cache-Control": "no-store",
    "Content-Security-Policy": (
        "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:; "
        "connect-src 'self'; frame-ancestors 'none'"
    ),
    "X-Content-Type-Options": "nosniff",
}
"""The page may load nothing and contact no other server."""


@contextmanager
def serving(page: str, feed: Feed, port: int) -> Iterator[str]:
    """Serve ``page`` and ``feed`` within the block; yields the address.  Port 0 is any that is free.

    Raises ``InputError`` for a port that cannot be had.
    """
    try:
        server = _Server((HOST, port), _Handler)
    except (OSError, OverflowError) as error:
        taken = isinstance(error, OSError) and error.errno == errno.EADDRINUSE
        reason = "is in use" if taken else f"cannot be used: {getattr(error, 'strerror', None) or error}"
        raise InputError("tfra live", "--port", f"{port} {reason}: choose another port, or 0 for any") from None
    server.page, server.feed = page.encode(errors="backslashreplace"), feed
    thread = threading.Thread(target=server.serve_forever, args=(0.05,), daemon=True)
    thread.start()
    try:
        yield f"http://{HOST}:{server.server_port}/"
    finally:
        server.over = True
        server.shutdown()
        server.server_close()


class _Server(ThreadingHTTPServer):
    daemon_threads = True
    block_on_close = False
    over = False
    """Pages get nothing more."""
    page: bytes
    feed: Feed

    def handle_error(self, request: object, client_address: object) -> None:
        """Ignore a page that closes in the middle of an answer."""


class _Handler(BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"
    disable_nagle_algorithm = True
    server: _Server

    def do_POST(self) -> None:
        """Answer ``/tare``, which asks for a new one, of the server's own page alone."""
        self.close_connection = True  # what else was sent is not read
        tare = self.server.feed.tare
        if self._is_of_elsewhere():
            return
        if self.path != "/tare" or tare is None:
            self._answer(HTTPStatus.NOT_FOUND, "text/plain", b"there is no tare to take\n")
            return
        tare.again()
        self._answer(HTTPStatus.OK, "text/plain", tare.told.encode())

    def _is_of_elsewhere(self) -> bool:
        """Whether the request is not for this machine, or of another page, and has been refused."""
        hosts = [f"{name}:{self.server.server_port}" for name in (HOST, "localhost")]
        host, origin = (self.headers.get(name) for name in ("Host", "Origin"))
        if host in hosts and origin in (None, f"http://{host}"):
            return False
        self._answer(HTTPStatus.FORBIDDEN, "text/plain", b"only this machine is served\n")  # whoever sent it here
        return True

    def do_GET(self) -> None:
        """Answer ``/``, ``/frames?after=N``, lines of JSON until the source ends, and ``/drawn?count=N``."""
        asked = urlsplit(self.path)
        number = {"/frames": "after", "/drawn": "count"}.get(asked.path)
        if self._is_of_elsewhere():
            return
        if asked.path == "/":
            self._answer(HTTPStatus.OK, "text/html", self.server.page)
        elif number is None:
            self._answer(HTTPStatus.NOT_FOUND, "text/plain", b"there is no such page\n")
        else:
            try:
                value = int(parse_qs(asked.query)[number][0])
            except (KeyError, ValueError):
                self._answer(HTTPStatus.BAD_REQUEST, "text/plain", f"{number}=N is needed\n".encode())
                return
            (self._send_frames if number == "after" else self._count)(value)

    def _count(self, drawn: int) -> None:
        self.server.feed.count_drawn(max(0, drawn))
        self._answer(HTTPStatus.OK, "text/plain", b"")

    def _send_frames(self, after: int) -> None:
        """Send lines until the source or the server ends, or the page is gone; it goes when it has drawn the last."""
        self.close_connection = True
        self._head(HTTPStatus.OK, "application/x-ndjson", {"Connection": "close"})
        over = False
        with self.server.feed.reading() as shown:
            while not (over or self.server.over):
                text, after, over = self.server.feed.since(after, PATIENCE)
                if self._is_left(0):
                    return
                self.wfile.write(f"{text}\n".encode())
            if over:
                self._is_left(PATIENCE)
                shown()

    def _is_left(self, patience: float) -> bool:
        """Whether the page has closed the connection, or does so within ``patience`` seconds: nothing else comes."""
        return bool(select.select([self.connection], [], [], patience)[0])

    def _answer(self, status: HTTPStatus, kind: str, content: bytes) -> None:
        self._head(status, kind, {"Content-Length": str(len(content))})
        self.wfile.write(content)

    def _head(self, status: HTTPStatus, kind: str, more: dict[str, str]) -> None:
        self.send_response(status)
        self.send_header("Content-Type", f"{kind}; charset=utf-8")
        for name, value in (_HEADERS | more).items():
            self.send_header(name, value)
        self.end_headers()

    def log_message(self, format: str, *arguments: object) -> None:
        """Log no requests."""
