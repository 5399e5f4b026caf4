"""Chromium without a window, driven over its debugging pipe: what a page shows, says and asks for."""

import json
import os
import shutil
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

OPTIONS = ("--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--remote-debugging-pipe")

PATIENCE = 60.0
"""Seconds until something that a page should do has not happened."""


@dataclass
class Browser:
    """One tab.  ``messages`` of its console and ``requests`` for anything but the page itself are those of the page."""

    commands: int
    answers: int
    session: str = ""
    messages: list[str] = field(default_factory=list)
    requests: list[str] = field(default_factory=list)
    loaded: bool = False
    _number: int = 0
    _waiting: bytes = b""

    def call(self, method: str, **parameters: Any) -> dict[str, Any]:
        """The answer to a command of Chromium's debugging protocol."""
        self._number += 1
        command: dict[str, Any] = {"id": self._number, "method": method, "params": parameters}
        if self.session:
            command["sessionId"] = self.session
        os.write(self.commands, json.dumps(command).encode() + b"\0")
        while True:
            answer = self._receive()
            if answer.get("id") == self._number:
                assert "error" not in answer, answer["error"]
                return dict(answer["result"])
            self._note(answer)

    def open(self, page: Path | str, width: int = 1280, height: int = 900) -> None:
        """Load a file, or what is at an address, in a window of this size."""
        self._load("about:blank")
        self.messages.clear()
        self.requests.clear()
        self.resize(width, height)
        self._load(page if isinstance(page, str) else page.as_uri())

    def resize(self, width: int, height: int = 900) -> None:
        """Give the window this size."""
        size = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False}
        self.call("Emulation.setDeviceMetricsOverride", **size)
        self.evaluate("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")

    def _load(self, url: str) -> None:
        self.loaded = False
        self.call("Page.navigate", url=url)
        while not self.loaded:
            self._note(self._receive())

    def evaluate(self, expression: str) -> Any:
        """The value of an expression, awaited where it is a promise."""
        answer = self.call("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        assert "exceptionDetails" not in answer, answer["exceptionDetails"]
        return answer["result"].get("value")

    def point(self, x: float, y: float) -> None:
        """Move the mouse to a place in the window."""
        for place in (x - 1, x):
            self.call("Input.dispatchMouseEvent", type="mouseMoved", x=place, y=y)

    def until(self, expression: str) -> Any:
        """Wait until an expression has a value that counts as true, and return it."""
        end = time.monotonic() + PATIENCE
        while not (value := self.evaluate(expression)):
            assert time.monotonic() < end, f"never true: {expression}"
            time.sleep(0.02)
        return value

    def _receive(self) -> dict[str, Any]:
        while b"\0" not in self._waiting:
            read = os.read(self.answers, 1 << 20)
            assert read, "chromium has ended"
            self._waiting += read
        answer, _, self._waiting = self._waiting.partition(b"\0")
        return dict(json.loads(answer))

    def _note(self, event: dict[str, Any]) -> None:
        parameters = event.get("params", {})
        match event.get("method"):
            case "Page.loadEventFired":
                self.loaded = True
            case "Runtime.consoleAPICalled":
                self.messages.append(" ".join(str(arg.get("value")) for arg in parameters["args"]))
            case "Runtime.exceptionThrown":
                self.messages.append(str(parameters["exceptionDetails"]))
            case "Log.entryAdded":
                self.messages.append(parameters["entry"]["text"])
            case "Network.requestWillBeSent" if parameters.get("type") != "Document":
                if not parameters["request"]["url"].startswith(("data:", "blob:")):
                    self.requests.append(parameters["request"]["url"])


@contextmanager
def browser(home: Path) -> Iterator[Browser]:
    """A browser that keeps its files in ``home``."""
    program = shutil.which("chromium")
    assert program, "chromium is missing, please run: sudo apt-get install chromium"
    (their_in, our_out), (our_in, their_out) = os.pipe(), os.pipe()
    # Chromium reads its descriptor 3 and writes its descriptor 4.
    script = f'exec "$@" 3<&{their_in} 4>&{their_out}'
    command = ["bash", "-c", script, "chromium", program, *OPTIONS, f"--user-data-dir={home / 'profile'}"]
    with subprocess.Popen(
        command,
        pass_fds=(their_in, their_out),
        env=os.environ | {"HOME": str(home)},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    ) as process:
        os.close(their_in)
        os.close(their_out)
        tab = Browser(our_out, our_in)
        try:
            target = tab.call("Target.createTarget", url="about:blank")["targetId"]
            tab.session = tab.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
            for domain in ("Page", "Runtime", "Log", "Network"):
                tab.call(f"{domain}.enable")
            tab.call("Emulation.setScrollbarsHidden", hidden=True)
            yield tab
        finally:
            process.terminate()
            os.close(our_in)
            os.close(our_out)
