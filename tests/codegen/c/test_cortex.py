"""Cores in C on a Cortex-M7 in QEMU: recorded words, instructions of a frame, and the memory that the header states."""

import re
import subprocess
from pathlib import Path

import pytest

from tests.codegen.package.made import write
from tfra.codegen.c.files import files
from tfra.codegen.c.memory import ram_bytes, stack_bytes
from tfra.codegen.config.read import load

EXAMPLES = Path(__file__).parents[3] / "examples"


@pytest.mark.long
@pytest.mark.parametrize("example", ["fast", "learned_fast", "learned_resultant"])
@pytest.mark.parametrize("level", ["-Os", "-O2", "-O3"])
def test_words_instructions_and_memory(example: str, level: str, tmp_path: Path) -> None:
    design = load(EXAMPLES / f"{example}.toml").design
    name, texts = design.name, files(design)
    write(tmp_path, texts)
    *_, build, emulate = re.findall(r"^    ((?:arm|qemu)-.*)$", texts["README.md"], re.M)
    subprocess.run(build.replace("-O2", level).split(), cwd=tmp_path, check=True)
    done = subprocess.run(emulate.split(), cwd=tmp_path, capture_output=True, text=True, timeout=300, check=False)
    found = re.fullmatch(
        rf"{name}: 31 frames, \d+ words, all right\n(\d+) to (\d+) instructions, (\d+) bytes of stack\n", done.stdout
    )
    assert found, done.stdout + done.stderr
    least, most, stack = map(int, found.groups())
    print(f"{name} {level}: {least:,} to {most:,} instructions, {stack:,} bytes of stack")
    assert stack <= stack_bytes(design)
    assert f"RAM: {ram_bytes(design)} bytes, the state.  Stack: {stack_bytes(design)} bytes" in texts[f"{name}.h"]
    assert most < 1.15 * least  # no loop depends on data
    assert 4 * design.multiplications < most < 40 * design.multiplications
