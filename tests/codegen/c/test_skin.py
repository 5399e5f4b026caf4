"""Skins in C from their folder alone: strict compilers, sanitizers, CMake; their tests notice what is wrong."""

import re
import subprocess
from pathlib import Path

import pytest

from tests.codegen.c.skins import SKINS
from tests.codegen.c.test_files import BUILDS, WARNINGS, built_by_readme, run
from tests.codegen.package.made import write
from tests.marks import long
from tfra.codegen.c.files import files
from tfra.codegen.c.memory import ram_bytes, stack_bytes
from tfra.codegen.c.skin import skin_files, skin_ram_bytes, skin_stack_bytes
from tfra.model.skin.skin import Skin


def sources(skin: Skin) -> list[str]:
    return [f"{skin.window.name}{kind}.c" for kind in ("", "_tables", "_skin", "_skin_test")]


@pytest.mark.parametrize("case", ["smallest", "12x20", *long("narrow", "learned")])
@pytest.mark.parametrize("build", BUILDS)
def test_a_skin_checks_itself(case: str, build: str, tmp_path: Path) -> None:
    skin = SKINS[case]
    write(tmp_path, skin_files(skin))
    compiler, *options = build.split()
    run(tmp_path, compiler, *WARNINGS, *options, "-o", "test", *sources(skin))
    said = run(tmp_path, "./test")
    assert re.fullmatch(rf"{skin.window.name} on a skin: 7 frames, \d+ contacts, all right\n", said)


def test_the_core_of_its_window_is_as_without_a_skin() -> None:
    skin = SKINS["12x20"]
    alone, texts = files(skin.window), skin_files(skin)
    assert {name for name in alone if texts[name] != alone[name]} == {"CMakeLists.txt", "README.md"}
    assert all(texts[name].startswith(alone[name]) for name in alone)
    assert skin_ram_bytes(skin) > ram_bytes(skin.window) + 5 * skin.sensor.taxels
    stated = f"RAM: {skin_ram_bytes(skin)} bytes, the state.  Stack: {skin_stack_bytes(skin)} bytes"
    assert stated in texts[f"{skin.window.name}_skin.h"]


@pytest.fixture(scope="module")
def others(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The files of a skin, compiled but for the skin's own."""
    folder, skin = tmp_path_factory.mktemp("others"), SKINS["12x20"]
    write(folder, skin_files(skin))
    run(folder, "gcc", "-O1", "-c", *(name for name in sources(skin) if not name.endswith("_skin.c")))
    return folder


@pytest.mark.parametrize(
    ("right", "wrong"),
    [
        pytest.param("#define THRESHOLD 10", "#define THRESHOLD 11", id="threshold"),
        pytest.param("#define THRESHOLD 10", "#define THRESHOLD 9", id="lower threshold"),
        pytest.param("+ 2 * line[column + 1]", "+ 3 * line[column + 1]", id="weight of a column"),
        pytest.param("+ 2 * code_of(here[column])", "+ code_of(here[column])", id="weight of a row"),
        pytest.param("#define MOST 8", "#define MOST 9", id="most"),
        pytest.param("#define GAP 2", "#define GAP 1", id="gap"),
        pytest.param("#define LEAST 4096", "#define LEAST 32768", id="floor"),
        pytest.param("(height > here[column - 1])", "(height >= here[column - 1])", id="level peaks"),
        pytest.param("+ taxels) / (2", ") / (2", id="rounding of places"),
        pytest.param("half * (2 - size)", "half * (1 - size)", id="corners"),
        pytest.param("*touching = true;", "*touching = false;", id="touching"),
        pytest.param("2 * skin->smooth[at] < height", "2 * skin->smooth[at] <= height", id="half as high"),
    ],
)
def test_what_is_wrong_is_noticed(right: str, wrong: str, others: Path, tmp_path: Path) -> None:
    skin = SKINS["12x20"]
    name = f"{skin.window.name}_skin.c"
    text = (others / name).read_text()
    assert text.count(right) == 1
    write(tmp_path, {name: text.replace(right, wrong)})
    run(tmp_path, "gcc", "-O1", f"-I{others}", "-o", "test", name, *map(str, others.glob("*.o")))
    done = subprocess.run([tmp_path / "test"], capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert re.fullmatch(r"(contact \d+, word \d+, [\w.]+|frame \d+): .* (is|are) right\n", done.stdout)


def test_its_readme_and_cmake(tmp_path: Path) -> None:
    skin = SKINS["12x20"]
    name = f"{skin.window.name}_skin"
    said = built_by_readme(tmp_path, skin_files(skin), f"{name}.h", name)
    assert "100% tests passed, 0 tests failed out of 2" in said


@pytest.mark.long
@pytest.mark.parametrize("case", SKINS)
def test_other_processors_by_compilation(case: str, tmp_path: Path) -> None:
    skin = SKINS[case]
    texts = skin_files(skin)
    write(tmp_path, texts)
    name = skin.window.name
    for command in re.findall(r"^    ((?:arm|riscv).* -c .*)$", texts["README.md"], re.M):
        run(tmp_path, *command.split(), f"{name}_skin.c", "-Wall", "-Wextra", "-Werror")


@pytest.mark.long
@pytest.mark.parametrize("level", ["-Os", "-O2", "-O3"])
def test_contacts_and_stack_on_a_cortex_m7(level: str, tmp_path: Path) -> None:
    skin = SKINS["12x20"]
    texts = skin_files(skin)
    write(tmp_path, texts)
    *_, build, emulate = re.findall(r"^    ((?:arm|qemu)-.*)$", texts["README.md"], re.M)
    run(tmp_path, *build.replace("-O2", level).split(), "-fstack-usage")
    assert run(tmp_path, *emulate.split()).endswith(" contacts, all right\n")
    (usage,) = tmp_path.glob("*_skin.su")
    used = [int(line.split("\t")[1]) for line in usage.read_text().splitlines()]
    assert sum(used) <= skin_stack_bytes(skin) - stack_bytes(skin.window)
