"""``tfra live``: every kind of source, what is said at the end, and one line for what is wrong."""

import json
import signal
import socket
import struct
import subprocess
import sys
import time
import urllib.error
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.cli.test_cli import refusal
from tests.cli.test_skin import SKIN
from tests.marks import long
from tests.view.made import unpacked, write
from tfra.cli.main import main

PATIENCE = 60.0


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("live")
    write(folder)
    np.savetxt(folder / "frames.csv", np.load(folder / "frames.npz")["frames"].reshape(24, -1), delimiter=",")
    return folder


@pytest.fixture
def folder(made: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder, with a CONFIG, frames and their results."""
    monkeypatch.chdir(made)
    return made


@dataclass(frozen=True)
class Live:
    """The command while it runs."""

    process: subprocess.Popen[bytes]
    address: str

    def asked(self, after: int = -1) -> dict[str, Any]:
        with urllib.request.urlopen(f"{self.address}frames?after={after}", timeout=PATIENCE) as answer:
            found: dict[str, Any] = json.loads(answer.readline())
            return found

    def until(self, **wanted: object) -> dict[str, Any]:
        """The answer that has all values ``wanted``."""
        end = time.monotonic() + PATIENCE
        while any((found := self.asked())[key] != value for key, value in wanted.items()):
            assert time.monotonic() < end, found | {"pieces": len(found["pieces"])}
            time.sleep(0.02)
        return found

    def ended(self) -> tuple[int, str, str]:
        """Press Ctrl-C: exit code and the last lines of both outputs."""
        self.process.send_signal(signal.SIGINT)
        out, err = self.process.communicate(timeout=PATIENCE)
        return self.process.returncode, out.decode(), err.decode()


@contextmanager
def live(source: str, *options: str) -> Iterator[Live]:
    arguments = [sys.executable, "-m", "tfra.cli", "live", "skin.toml", source, *options, "--port", "0"]
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    with subprocess.Popen(arguments, **pipes) as process:  # type: ignore[call-overload]  # by a dictionary
        try:
            line = process.stdout.readline().decode()
            assert line.endswith("; Ctrl-C ends it\n"), process.stderr.read()
            yield Live(process, line.split()[0])
        finally:
            process.kill()


def values(found: dict[str, Any], name: str) -> list[float]:
    return [value for piece in found["pieces"] for value in unpacked(piece["results"][0]["values"][name])]


def test_standard_input(folder: Path) -> None:
    """Frames are estimated as those of a file are; a line that is none is told, and the stream goes on."""
    with live("-") as running:
        stream = running.process.stdin
        assert stream is not None
        lines = (folder / "frames.csv").read_bytes().splitlines(keepends=True)
        stream.writelines([*lines[:10], b"1,2\n", *lines[10:]])
        stream.close()
        running.process.stdin = None
        found = running.until(state="ended", estimated=24)
        held = np.load(folder / "float.npz")
        np.testing.assert_allclose(values(found, "mu"), held["mu"], rtol=1e-6)
        np.testing.assert_allclose(values(found, "f_z"), held["resultant"][:, 2], rtol=1e-6)
        fault = "line 11: 24 numbers (4 rows x 6 columns) are needed, got 2"
        assert [found[key] for key in ("came", "malformed", "fault")] == [24, 1, fault]
        assert found["message"] == "standard input has ended."
        totals = "tfra live: 24 frames came, 24 were estimated, 0 drawn; malformed lines: 1\n"
        assert running.ended() == (0, totals, f"warning: standard input: {fault}\n")


@pytest.mark.parametrize("engine", ["c", *long("fixed")])
def test_a_connection_that_breaks(folder: Path, engine: str) -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        name = f"tcp://127.0.0.1:{server.getsockname()[1]}"
        with live(name, "--engine", engine) as running:
            peer = server.accept()[0]
            peer.sendall((folder / "frames.csv").read_bytes() + b"1e9" + b",1" * 23 + b"\n")
            found = running.until(estimated=24, malformed=1)
            assert found["message"] == f"Receiving frames from {name}."
            assert "line 25: row 0, column 0 is 1e+09 Pa, over the full scale of 200000 Pa" in found["fault"]
            np.testing.assert_allclose(values(found, "mu"), np.load(folder / "fixed.npz")["mu"], rtol=1e-6)
            peer.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
            peer.close()
            assert running.until(state="broken")["message"] == f"{name} broke: Connection reset by peer."


def test_a_recording(folder: Path) -> None:
    with live("frames.npz", "--rate", "1000") as running:
        found = running.until(state="ended", estimated=24)
        np.testing.assert_allclose(values(found, "mu"), np.load(folder / "float.npz")["mu"], rtol=1e-6)
        assert found["message"] == "frames.npz has ended."


def test_this_machine_alone_is_answered(folder: Path) -> None:
    with live("frames.npz") as running:
        port = running.address.split(":")[2].strip("/")
        with urllib.request.urlopen(running.address, timeout=PATIENCE) as page:
            assert "default-src 'none'" in page.headers["Content-Security-Policy"]
        for path, host, code in (("", "elsewhere.org", 403), ("no", None, 404), ("frames?after=x", None, 400)):
            request = urllib.request.Request(running.address + path, headers={"Host": host} if host else {})
            with pytest.raises(urllib.error.HTTPError) as caught:
                urllib.request.urlopen(request, timeout=PATIENCE)
            assert caught.value.code == code
        with socket.create_connection(("127.0.0.1", int(port))) as half:
            half.sendall(b"GET / HTTP/1.1\r\n")  # and no more
        sockets = [line.split() for line in Path("/proc/net/tcp").read_text().splitlines()]
        listening = [place for _, place, _, state, *_ in sockets if state == "0A"]
        assert [place for place in listening if place.endswith(f":{int(port):04X}")] == [f"0100007F:{int(port):04X}"]


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (["frames.npz", "--rate", "0"], "tfra live: --rate: more than 0 frames a second are needed, up to 1e6, got 0"),
        (["-", "--coding", "offset"], "tfra live: --coding: only codes have a coding: the unit must be codes, not Pa"),
        (["-", "--tare", "none.csv"], "none.csv: cannot be read: No such file or directory"),
        (["frames.npz", "--unit", "kPa", "--engine", "fixed"], "frames.npz: frames: frame 0, row 0, column "),
    ],
)
def test_what_is_wrong_is_told(
    folder: Path, capfd: pytest.CaptureFixture[str], arguments: list[str], line: str
) -> None:
    assert refusal(capfd, "live", "skin.toml", *arguments).startswith(line)


def test_a_port_in_use(folder: Path, capfd: pytest.CaptureFixture[str]) -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
        line = f"tfra live: --port: {port} is in use: choose another port, or 0 for any"
        assert refusal(capfd, "live", "skin.toml", "frames.npz", "--port", str(port)) == line


@pytest.mark.parametrize("engine", ["c", *long("float")])
def test_contacts_of_a_skin(engine: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """From a recording; each keeps its number."""
    monkeypatch.chdir(tmp_path)
    Path("skin.toml").write_text(SKIN)
    assert main(["frames", "skin.toml", "--out", "frames.npz"]) == 0
    with live("frames.npz", "--engine", engine) as running:
        found = running.until(state="ended", estimated=3)
        tracks = np.reshape(values(found, "track"), (3, -1))
        np.testing.assert_array_equal(tracks[:, :2], [[0, 1]] * 3)
        assert np.isnan(tracks[:, 2:]).all()
        np.testing.assert_allclose(np.reshape(values(found, "f_z"), (3, -1))[:, :2], [[-4, -2]] * 3, rtol=0.3)
        assert running.ended() == (0, "tfra live: 3 frames came, 3 were estimated, 0 drawn\n", "")
