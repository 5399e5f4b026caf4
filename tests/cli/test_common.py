"""What the commands show of long work where there is no terminal."""

import pytest

from tfra.cli import common
from tfra.cli.common import INTERVAL, progress


def test_lines_about_long_work(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    now = [0.0]
    monkeypatch.setattr(common.time, "monotonic", lambda: now[0])
    with progress("simulating the core") as advance:
        for seconds, done in ((INTERVAL - 1, 10), (INTERVAL, 20), (INTERVAL + 1, 5), (2 * INTERVAL, 15)):
            now[0] = seconds
            advance(done, 200)
    assert capsys.readouterr().err.splitlines() == [
        "simulating the core: 15 %, about 3 min left",
        "simulating the core: 25 %, about 3 min left",
    ]


def test_no_line_without_a_total_or_anything_done(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    now = [0.0]
    monkeypatch.setattr(common.time, "monotonic", lambda: now[0])
    for total, pieces in ((None, 5), (10, 0)):
        with progress("sizing the core", total) as advance:
            now[0] += 100 * INTERVAL
            advance(pieces)
    assert capsys.readouterr().err == ""
