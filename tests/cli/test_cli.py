"""The command line: exit codes, one line for bad input, files, and what is printed."""

import json
import re
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.cli.misuse.cases import CONFIG as SKIN
from tfra.cli.main import main
from tfra.codegen.config.read import load
from tfra.model.tfra import Tfra
from tfra.model.two_variable import TwoVariable
from tfra.recordings.results import KEYS
from tfra.sim.report import Report, Timing
from tfra.sim.run import SimulationError

ROOT = Path(__file__).parents[2]
HERTZ = str(ROOT / "examples" / "hertz_40x20.toml")

CONFIG = SKIN.replace("[[contact]]", "[search]\nplateau_tolerance = 3\n[[contact]]")


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder, with a CONFIG and its frames."""
    monkeypatch.chdir(tmp_path)
    Path("skin.toml").write_text(CONFIG)
    assert main(["frames", "skin.toml", "--out", "frames.npz"]) == 0
    return tmp_path


def refusal(capfd: pytest.CaptureFixture[str], *arguments: str) -> str:
    """Run a command that must be refused, and return its line on stderr."""
    before = sorted(Path().rglob("*"))
    capfd.readouterr()
    assert main(arguments) == 2
    out, err = capfd.readouterr()
    assert out == ""
    assert err.endswith("\n")
    assert err.count("\n") == 1
    assert sorted(Path().rglob("*")) == before
    return err[:-1]


# Help


def test_version(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--version"]) == 0
    assert capsys.readouterr().out == f"tfra {version('tfra')}\n"


@pytest.mark.parametrize("arguments", [[], ["--help"]])
def test_help_lists_the_commands_and_an_example(capsys: pytest.CaptureFixture[str], arguments: list[str]) -> None:
    assert main(arguments) == 0
    text = capsys.readouterr().out
    for command in ("frames", "estimate", "view", "live", "generate", "verify", "synth", "paper", "study", "train"):
        assert f"│ {command} " in text
    assert "tfra frames examples/hertz_40x20.toml --out frames.npz" in text


# frames


def test_frames(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with np.load("frames.npz") as found:
        assert found["frames"].shape == (3, 5, 6)
        assert found["frames"].min() < -1e4
        np.testing.assert_array_equal(found["phi_ref_deg"], [0, 45, 120])
        np.testing.assert_array_equal(found["mu_ref"], [0.4, 0.4, 0.4])
        expected = [[2, 0, -5], [2**0.5, 2**0.5, -5], [-1, 3**0.5, -5]]
        np.testing.assert_allclose(found["resultant_ref"], expected, atol=1e-12)
        np.testing.assert_allclose(found["contact_center"], [[0.01, 0.008]] * 3)
        np.testing.assert_allclose(found["contact_half"], [[0.005, 0.004]] * 3)
        assert found["contact_shape"].tolist() == ["hertz"] * 3
    capsys.readouterr()
    assert main(["frames", "skin.toml", "--out", "again.npz", "--json"]) == 0
    assert Path("again.npz").read_bytes() == Path("frames.npz").read_bytes()
    summary = json.loads(capsys.readouterr().out)
    assert summary["frames"] == 3
    assert summary["full_scale_pa"] == 200e3
    assert summary["out"] == "again.npz"


def test_frames_tells_when_they_exceed_full_scale(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    Path("weak_cover.toml").write_text(CONFIG + "[adc]\nfull_scale_pa = 1000\n")
    capsys.readouterr()
    assert main(["frames", "weak_cover.toml", "--out", "weak_cover.npz"]) == 0
    assert "Pa which exceeds 1000 Pa full scale" in capsys.readouterr().out


# estimate


def test_estimate(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    capsys.readouterr()
    assert main(["estimate", "skin.toml", "frames.npz", "--out", "result.npz", "--json"]) == 0
    summary = json.loads(capsys.readouterr().out)
    design = load("skin.toml").design
    expected = Tfra(design.sensor, 100, 3 * design.adc.lsb)(np.load("frames.npz")["frames"])
    with np.load("result.npz") as found:
        keys = ["forces", "resultant", "phi_deg", "mu", "mu_x", "mu_y", "sweep_index", "status"]
        assert found.files == [*keys, "stress", "engine", "config"]
        np.testing.assert_array_equal(found["stress"], np.load("frames.npz")["frames"])
        assert found["engine"][()] == "float"
        for key in keys:
            np.testing.assert_array_equal(found[key], getattr(expected, key))
        assert summary["resultant_n"] == found["resultant"].tolist()
        assert summary["phi_deg"] == found["phi_deg"].tolist()
    assert summary["frames"] == 3
    assert summary["status"]["NO_CONTACT"] == 0


def test_a_result_names_the_dead_taxels(folder: Path) -> None:
    assert main(["estimate", "skin.toml", "frames.npz", "--dead", "1,2", "--out", "result.npz"]) == 0
    with np.load("result.npz") as found:
        assert np.argwhere(found["dead"]).tolist() == [[1, 2]]
        assert found["dead"].shape == found["stress"].shape[1:]


def test_estimate_by_the_two_variable_search(folder: Path) -> None:
    assert main(["estimate", "skin.toml", "frames.npz", "--engine", "two-variable", "--out", "result.npz"]) == 0
    expected = TwoVariable(load("skin.toml").design.sensor)(np.load("frames.npz")["frames"])
    with np.load("result.npz") as found:
        assert found["sweep_index"].tolist() == [-1, -1, -1]
        for key in KEYS:
            np.testing.assert_array_equal(found[key], getattr(expected, key))


def test_estimate_by_the_simulated_core(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from tfra.model.fixed.tfra.pipeline import FixedTfra

    monkeypatch.setattr("tfra.sim.run.simulate", lambda design, codes, progress: FixedTfra(design)(codes))
    for engine in ("fixed", "rtl"):
        command = ["estimate", "skin.toml", "frames.npz", "--engine", engine, "--out", f"{engine}.npz"]
        assert main(command) == 0
    with np.load("rtl.npz") as rtl, np.load("fixed.npz") as fixed:
        assert {key for key in rtl.files if rtl[key].tobytes() != fixed[key].tobytes()} == {"engine"}
    assert capsys.readouterr().out.endswith("rtl engine, from codes of the 14-bit converter, 24.4141 Pa each\n")


def test_table_on_a_terminal(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("FORCE_COLOR", "1")
    assert main(["estimate", "skin.toml", "frames.npz", "--out", "result.npz"]) == 0
    out = capsys.readouterr().out
    assert "phi/°" in out
    assert re.search(r"│ +2 │", out)


def test_a_failed_simulation_is_no_bad_input(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def fail(*arguments: Any, **options: Any) -> None:
        raise SimulationError("vvp gave up")

    monkeypatch.setattr("tfra.sim.run.simulate", fail)
    assert main(["estimate", "skin.toml", "frames.npz", "--engine", "rtl", "--out", "r.npz"]) == 1
    assert capsys.readouterr().err == "tfra estimate: vvp gave up\n"
    assert not Path("r.npz").exists()


# generate and verify


def made_report(passed: bool) -> Report:
    """One of ten words, one of which may not have come."""
    timing = Timing(None, None, 70, 50)
    return Report(
        "skin", "icarus", 0, {"given": 1}, 10, 9 + passed, 0, None, (), timing, {}, {}, None, (), recorded=7
    )


@pytest.mark.parametrize("passed", [True, False])
def test_verify(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], passed: bool
) -> None:
    calls, other = [], {"core": None, "waves": None}

    def verify(design: Any, frames: Any, **options: Any) -> Report:
        del options["progress"]
        options["references"] = list(options["references"])[:3]
        calls.append((design.name, frames.shape, bool((frames < 0).all()), options))
        return made_report(passed)

    monkeypatch.setattr("tfra.sim.verify.verify", verify)
    capsys.readouterr()
    np.save("one.npy", np.ones((1, 5, 6)))
    assert main(["verify", "skin.toml"]) == (not passed)
    assert capsys.readouterr().out.endswith("skin: every bit equals the model\n" if passed else "skin: FAILED\n")
    options = ["--frames", "one.npy", "--simulator", "verilator", "--seed", "3", "--random", "7", "--json"]
    options += ["--compression", "positive"]
    assert main(["verify", "skin.toml", *options]) == (not passed)
    assert json.loads(capsys.readouterr().out)["passed"] == passed
    known = ["resultant_ref", "mu_ref", "phi_ref_deg"]
    assert calls == [
        ("skin", (3, 5, 6), False, {"simulator": None, "seed": 0, "random": 200, "references": known, **other}),
        ("skin", (1, 5, 6), True, {"simulator": "verilator", "seed": 3, "random": 7, "references": [], **other}),
    ]


def test_verify_writes_waves_and_a_page(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    """Over what it wrote itself."""

    def verify(design: Any, frames: Any, waves: Path, **options: Any) -> Any:
        waves.write_text("$enddefinitions $end\n")
        return made_report(False)

    monkeypatch.setattr("tfra.sim.verify.verify", verify)
    for _ in range(2):
        assert main(["verify", "skin.toml", "--waves", "w.vcd", "--page", "p.html"]) == 1
        assert capfd.readouterr().out.endswith("report: p.html\nsignals of frame 7: w.vcd\n")
    assert re.fullmatch(
        r"\$enddefinitions \$end\n\$comment tfra \S+ verify sha256:[0-9a-f]{64} \$end\n", Path("w.vcd").read_text()
    )
    assert "9 of 10 words of 1 frames" in Path("p.html").read_text()


def test_generate(folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    def facts(design: Any, path: Path, inputs: list[Path], part: None, backend: str) -> dict[str, str]:
        assert (inputs, backend) == ([Path("skin.toml")], "verilog")
        return {"name": design.name, "path": str(path)}

    monkeypatch.setattr("tfra.codegen.generate.generate", facts)
    capsys.readouterr()
    assert main(["generate", "skin.toml", "--out", "core", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert set(told.pop("expected")) == {"condition", "contacts", "equal", "near"}
    assert told == {"name": "skin", "path": "core"}
    assert main(["generate", "skin.toml", "--out", "core"]) == 0
    said = capsys.readouterr().out.splitlines()
    assert said[0].startswith("cond(C33) is 1.73; 100.0 % of ")
    assert said[1] == "core: core skin, described in skin.json"


def test_generate_c(folder: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert main(["generate", "skin.toml", "--backend", "c", "--out", "core"]) == 0
    written = {file.name for file in Path("core").iterdir()}
    assert {"skin.h", "skin.c", "skin_tables.c", "skin_test.c", "README.md", "skin.json"} < written
    line = refusal(capfd, "generate", "skin.toml", "--backend", "c", "--package", "--out", "other")
    assert line == "--package: there is none of the back end c"
    assert not Path("other").exists()


def test_tables_over_the_part_of_an_hls_project(folder: Path, capfd: pytest.CaptureFixture[str]) -> None:
    for rows, lacking in ((8, False), (24, True)):
        Path("one.toml").write_text(SKIN.replace("rows = 5", f"rows = {rows}").replace("columns = 6", "columns = 24"))
        assert main(["generate", "one.toml", "--backend", "hls", "--out", f"core{rows}"]) == 0
        said = capfd.readouterr().err
        assert ("warning: one.toml: sensor: tables of" in said) == lacking
        assert ("xc7z020clg400-1" in said) == lacking


def test_estimate_by_the_c_engine(folder: Path) -> None:
    for engine in ("fixed", "c"):
        assert main(["estimate", "skin.toml", "frames.npz", "--engine", engine, "--out", f"{engine}.npz"]) == 0
    with np.load("fixed.npz") as fixed, np.load("c.npz") as compiled:
        for key in ("forces", "mu", "status", "sweep_index"):
            np.testing.assert_array_equal(fixed[key], compiled[key])


# Bad input

USAGE = [
    (["frobnicate"], "tfra: No such command 'frobnicate'."),
    (["--frobnicate"], "tfra: No such option: --frobnicate"),
    (["frames", "skin.toml"], "tfra frames: Missing option '--out'."),
    (
        ["verify", "skin.toml", "--simulator", "abacus"],
        "tfra verify: Invalid value for '--simulator': 'abacus' is not one of 'icarus', 'verilator', 'amaranth'.",
    ),
    (
        ["verify", "skin.toml", "--seed", "x"],
        "tfra verify: Invalid value for '--seed': "
        "Input should be a valid integer, unable to parse string as an integer",
    ),
    (["frames", "skin.toml", "--out", "no/f.npz"], "no/f.npz: cannot be written: No such file or directory"),
]


@pytest.mark.parametrize(("arguments", "line"), USAGE, ids=[" ".join(a) for a, _ in USAGE])
def test_wrong_usage(
    folder: Path, capfd: pytest.CaptureFixture[str], arguments: list[str], line: str
) -> None:
    assert refusal(capfd, *arguments) == line


def test_out_of_memory(
    folder: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def exhausted(*arguments: Any) -> None:
        raise MemoryError("Unable to allocate 7.45 GiB")

    monkeypatch.setattr("tfra.model.tfra.Tfra.__call__", exhausted)
    line = refusal(capfd, "estimate", "skin.toml", "frames.npz", "--out", "r.npz")
    assert line == "tfra estimate skin.toml frames.npz --out r.npz: not enough memory: Unable to allocate 7.45 GiB"


@pytest.mark.parametrize(
    ("command", "extra"),
    [
        ("live skin.toml f.npz", "view"),
        ("view r.npz --out p.html", "view"),
        ("paper --out p", "paper"),
        ("train skin.toml --out w.npz", "train"),
        ("study s.toml --out d", "study"),
    ],
)
def test_missing_packages(
    command: str, extra: str, folder: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tfra.runtime.errors.find_spec", lambda name: None)
    assert refusal(capfd, *command.split()).endswith(f"missing, please run: pip install 'tfra[{extra}]'")
