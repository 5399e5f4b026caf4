"""``tfra study`` as it is typed: what it prints, on a terminal and without one, and the page that it makes."""

import json
import os
import pty
import subprocess
import sys
from pathlib import Path

import polars as pl
import pytest

from tests.accessibility import faults_at_all_widths
from tests.browser import browser
from tests.study.definitions import ONE_MIXTURE

ROOT = Path(__file__).parents[2]
QUICK = ROOT / "examples" / "study_quick.toml"

SHORT = f"""
config = "skin.toml"
[frames]
train = 300
held_out = 100
{ONE_MIXTURE}[uniform]
bits = [8, 18]
"""
CONFIG = """
[sensor]
rows = 4
columns = 6
pitch_x_mm = 5.0
pitch_y_mm = 3.0
thickness_mm = 2.0
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "skin.toml").write_text(CONFIG)
    (tmp_path / "study.toml").write_text(SHORT)
    return tmp_path


def command(folder: Path, *more: str) -> list[str]:
    study, out = folder / "study.toml", folder / "report"
    return [sys.executable, "-m", "tfra.cli", "study", str(study), "--out", str(out), "--workers", "1", *more]


@pytest.mark.long
def test_without_a_terminal_each_task_is_a_line(folder: Path) -> None:
    done = subprocess.run(command(folder, "--json"), capture_output=True, text=True, check=True)
    tasks = [line.partition(":")[0] for line in done.stderr.splitlines()]
    assert tasks == ["frames", "errors", "signals", "uniform"]
    told = json.loads(done.stdout)
    assert (told["out"], told["designs"]) == (f"{folder}/report", [])
    again = subprocess.run(command(folder), capture_output=True, text=True, check=True)
    assert again.stderr.splitlines()[0] == "frames: 2 blocks, 2 from an earlier run"
    assert again.stdout.startswith("Asked: how many bits does skin need (4×6 taxels, 14-bit converter, ")


@pytest.mark.long
def test_a_terminal_shows_rate_and_time_left(folder: Path) -> None:
    master, slave = pty.openpty()
    with subprocess.Popen(command(folder), stdout=slave, stderr=slave, env={**os.environ, "COLUMNS": "120"}) as run:
        os.close(slave)
        shown = bytearray()
        while True:
            try:
                part = os.read(master, 4096)
            except OSError:  # the other end has gone
                break
            if not part:
                break
            shown += part
    os.close(master)
    assert run.returncode == 0
    text = shown.decode()
    for word in ("frames", "uniform", "1/1", "job", "left:"):
        assert word in text


@pytest.mark.long
def test_the_quick_example(tmp_path: Path) -> None:
    """Charts are drawn from tables that say the same as the summary; nothing is loaded, nothing complains."""
    arguments = ["study", str(QUICK), "--out", str(tmp_path / "report"), "--json"]
    done = subprocess.run([sys.executable, "-m", "tfra.cli", *arguments], capture_output=True, text=True, check=True)
    told = json.loads(done.stdout)
    designs = pl.read_parquet(tmp_path / "report" / "tables" / "designs.parquet")
    assert told["designs"] == designs.rows(named=True)
    assert designs.filter(name="least_coefficient_kbit").select("rtl_frames", "rtl_differ").row(0) == (4, 0)
    with browser(tmp_path) as tab:
        tab.open(tmp_path / "report" / "index.html")
        drawn = "[...document.querySelectorAll('figure > div')].map(each => (each.data || []).length)"
        assert min(tab.evaluate(drawn)) >= 1
        assert tab.messages == []
        assert tab.requests == []
        tab.open(tmp_path / "report" / "times.html")
        assert faults_at_all_widths(tab) == []
