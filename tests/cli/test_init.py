"""``tfra init`` and ``tfra examples``: files to begin with, which every command takes."""

from pathlib import Path

import pytest

from tests.cli.test_cli import refusal
from tfra.cli.main import main
from tfra.codegen.config.examples import examples
from tfra.codegen.config.read import load

EXAMPLES = Path(__file__).parents[2] / "examples"
WEIGHTS = "hertz_40x20.weights.npz"
SENSOR = ("--rows", "4", "--columns", "6", "--pitch-x", "3", "--pitch-y", "2.5")
INIT = ("init", *SENSOR, "--thickness", "3")


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_standard_output_is_the_same_file(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*INIT, "--out", "sensor.toml"]) == 0
    capsys.readouterr()
    assert main([*INIT]) == 0
    out = capsys.readouterr().out
    *lines, seal = Path("sensor.toml").read_text().splitlines()
    assert out.splitlines() == lines
    assert seal.startswith("# tfra ")


@pytest.mark.parametrize(
    ("part", "family", "kind"),
    [
        ("ecp5-25", "ecp5", "parallel"),
        ("ecp5-85-8", "ecp5", "parallel"),
        ("ice40up5k", "ice40", "serial"),
        ("xc7", "portable", "parallel"),
        ("gw2a-18", "portable", "parallel"),
    ],
)
def test_a_part_decides_cells_and_kind(part: str, family: str, kind: str) -> None:
    assert main([*INIT, "--target", part, "--out", "sensor.toml"]) == 0
    design = load("sensor.toml").design
    assert (design.target, design.architecture.kind) == (family, kind)


def test_a_file_called_like_a_keyword(capfd: pytest.CaptureFixture[str]) -> None:
    reason = "always.toml: a core cannot have this name, which Verilog or a port uses"
    assert refusal(capfd, *INIT, "--out", "always.toml").startswith(reason)


@pytest.mark.parametrize(
    ("options", "warning"),
    [
        (["--thickness", "500"], "--thickness: 500 mm is unusual: was it given in µm?"),
        (["--full-scale", "2e8"], "--full-scale: 2e+08 Pa is unusual: is it in Pa?"),
    ],
)
def test_what_is_doubtful(options: list[str], warning: str, capfd: pytest.CaptureFixture[str]) -> None:
    assert main([*INIT, *options, "--out", "sensor.toml"]) == 0
    err = capfd.readouterr().err
    assert err.startswith(f"warning: tfra init: {warning}")
    assert err.count("\n") == 1
    load("sensor.toml")


def test_examples(capfd: pytest.CaptureFixture[str]) -> None:
    assert main(["examples"]) == 0
    listed = capfd.readouterr().out.splitlines()
    assert [line.split()[0] for line in listed] == sorted(examples())
    assert all(len(line.split()) > 4 for line in listed)
    assert main(["examples", "skin_8x12"]) == main(["examples", "skin_8x12.toml"]) == 0
    assert capfd.readouterr().out == 2 * examples()["skin_8x12"]
    assert main(["examples", "--out", "all"]) == main(["examples", "--out", "all"]) == 0
    assert {path.name.removesuffix(".toml") for path in Path("all").glob("[!t]*.[tc]*")} == set(examples())
    assert main(["examples", "study_quick", "--out", "one"]) == 0
    assert {path.name for path in Path("one").glob("[!t]*")} == {"study_quick.toml", "hertz_40x20.toml", WEIGHTS}
    assert capfd.readouterr().out.endswith(f"one: hertz_40x20.toml, {WEIGHTS}, study_quick.toml\n")
    assert main(["examples", "study_learned", "--out", "two"]) == 0
    assert {path.stem for path in Path("two").glob("*.toml")} == {"study_learned", "learned_fast", "hertz_40x20"}
    for path in Path("all").glob("*.toml"):
        if not path.name.startswith("study"):
            load(path)
    assert main(["examples", "small", "--out", "small"]) == 0
    assert {path.name for path in Path("small").glob("[!t]*")} == {"small.toml"}
    Path("all/skin_8x12.toml").write_text("mine")
    assert "skin_8x12.toml in it has changed since tfra wrote it" in refusal(capfd, "examples", "--out", "all")


def test_weights_are_beside_the_example_of_their_sensor() -> None:
    assert main(["examples", "--out", "all"]) == 0
    written = {path.name: path.read_bytes() for path in Path("all").glob("*.npz")}
    assert written == {path.name: path.read_bytes() for path in EXAMPLES.glob("*.npz")}
    assert WEIGHTS in written
    for name in written:
        example = Path("all", name.replace(".weights.npz", ".toml"))
        learned = example.with_name("learned.toml")
        chosen = "" if "[estimator]" in example.read_text() else f'[estimator]\nkind = "learned"\nweights = "{name}"\n'
        learned.write_text(example.read_text().replace("# [estimator]", "#") + chosen)
        assert main(["frames", str(learned), "--out", "frames.npz"]) == 0
        assert main(["estimate", str(learned), "frames.npz", "--out", "forces.npz"]) == 0
