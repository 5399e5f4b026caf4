"""A server of one page and of what it asks for, for browsers of this machine alone."""

from __future__ import annotations

import errno
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from urllib.parse import parse_qs, urlsplit

from tfra.model.errors import InputError
from tfra.view.feed import Feed

HOST = "127.0.0.1"

PATIENCE = 1.0
"""Seconds after which a page is answered, frames or not."""

_HEADERS = {
    "Cache-Control": "no-store",
    "Content-Security-Policy": (
        "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:; "
        "connect-src 'self'; frame-ancestors 'none'"
    ),
    "X-Content-Type-Options": "nosniff",
}
"""The page may load nothing, and ask nobody else."""


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
        raise InputError("tfra live", "--port", f"{port} {reason}: choose another one, or 0 for any") from None
    server.page, server.feed = page.encode(), feed
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
    """Connections that are kept get no more answers."""
    page: bytes
    feed: Feed

    def handle_error(self, request: object, client_address: object) -> None:
        """Nothing: a page that goes away in the middle of an answer is no error."""


class _Handler(BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"
    disable_nagle_algorithm = True
    server: _Server

    def do_GET(self) -> None:
        """Answer ``/``, and ``/frames?after=N&drawn=K``."""
        if self.server.over:
            self.close_connection = True
            return
        asked = urlsplit(self.path)
        if self.headers.get("Host") not in [f"{name}:{self.server.server_port}" for name in (HOST, "localhost")]:
            self._answer(HTTPStatus.FORBIDDEN, "text/plain", b"only this machine is answered\n")  # whoever sent it here
        elif asked.path == "/":
            self._answer(HTTPStatus.OK, "text/html", self.server.page)
        elif asked.path == "/frames":
            self._answer_frames(parse_qs(asked.query))
        else:
            self._answer(HTTPStatus.NOT_FOUND, "text/plain", b"there is no such page\n")

    def _answer_frames(self, query: dict[str, list[str]]) -> None:
        try:
            after, drawn = (int(query[key][0]) for key in ("after", "drawn"))
        except (KeyError, ValueError):
            self._answer(HTTPStatus.BAD_REQUEST, "text/plain", b"after=N and drawn=N are needed\n")
            return
        text = self.server.feed.since(after, max(0, drawn), PATIENCE)
        self._answer(HTTPStatus.OK, "application/json", text.encode())

    def _answer(self, status: HTTPStatus, kind: str, content: bytes) -> None:
        self.send_response(status)
        self.send_header("Content-Type", f"{kind}; charset=utf-8")
        self.send_header("Content-Length", str(len(content)))
        for name, value in _HEADERS.items():
            self.send_header(name, value)
        self.end_headers()
        self.wfile.write(content)

    def log_message(self, format: str, *arguments: object) -> None:
        """Nothing: requests are no news."""
