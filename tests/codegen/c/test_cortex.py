"""Cores in C on a Cortex-M7 in QEMU: recorded words, instructions of a frame, and the memory that the header states."""

import re
import subprocess
from pathlib import Path

import pytest

from tests.codegen.package.made import write
from tfra.codegen.c.files import files
from tfra.codegen.c.memory import ram_bytes, stack_bytes
from tfra.codegen.config.read import load

PLACE = Path(__file__).parent / "cortex"
EXAMPLES = Path(__file__).parents[3] / "examples"
ARM = "arm-none-eabi-gcc -std=gnu99 -mcpu=cortex-m7 -mthumb --specs=rdimon.specs -nostartfiles -I."
QEMU = "qemu-system-arm -M mps2-an500 -nographic -icount shift=0 -semihosting-config enable=on,target=native -kernel"


@pytest.mark.long
@pytest.mark.parametrize("example", ["fast", "learned_fast", "learned_resultant"])
@pytest.mark.parametrize("level", ["-Os", "-O2", "-O3"])
def test_words_instructions_and_memory(example: str, level: str, tmp_path: Path) -> None:
    design = load(EXAMPLES / f"{example}.toml").design
    name, texts = design.name, files(design)
    write(tmp_path, texts)
    built = [f"{name}.c", f"{name}_tables.c", *(str(PLACE / file) for file in ("start.c", "measure.c"))]
    command = [*ARM.split(), level, f"-DCORE={name}", "-T", str(PLACE / "an500.ld"), "-o", "core.elf", *built]
    subprocess.run(command, cwd=tmp_path, check=True)
    done = subprocess.run(
        [*QEMU.split(), "core.elf"], cwd=tmp_path, capture_output=True, text=True, timeout=300, check=False
    )
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
