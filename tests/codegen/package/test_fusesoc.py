"""The package in FuseSoC: simulation and lint of a fresh folder, without a network."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.codegen.package.made import DESIGNS, made
from tests.codegen.test_generate import change_word
from tests.marks import long
from tfra.sim.tools import choose, environment


@pytest.fixture(scope="module", params=["serial", *long("parallel", "ecp5", "ice40", "files")])
def package(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[str, Path]:
    name: str = request.param
    _, folder = made(name, tmp_path_factory.mktemp(name))
    return DESIGNS[name][0].name, folder


def fusesoc(target: str, name: str, package: Path, folder: Path, *options: str) -> subprocess.CompletedProcess[str]:
    """Run a target in ``folder``, which is empty, with a home of its own."""
    (folder / "tools").mkdir()
    variables = environment("verilator", folder / "tools") | {"HOME": str(folder), "XDG_CONFIG_HOME": str(folder)}
    program = str(Path(sys.executable).with_name("fusesoc"))
    words = [program, "--cores-root", str(package), "run", *options, "--target", target, f"tfra:core:{name}"]
    return subprocess.run(
        words, cwd=folder, env=variables, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False
    )


@pytest.mark.long
def test_sim_compares_every_word(package: tuple[str, Path], tmp_path: Path) -> None:
    choose("icarus")
    name, folder = package
    done = fusesoc("sim", name, folder, tmp_path)
    assert "words compared, 0 differ" in done.stdout, done.stdout
    assert done.returncode == 0


@pytest.mark.long
def test_sim_fails_for_a_wrong_word(package: tuple[str, Path], tmp_path: Path) -> None:
    name, folder = package
    file = folder / "testbench" / f"{name}_tb.v"
    text = file.read_text()
    change_word(folder, name, "result", 2, 1)
    try:
        done = fusesoc("sim", name, folder, tmp_path)
    finally:
        file.write_text(text)
    assert done.returncode != 0
    assert "FAILED" in done.stdout
    assert "1 differ" in done.stdout


def test_lint_finds_nothing(package: tuple[str, Path], tmp_path: Path) -> None:
    choose("verilator")
    name, folder = package
    done = fusesoc("lint", name, folder, tmp_path)
    assert done.returncode == 0, done.stdout
    assert "%Warning" not in done.stdout


def test_lint_fails_for_a_signal_without_driver(package: tuple[str, Path], tmp_path: Path) -> None:
    name, folder = package
    file = folder / f"{name}.v"
    text = file.read_text()
    file.write_text(text.replace("endmodule", "  wire open;\n  wire planted = open;\nendmodule", 1))
    try:
        done = fusesoc("lint", name, folder, tmp_path)
    finally:
        file.write_text(text)
    assert done.returncode != 0
    assert "UNDRIVEN" in done.stdout


def test_synthesis_is_set_up(package: tuple[str, Path], tmp_path: Path) -> None:
    """For the family's tool, which may not be here."""
    name, folder = package
    done = fusesoc("synth", name, folder, tmp_path, "--setup")
    assert done.returncode == 0, done.stdout
    assert any(f"{name}.v" in file.read_text(errors="replace") for file in tmp_path.rglob("*.*") if file.is_file())


def test_nothing_is_written_outside(package: tuple[str, Path], tmp_path: Path) -> None:
    before = sorted(package[1].rglob("*"))
    fusesoc("sim", *package, tmp_path, "--setup")
    assert sorted(package[1].rglob("*")) == before
    assert os.listdir(tmp_path)
