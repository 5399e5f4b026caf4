"""The example programs on a board of files, and the page that shows them."""

import re
import struct
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.codegen.package.c_driver import SOURCES, STRICT
from tests.codegen.package.test_drivers import beats, written
from tests.codegen.package.test_simulated import DESIGN
from tests.marks import long
from tfra.codegen.registers.source import registers_of
from tfra.codegen.sidecar.build import LOADED
from tfra.codegen.verilog.emit import to_verilog
from tfra.codegen.verilog.testbench import hex_words
from tfra.codegen.verilog.wrapper import wrapper_verilog
from tfra.hdl.cores import microarchitecture
from tfra.model.choices import Bus
from tfra.model.fixed.design import Design
from tfra.model.fixed.words import decode
from tfra.sim.tools import choose, environment

PAGE, SOURCE = Path(__file__).parents[3] / "docs" / "driver.md", Path(__file__).parents[3] / "codegen/package/driver"
FRAMES = np.random.default_rng(3).integers(-4000, 4000, (10, DESIGN.sensor.taxels))
STATES = {0x44: 0b0010, 0x90: 0b11}
"""STATUS of a core that is loaded and stopped, LOAD_STATUS of one that waits and has the right checksum."""


def board(folder: Path, design: Design) -> list[str]:
    """The package in ``folder`` with the board's files; the lines that an example prints, up to the faults."""
    written(folder, design)
    words = [0] * 1024
    for register in registers_of(design).registers:
        words[register.address // 4] = STATES.get(register.address, register.reset)
    (folder / "registers.bin").write_bytes(struct.pack("<1024I", *words))
    results = design.model(FRAMES).words.tolist()
    frames = [beats(design, result, header=(number, 1 << 24)) for number, result in enumerate(results)]
    (folder / "frames.bin").write_bytes(b"".join(struct.pack(f"<{len(frame)}I", *frame) for frame in frames))
    loaded = microarchitecture(design).loaded
    if loaded is not None:
        (folder / LOADED).parent.mkdir()
        (folder / LOADED).write_text(hex_words(loaded, design.coefficient_word))
    known = decode(design, np.array(results))
    return [
        f"{number}: {x:.6f} {y:.6f} {z:.6f} N, friction {mu:.3f}, "
        for number, ((x, y, z), mu) in enumerate(zip(known.resultant, known.mu, strict=True))
    ]


@pytest.mark.parametrize("images", [*long("load"), "inline"])
def test_the_example_in_c(tmp_path: Path, images: str) -> None:
    design = replace(DESIGN, images=images)
    lines = board(tmp_path, design)
    files = [tmp_path / "driver" / name for name in ("example.c", *SOURCES)]
    files.append(Path(__file__).with_name("board.c"))
    options = ["-Idriver", "-Iregisters", f"-DFRAME={design.frame_words + 2}u", "-fsanitize=address,undefined"]
    subprocess.run(["gcc", *STRICT, *options, "-o", "example", *files], cwd=tmp_path, check=True)
    done = subprocess.run(["./example"], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert done.stdout.splitlines() == [f"{line}faults 0x000" for line in lines]


@pytest.mark.parametrize("images", ["load", "inline"])
@pytest.mark.long
def test_the_example_in_python(tmp_path: Path, images: str) -> None:
    """With registers mapped from a file, which has afterwards what was written."""
    lines = board(tmp_path, replace(DESIGN, images=images))
    command = [sys.executable, "python/example.py", "registers.bin", "frames.bin"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.stderr == ""
    assert done.stdout.splitlines() == [f"{line}no faults" for line in lines]
    words = struct.unpack("<1024I", (tmp_path / "registers.bin").read_bytes())
    assert words[0xA4 // 4] == 3
    assert words[0xA0 // 4] == DESIGN.adc.bits
    assert words[0x40 // 4] == 0b1000


def test_the_page_shows_the_examples() -> None:
    blocks = dict(re.findall(r"^```(c|python)\n(.*?)^```", PAGE.read_text(), re.M | re.S))
    assert blocks["c"] in (SOURCE / "example.c").read_text()
    assert blocks["python"] in (SOURCE / "example.py").read_text()


def test_the_page_has_every_error_and_function() -> None:
    page, header = PAGE.read_text(), (SOURCE / "tfra_driver.h").read_text()
    errors = re.findall(r"TFRA_ERROR_(\w+) = (\d+)", header)
    assert re.findall(r"^\| (\d+) \| `(\w+)` \|", page, re.M) == [(code, name) for name, code in errors]
    functions = set(re.findall(r"^(?:tfra_error_t|uint32_t) tfra_(\w+)\(", header, re.M))
    named = set(re.findall(r"`(\w+)`", page))
    assert functions - named == {"crc32", "repair_target", "repair_source"}


@pytest.mark.long
def test_the_cosimulation(tmp_path: Path) -> None:
    """By the command in its head; a word that differs is noticed."""
    choose("verilator")
    design = replace(DESIGN, images="load", bus=Bus(4))
    written(tmp_path, design)
    (tmp_path / f"{design.name}.v").write_text(to_verilog(design))
    (tmp_path / f"{design.name}_axi.v").write_text(wrapper_verilog(design))
    text = (tmp_path / "driver" / "cosim.cpp").read_text()
    (command,) = re.findall(r"^ \*  (verilator .*)\n \* +(.*)$", text, re.M)
    variables, recorded = environment("verilator", tmp_path), tmp_path / "driver" / f"{design.name}_recorded.h"
    for wrong in (0, 1):
        recorded.write_text(recorded.read_text().replace("}, {0,", f"}}, {{{wrong},", wrong))
        words = ["sh", "-c", " ".join(command)]
        done = subprocess.run(words, cwd=tmp_path, env=variables, capture_output=True, text=True, check=False)
        assert f"{4 * design.frame_words} words compared, {wrong} differ" in done.stdout, done.stdout + done.stderr
        assert done.returncode == wrong
