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
from tests.recordings.test_log import ARRAY, array, mcap
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

    def posted(self, path: str, **headers: str) -> str:
        request = urllib.request.Request(self.address + path, method="POST", headers=headers)
        with urllib.request.urlopen(request, timeout=PATIENCE) as answer:
            return str(answer.read().decode())

    def ended(self) -> tuple[int, str, str]:
        """Press Ctrl-C: exit code and the last lines of both outputs."""
        self.process.send_signal(signal.SIGINT)
        out, err = self.process.communicate(timeout=PATIENCE)
        return self.process.returncode, out.decode(), err.decode()


@contextmanager
def live(source: str, *options: str, stay: bool = True) -> Iterator[Live]:
    options = (*options, "--port", "0", *["--stay"][: int(stay)])
    arguments = [sys.executable, "-m", "tfra.cli", "live", "skin.toml", source, *options]
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
        code, out, err = running.ended()
        assert (code, err) == (0, f"warning: standard input: {fault}\n")
        assert out.endswith(totals)


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
        (["frames.npz", "--out", "frames.npz"], "frames.npz: is not replaced: this command reads it: choose another"),
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
    with live("frames.npz", "--engine", engine, "--out", "kept.npz") as running:
        found = running.until(state="ended", estimated=3)
        tracks = np.reshape(values(found, "track"), (3, -1))
        np.testing.assert_array_equal(tracks[:, :2], [[0, 1]] * 3)
        assert np.isnan(tracks[:, 2:]).all()
        np.testing.assert_allclose(np.reshape(values(found, "f_z"), (3, -1))[:, :2], [[-4, -2]] * 3, rtol=0.3)
        totals = "tfra live: 3 frames came, 3 were estimated, 0 drawn\n"
        code, out, err = running.ended()
        assert (code, err) == (0, "")
        assert out.endswith(f"{totals}kept.npz: 3 frames by the {engine} engine\n")
    assert np.load("kept.npz")["track"].tolist() == [0, 1] * 3
    assert main(["view", "kept.npz", "--out", "kept.html"]) == 0


def test_it_ends_when_a_page_has_the_last_frame(folder: Path) -> None:
    with live("frames.npz", "--rate", "1000", stay=False) as running:
        assert running.process.stdout is not None
        assert running.process.stdout.readline() == b"frames.npz has ended; a page or Ctrl-C ends the command\n"
        with urllib.request.urlopen(f"{running.address}frames?after=-1", timeout=PATIENCE) as page:
            numbers = []
            while not (found := json.loads(page.readline()))["over"]:
                numbers += [number for piece in found["pieces"] for number in unpacked(piece["numbers"])]
        assert numbers == list(range(24))
        out, err = running.process.communicate(timeout=PATIENCE)
        assert (running.process.returncode, err) == (0, b"")
        assert out == b"tfra live: 24 frames came, 24 were estimated, 0 drawn\n"


@pytest.mark.parametrize("suffix", [".npz", ".csv"])
def test_what_is_estimated_is_kept(folder: Path, capfd: pytest.CaptureFixture[str], suffix: str) -> None:
    """Without a page, the command ends with its source; the file is that of ``tfra estimate``, with the times."""
    out = f"kept{suffix}"
    arguments = ["live", "skin.toml", "frames.npz", "--rate", "1000", "--port", "0"]
    assert main([*arguments, "--out", out]) == 0
    assert capfd.readouterr().out.splitlines()[-1] == f"{out}: 24 frames by the float engine"
    assert main(["estimate", "skin.toml", "frames.npz", "--out", f"all{suffix}"]) == 0
    if suffix == ".npz":
        kept, known = np.load(out), np.load("all.npz")
        assert set(kept) == {*known, "time"}
        for name in set(known) - {"engine", "config"}:  # products of other batches are rounded otherwise
            np.testing.assert_allclose(kept[name], known[name], rtol=1e-9, atol=1e-12)
        assert [str(kept[name]) for name in ("engine", "config")] == [str(known[name]) for name in ("engine", "config")]
        assert kept["time"][0] == 0
        assert (np.diff(kept["time"]) > 0).all()
        assert main(["view", out, "--out", "kept.html"]) == 0
    else:
        kept, known = (np.loadtxt(f"{name}/forces.csv", delimiter=",", skiprows=1) for name in (out, "all.csv"))
        np.testing.assert_allclose(kept, known, rtol=1e-9, atol=1e-12)
        assert (folder / out / "frames.csv").read_text().startswith("frame,time_s,phi_deg,")


def test_a_topic_of_a_log(folder: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """At the log's own rate; the result has the topic's frames alone."""
    frames = np.load("frames.npz")["frames"].astype(np.float32)
    sent = [("/skin", frames[0], 0), ("/other", -frames[1], 1), ("/skin", frames[2], 20_000_000)]
    mcap(folder / "log.mcap", [(topic, ARRAY, time, array(frame)) for topic, frame, time in sent])
    arguments = ["live", "skin.toml", "log.mcap", "--port", "0", "--out", "topic.npz"]
    assert refusal(capfd, *arguments).endswith("several topics hold frames, which one? (--topic): /other, /skin")
    assert main([*arguments, "--topic", "/skin"]) == 0
    kept = np.load("topic.npz")
    np.testing.assert_array_equal(kept["stress"], frames[[0, 2]])
    assert kept["time"][1] > 0


def test_ctrl_c_keeps_what_was_estimated(folder: Path) -> None:
    with live("-", "--out", "half.npz", stay=False) as running:
        assert running.process.stdin is not None
        running.process.stdin.writelines((folder / "frames.csv").read_bytes().splitlines(keepends=True)[:10])
        running.process.stdin.flush()
        running.until(estimated=10)
        totals = "tfra live: 10 frames came, 10 were estimated, 0 drawn\nhalf.npz: 10 frames by the float engine\n"
        assert running.ended() == (0, totals, "")
    np.testing.assert_allclose(np.load("half.npz")["mu"], np.load("float.npz")["mu"][:10], rtol=1e-9)


def test_a_new_tare(folder: Path) -> None:
    with live("-", "--tare-frames", "1", stay=False) as running:
        stream = running.process.stdin
        assert stream is not None
        frames = np.load("frames.npz")["frames"]

        def send(*sent: np.ndarray) -> None:
            stream.writelines(f"{','.join(map(repr, frame.ravel().tolist()))}\n".encode() for frame in sent)
            stream.flush()

        send(np.zeros((4, 6)), frames[0])
        assert running.until(estimated=1)["tare"] == "Tare: the mean of 1 frames."
        elsewhere = {"Origin": "http://elsewhere.org"}, {"Host": "elsewhere.org"}
        for path, headers, code in (*(("tare", headers, 403) for headers in elsewhere), ("no", {}, 404)):
            with pytest.raises(urllib.error.HTTPError) as caught:
                running.posted(path, **headers)
            assert caught.value.code == code
        own = {"Origin": running.address.rstrip("/")}
        assert running.posted("tare", **own) == "Tare: keep the array at rest."
        send(np.full((4, 6), 1e3), frames[0] + 1e3)
        mu = values(running.until(estimated=2), "mu")
        np.testing.assert_allclose(mu, np.load("float.npz")["mu"][[0, 0]], rtol=1e-6)


def test_a_recording_has_no_new_tare(folder: Path) -> None:
    with live("frames.npz", "--rate", "1000") as running:
        assert "tare" not in running.asked()
        with pytest.raises(urllib.error.HTTPError, match="404"):
            running.posted("tare")
