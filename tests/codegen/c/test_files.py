"""Cores in C from their folder alone: strict compilers, sanitizers, CMake; their tests notice a wrong table."""

import re
import subprocess
from pathlib import Path

import pytest

from tests.codegen.c.cases import SMALL
from tests.codegen.package.c_driver import STRICT
from tests.codegen.package.made import write
from tests.marks import long
from tfra.codegen.c.files import files
from tfra.model.fixed.design import Design

WARNINGS = (*STRICT, "-Wundef", "-Wvla", "-Wdouble-promotion", "-Wfloat-conversion")
SANITIZERS = "-fsanitize=undefined,address -fno-sanitize-recover=all -g"
FEW = ("3x5", "5x4", "learned_3x5")
CASES = [*FEW, *long(*(case for case in SMALL if case not in FEW))]
BUILDS = ["gcc -O2", *long(f"gcc -O3 {SANITIZERS}", f"clang -O1 {SANITIZERS}")]


def run(folder: Path, *command: str) -> str:
    """What a command prints, which must end well."""
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, f"{command}\n{done.stdout}{done.stderr}"
    return done.stdout


def built_by_readme(folder: Path, texts: dict[str, str], header: str, state: str) -> str:
    """What ctest prints after the README's own commands in an empty folder of ``texts``.

    The README's example compiles in C, and the type ``state`` of the ``header`` as part of C++.
    """
    write(folder, texts)
    (command,) = re.findall(r"^    (cmake .*)$", texts["README.md"], re.M)
    said = run(folder, "sh", "-c", command)
    write(folder, {"example.c": "\n".join(re.findall(r"^```c\n(.*?)^```", texts["README.md"], re.M | re.S))})
    run(folder, "gcc", "-std=c99", "-Wall", "-Wextra", "-Werror", "-c", "example.c")
    write(folder, {"user.cpp": f'#include "{header}"\n{state} state;\n'})
    run(folder, "g++", "-Wall", "-Wextra", "-Werror", "-c", "user.cpp")
    return said


def sources(design: Design) -> list[str]:
    return [f"{design.name}{kind}.c" for kind in ("", "_tables", "_test")]


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("build", BUILDS)
def test_the_core_checks_itself(case: str, build: str, tmp_path: Path) -> None:
    design = SMALL[case]
    write(tmp_path, files(design))
    compiler, *options = build.split()
    run(tmp_path, compiler, *WARNINGS, *options, "-o", "test", *sources(design))
    said = run(tmp_path, "./test")
    assert re.fullmatch(rf"{design.name}: \d\d frames, \d+ words, all right\n", said)


@pytest.mark.parametrize("case", CASES)
def test_its_steps_are_counted(case: str, tmp_path: Path) -> None:
    """No recorded frame has more iterations than the header says, and one has as many."""
    design = SMALL[case]
    texts = files(design)
    core = re.sub(r"( for \(.*; )(?=[^;]*\)( \{)?$)", r"\1counted++, ", texts[f"{design.name}.c"], flags=re.M)
    end = "    result->frame = state->frame++;\n"
    assert core.count(end) == 1
    core = core.replace(end, end + "    most = counted > most ? counted : most;\n    counted = 0;\n")
    say = '__attribute__((destructor)) static void say(void)\n{\n    printf("%ld steps\\n", most);\n}\n'
    texts[f"{design.name}.c"] = f"#include <stdio.h>\nstatic long counted, most;\n{say}{core}"
    write(tmp_path, texts)
    run(tmp_path, "gcc", "-o", "test", *sources(design))
    (stated,) = re.findall(r"its loops (\S+) iterations at most", texts[f"{design.name}.h"])
    assert f"\n{stated.replace(',', '')} steps\n" in run(tmp_path, "./test")


@pytest.mark.parametrize("case", ["3x5", "learned_3x5"])
def test_a_wrong_table_is_noticed(case: str, tmp_path: Path) -> None:
    design = SMALL[case]
    texts = files(design)
    name = f"{design.name}_tables.c"
    at = texts[name].rindex("= {")
    texts[name] = texts[name][:at] + re.sub(
        r"-?\d{3,}", lambda found: str(int(found[0]) ^ 64), texts[name][at:], count=1
    )
    write(tmp_path, texts)
    run(tmp_path, "gcc", "-O1", "-o", "test", *sources(design))
    done = subprocess.run([tmp_path / "test"], capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert re.fullmatch(r"frame \d+, word \d+, \w+: -?\d+, -?\d+ is right\n", done.stdout)


def test_its_readme_and_cmake(tmp_path: Path) -> None:
    design = SMALL["3x5"]
    assert "100% tests passed" in built_by_readme(tmp_path, files(design), f"{design.name}.h", f"{design.name}_state")


@pytest.mark.long
@pytest.mark.parametrize("case", SMALL)
def test_other_processors_by_compilation(case: str, tmp_path: Path) -> None:
    design = SMALL[case]
    texts = files(design)
    write(tmp_path, texts)
    for command in re.findall(r"^    ((?:arm|riscv).* -c .*)$", texts["README.md"], re.M):
        run(tmp_path, *command.split(), "-Wall", "-Wextra", "-Werror")
