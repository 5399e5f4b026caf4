"""The demonstration: what it prints, and that it fails when something is wrong."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from tfra.cli import demo
from tfra.model.tfra import Result
from tfra.model.truth import sentence
from tfra.paper.published import Contacts

EXAMPLE = """
[sensor]
rows = 4
columns = 4
pitch_x_mm = 4.0
pitch_y_mm = 4.0
thickness_mm = 3.0
[search]
steps = 10
[architecture]
mac_lanes = 4
[[contact]]
shape = "uniform"
half_x_mm = 3.0
half_y_mm = 2.0
force_n = -5.0
mu = 0.5
phi_deg = [0, 50]
"""


@pytest.fixture(autouse=True)
def cache(builds: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TFRA_CACHE", str(builds))


@pytest.mark.long
def test_demo(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    for name in demo.PRINTED:
        (tmp_path / f"{name}.toml").write_text(EXAMPLE)
    arguments = ["--simulator", "icarus", "--examples", str(tmp_path)]
    generous = {"force": 99.0, "mu": 99.0, "phi": 50.0}
    monkeypatch.setattr(demo, "PRINTED", dict.fromkeys(demo.PRINTED, generous))
    assert demo.main(arguments) == 0
    printed = capsys.readouterr().out
    said = " ".join(printed.split())
    assert "118 of 118 words compared on icarus, 0 differ; too few frames to measure the interval" in said
    assert "PASSED: every bit of the core equals the model; no error is larger than the paper's largest (" in said
    assert said.endswith(sentence())
    assert sum(line.split()[1:2] == ["reference"] for line in printed.splitlines()) == 2 * 2
    assert max(map(len, printed.splitlines())) <= demo.WIDTH
    assert "\N{HORIZONTAL ELLIPSIS}" not in printed
    monkeypatch.setattr(demo, "PRINTED", dict.fromkeys(demo.PRINTED, generous | {"force": 0.01}))
    assert demo.main(arguments) == 1
    said = " ".join(capsys.readouterr().out.split())
    assert "FAILED: hertz_40x20: an error is larger than the paper's largest; rect" in said
    assert demo.main(["--examples", str(tmp_path / "nowhere")]) == 2


def sensor(phi_deg: float = 359.99, force: float = -123.45) -> demo.Sensor:
    """A sensor whose numbers are as wide as they come: -123 N, 360 degrees, errors of 100 % and more."""
    n = 24
    resultant, zero = np.full((n, 3), force), np.zeros(n)
    truth = Contacts(resultant, np.full(n, 0.5), np.linspace(0, 345, n))
    found = Result(np.zeros((n, 3, 2, 2)), -resultant, np.full(n, phi_deg), zero + 3.999, zero, zero, zero, zero)
    words = np.zeros((n, 5), dtype=np.int64)
    run = SimpleNamespace(words=words, compared=words.size, interval=np.full(n - 1, 1500), simulator="verilator")
    return demo.Sensor("rectangle_40x40", truth, found, found, found, run, 0, 1500)


def test_no_number_is_too_wide() -> None:
    lines = demo.directions(sensor()) + demo.maxima([sensor()])
    assert max(map(len, lines)) <= demo.WIDTH
    body = [line for line in lines if line.startswith("      core")]
    assert len(body) == 24
    assert len({len(line) for line in body}) == 1  # columns are aligned


def test_every_column_by_hand() -> None:
    one = sensor()
    one.truth.resultant[:] = (3.0, 0.0, -4.0)
    found = replace(one.core, resultant=np.tile([3.0, 1.0, -4.0], (24, 1)), mu=np.full(24, 0.6))
    found = replace(found, phi_deg=np.full(24, 9.0))
    lines = demo.directions(replace(one, exact=found, core=found))
    start = next(n for n, line in enumerate(lines) if line.split()[:1] == ["0"])
    assert lines[start].split() == ["0", "reference", "3.00", "0.00", "-4.00", "0.500", "0.00"]
    assert lines[start + 2].split()[1:] == ["3.00", "1.00", "-4.00", "0.600", "9.00", "9.00", "0.100", "1.00", "20.00"]


def test_what_fails() -> None:
    perfect = sensor()
    good = replace(perfect, core=perfect.truth)
    assert good.failures == []
    assert good.measured_interval == 1500
    assert replace(good, differing=2).failures == ["rectangle_40x40: 2 of 120 words differ, 120 were compared"]
    assert replace(good, interval=1456).failures == ["rectangle_40x40: frames come every 1500 cycles, not 1456"]
    good.run.compared = 119
    assert good.failures == ["rectangle_40x40: 0 of 120 words differ, 119 were compared"]
    assert sensor().failures == ["rectangle_40x40: an error is larger than the paper's largest"]


def test_the_interval_is_that_of_a_full_pipeline() -> None:
    """Frames come in pairs here: a mean over an odd number of times is no interval."""
    one = sensor()
    one.run.interval[:] = [475, 2525] * 11 + [475]
    assert one.measured_interval == 1500
    assert "a frame every 1,500 cycles with the pipeline full (design: 1,500)" in demo.speed(one)
