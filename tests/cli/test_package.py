"""``tfra generate --package``: the folder, and answers to names and places that it can't have."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from tfra.cli.main import main
from tfra.codegen.config.read import load
from tfra.codegen.package.contents import Part
from tfra.codegen.package.drivers import C_FILES, PYTHON_FILES
from tfra.codegen.sidecar.build import sidecar
from tfra.families import find

CONFIG = """
[sensor]
rows = 2
columns = 2
pitch_x_mm = 4.0
pitch_y_mm = 4.0
thickness_mm = 3.0

[search]
steps = 3

[architecture]
kind = "serial"
"""

WIDE = """
[adc]
bits = 16

[formats]
force_fraction_bits = 16
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    Path("skin.toml").write_text(CONFIG)
    return tmp_path


def files(folder: Path) -> set[str]:
    return {str(file.relative_to(folder)) for file in folder.rglob("*") if file.is_file()}


def test_the_package_has_more_than_the_core(folder: Path) -> None:
    assert main(["generate", "skin.toml", "--out", "core"]) == 0
    assert main(["generate", "skin.toml", "--out", "package", "--package"]) == 0
    core, package = files(folder / "core"), files(folder / "package")
    assert core == {"skin.v", "skin.json", "coefficients/load.hex", "testbench/skin_tb.v", "tfra-manifest.json"}
    for name in core - {"tfra-manifest.json"}:
        assert (folder / "core" / name).read_bytes() == (folder / "package" / name).read_bytes(), name
    assert package - core == {
        *("LICENSE", "CHANGELOG.md", "errata.md"),
        *("README.md", "datasheet.html", "skin.toml", "skin.core", "constraints/skin.sdc", "litex/skin.py"),
        *("skin_axi.v", "testbench/skin_axi_tb.v", "core.schema.json", "vivado/package_ip.tcl", "vivado/skin_axi.xdc"),
        *("driver/tfra_constants.h", "driver/show.h", "python/example.py"),
        *(f"driver/{name}" for name in ("skin_config.h", "skin_coefficients.h", "skin_recorded.h", *C_FILES)),
        *(f"python/{name}" for name in ("tfra_host/constants.json", *PYTHON_FILES)),
        *("registers/tfra.h", "registers/tfra.html", "skin_axi.xml", "skin_axi.vhd", "skin_async.v"),
        *(f"netlist/{name}" for name in ("prepare.py", "place.py", "nextpnr.py", "skin_axi_pins.v")),
        *("boards/talk.py", "boards/line.json"),
        *("boards/ulx3s/top.v", "boards/ulx3s/ulx3s.lpf", "boards/ulx3s/build.sh"),
    }
    hashes = [sidecar(load(file).design)["configuration_sha256"] for file in (folder / "package").glob("*.toml")]
    assert hashes == [json.loads((folder / "package" / "skin.json").read_text())["configuration_sha256"]]
    errata = (folder / "package" / "errata.md").read_text()
    assert "## In this core\n\nNone is known.\n" in errata
    assert errata.count("- **") == 4
    assert "Apache License" in (folder / "package" / "LICENSE").read_text()
    lines = (folder / "package" / "README.md").read_text().splitlines()
    listed = {line.split("`")[1] for line in lines if line.startswith("| `")}
    assert listed <= package
    for name in package:
        assert str(folder) not in (folder / "package" / name).read_text(), name


def test_a_core_that_fits_no_part_is_warned_of(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    target = find("ecp5-25")
    full = {name: (have, have) for name, have in target.available.items()}
    more = full | {"LUT": (30000, target.available["LUT"])}
    monkeypatch.setattr("tfra.synth.estimate.part_of", lambda design: Part(target, more, "a guess"))
    monkeypatch.setattr("tfra.codegen.generate.generate", lambda *_: {"name": "skin"})
    assert main(["generate", "skin.toml", "--out", "package", "--package"]) == 0
    lack = f"LUT: about 30,000 are needed, {target.name} has {target.available['LUT']:,}"
    assert capsys.readouterr().err == f"warning: skin.toml: {lack}\n"
    monkeypatch.setattr("tfra.synth.estimate.part_of", lambda design: Part(target, full, "a guess"))
    assert main(["generate", "skin.toml", "--out", "package", "--package"]) == 0
    assert capsys.readouterr().err == ""


@pytest.mark.long
def test_same_bytes_whatever_the_hash_seed(folder: Path) -> None:
    for seed in ("1", "2"):
        command = [sys.executable, "-m", "tfra.cli", "generate", "skin.toml", "--out", seed, "--package"]
        subprocess.run(command, check=True, env={"PYTHONHASHSEED": seed}, capture_output=True)
    assert files(folder / "1") == files(folder / "2")
    for name in files(folder / "1"):
        assert (folder / "1" / name).read_bytes() == (folder / "2" / name).read_bytes(), name


@pytest.mark.parametrize(
    ("name", "section", "reason"),
    [
        ("signal", "", 'name: "signal" is a keyword of VHDL, which a package is used in'),
        ("../up", "", "name: a letter, then at most 62 letters, digits and underscores are needed, got '../up'"),
        ("skin", "[adc]\nbits = 7", "adc.bits: 8 to 16 are supported with the front end, got 7"),
        ("skin", WIDE, "formats: result words of 32 bits at most fit behind AXI, got "),
        ("skin", "[bus]\ntaxels_per_beat = 3", "bus.taxels_per_beat: "),
    ],
)
def test_what_does_not_fit_is_refused_in_a_line(
    folder: Path, name: str, section: str, reason: str, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("skin.toml").write_text(f'name = "{name}"\n{CONFIG}\n{section}\n')
    assert main(["generate", "skin.toml", "--out", "package", "--package"]) == 2
    error = capsys.readouterr().err
    assert error.startswith(f"skin.toml: {reason}")
    assert error.count("\n") == 1
    assert [file.name for file in folder.iterdir()] == ["skin.toml"]
