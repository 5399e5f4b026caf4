"""``tfra calibrate`` from recordings to files, and what it refuses."""

import json
from pathlib import Path

import numpy as np
import pytest

from bench.accuracy.sensors import Day, Sensor
from tests.accessibility import faults_at_all_widths
from tests.browser import browser
from tests.cli.test_cli import refusal
from tfra.cli.main import main
from tfra.model.sensor import SensorArray

NOMINAL = SensorArray(6, 8, 3e-3, 3e-3, 3e-3)

CONFIG = """\
[sensor]
rows = 6
columns = 8
pitch_x_mm = 3
pitch_y_mm = 3
thickness_mm = 3
[adc]
bits = 12
full_scale_pa = {full_scale}
[input]
unit = "codes"
coding = "unipolar"
compression = "positive"
"""


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Day:
    sensor = Sensor(NOMINAL, np.random.default_rng(8))
    folder = tmp_path_factory.mktemp("day")
    day = sensor.day(folder, sensor.loads(16, 3))
    (folder / "sensor.toml").write_text(CONFIG.format(full_scale=sensor.pascals * 2**12))
    return day


def arguments(day: Day, out: Path, *more: str) -> list[str]:
    folder = day.table.parent
    files = map(str, day.files)
    return ["calibrate", str(folder / "sensor.toml"), *files, "--loads", str(day.table), "--out", str(out), *more]


def test_a_day_becomes_a_calibration_that_other_commands_use(
    recorded: Day, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "calibration"
    assert main(arguments(recorded, out)) == 0
    said = capsys.readouterr()
    assert "loads told the gains of" in said.out
    assert "the cover acts as one of" in said.out
    assert said.out.splitlines()[-1] == f'{out}: open index.html; [input] calibration = "{out}/cal.toml" uses it'
    for line in said.err.splitlines():
        assert line.startswith("warning: ")
    names = ["cal.toml", "front_end.h", "front_end.json", "index.html", "tfra-manifest.json"]
    assert sorted(file.name for file in out.iterdir()) == names
    assert main(arguments(recorded, out, "--json")) == 0
    summary = json.loads(capsys.readouterr().out)
    assert (summary["loads"], summary["taxels"]) == (19, 48)
    table = [line.split(",") for line in recorded.table.read_text().splitlines()[2:18]]
    forces = [float(cells[1]) for cells in table]
    largest = int(np.argmax(forces))
    config, press = recorded.table.parent / "sensor.toml", str(recorded.files[1 + largest])
    way = ["--order", summary["order"]]
    way += [f"--{'' if summary[key] else 'no-'}{key.replace('_', '-')}" for key in ("flip_x", "flip_y")]
    options = ["--calibration", str(out / "cal.toml"), "--tare-frames", "20", *way]
    assert main(["estimate", str(config), press, *options, "--out", str(tmp_path / "r.npz")]) == 0
    with np.load(tmp_path / "r.npz") as result:
        force = -result["stress"][40:70].sum(axis=(1, 2)).mean() * NOMINAL.taxel_area
    assert force == pytest.approx(forces[largest], rel=0.1)


def test_the_page_is_drawn(recorded: Day, tmp_path: Path) -> None:
    assert main(arguments(recorded, tmp_path / "out")) == 0
    with browser(tmp_path) as tab:
        tab.open(tmp_path / "out" / "index.html")
        assert tab.evaluate("document.querySelectorAll('section').length") == 6
        assert tab.evaluate("[...document.images].every(image => image.complete && image.naturalWidth > 300)")
        assert not faults_at_all_widths(tab)
        assert not tab.messages


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (lambda day: day.files.pop(), "loads.csv: line 21: recording: 'load18' is none of the recordings"),
        (lambda day: day.files.append(day.files[0].with_name("more.npy")), "recording: no row says what was done in"),
    ],
)
def test_recordings_and_rows_belong_together(
    recorded: Day, tmp_path: Path, change: object, reason: str, capsys: pytest.CaptureFixture[str]
) -> None:
    day = Day(recorded.array, [*recorded.files], recorded.table)
    change(day)
    assert reason in refusal(capsys, *arguments(day, tmp_path / "out"))
    assert not (tmp_path / "out").exists()
