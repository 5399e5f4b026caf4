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
from tests.codegen.package.test_skin import SKIN, codes_of
from tests.codegen.package.test_skin import beats as beats_of_skin
from tests.marks import long
from tfra.codegen.registers.source import registers_of
from tfra.codegen.sidecar.build import LOADED as LOADED_FILE
from tfra.codegen.verilog.emit import to_verilog
from tfra.codegen.verilog.testbench import hex_words
from tfra.codegen.verilog.wrapper import wrapper_verilog
from tfra.hdl.cores import microarchitecture
from tfra.model.choices import Bus
from tfra.model.cover.scenes import contact_codes
from tfra.model.fixed.design import Design
from tfra.model.fixed.words import decode
from tfra.model.skin.records import decode_records, results
from tfra.model.skin.scenes import recorded as skin_frames
from tfra.model.skin.skin import Skin, core_of
from tfra.sim.tools import choose, environment

PAGE, SOURCE = Path(__file__).parents[3] / "docs" / "driver.md", Path(__file__).parents[3] / "codegen/package/driver"
FRAMES = np.random.default_rng(3).integers(-4000, 4000, (10, DESIGN.sensor.taxels))
LOADED = replace(SKIN, window=replace(SKIN.window, images="load"))
STATES = {0x44: 0b0010, 0x90: 0b11}
"""STATUS of a core that is loaded and stopped, LOAD_STATUS of one that waits and has the right checksum."""


def _id(array: Design | Skin) -> str:
    return f"{array.name}-{core_of(array).images}"


def board(folder: Path, array: Design | Skin) -> list[str]:
    """The package in ``folder`` with the board's files; the lines that an example prints, without faults and marks."""
    written(folder, array)
    words = [0] * 1024
    for register in registers_of(array).registers:
        words[register.address // 4] = STATES.get(register.address, register.reset)
    (folder / "registers.bin").write_bytes(struct.pack("<1024I", *words))
    frames, lines = _of_skin(array) if isinstance(array, Skin) else _of_core(array)
    (folder / "lengths.bin").write_bytes(struct.pack(f"<{len(frames)}I", *map(len, frames)))
    (folder / "frames.bin").write_bytes(b"".join(struct.pack(f"<{len(frame)}I", *frame) for frame in frames))
    design = core_of(array)
    loaded = microarchitecture(design).loaded
    if loaded is not None:
        (folder / LOADED_FILE).parent.mkdir()
        (folder / LOADED_FILE).write_text(hex_words(loaded, design.coefficient_word))
    return lines


def _of_core(design: Design) -> tuple[list[list[int]], list[str]]:
    """Output frames, and the lines of each."""
    words = design.model(FRAMES).words
    frames = [beats(design, result, header=(number, 1 << 24)) for number, result in enumerate(words.tolist())]
    known = decode(design, words)
    return frames, [
        f"{number}: {x:.6f} {y:.6f} {z:.6f} N, friction {mu:.3f}, "
        for number, ((x, y, z), mu) in enumerate(zip(known.resultant, known.mu, strict=True))
    ]


def _of_skin(skin: Skin) -> tuple[list[list[int]], list[str]]:
    """As :func:`_of_core`, with a line of each contact."""
    every, lines = results(skin, codes_of(skin, 10)), []
    for number, records in enumerate(every):
        known = decode_records(skin, records)
        lines.append(f"{number}: {len(known.frame)} contacts, {known.dropped[0]} dropped, ")
        windows = zip(known.windows.resultant, known.windows.mu, strict=True)
        for place, (force, mu) in zip(zip(known.x, known.y, strict=True), windows, strict=True):
            at, newton = " ".join(f"{each:.4f}" for each in place), " ".join(f"{each:.6f}" for each in force)
            lines.append(f"  at {at} m: {newton} N, friction {mu:.3f}, ")
    return [beats_of_skin(skin, records, (n, 2 << 24)) for n, records in enumerate(every)], lines


def without_flags(output: str) -> list[str]:
    """Lines without faults and marks, which C has as numbers and Python by names."""
    return [re.sub(r"((?:friction [-\d.]+|\d+ dropped), ).*", r"\1", line) for line in output.splitlines()]


@pytest.mark.parametrize("array", [*long(replace(DESIGN, images="load"), LOADED), DESIGN, SKIN], ids=_id)
def test_the_example_in_c(tmp_path: Path, array: Design | Skin) -> None:
    lines = board(tmp_path, array)
    files = [tmp_path / "driver" / name for name in ("example.c", *SOURCES)]
    files.append(Path(__file__).with_name("board.c"))
    options = ["-Idriver", "-Iregisters", "-fsanitize=address,undefined"]
    subprocess.run(["gcc", *STRICT, *options, "-o", "example", *files], cwd=tmp_path, check=True)
    done = subprocess.run(["./example"], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert without_flags(done.stdout) == lines
    assert "faults 0x000" in done.stdout


@pytest.mark.parametrize("array", [replace(DESIGN, images="load"), replace(DESIGN, images="inline"), LOADED], ids=_id)
@pytest.mark.long
def test_the_example_in_python(tmp_path: Path, array: Design | Skin) -> None:
    """With registers mapped from a file, which has afterwards what was written."""
    lines = board(tmp_path, array)
    command = [sys.executable, "python/example.py", "registers.bin", "frames.bin"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.stderr == ""
    assert without_flags(done.stdout) == lines
    assert "no faults" in done.stdout
    words = struct.unpack("<1024I", (tmp_path / "registers.bin").read_bytes())
    assert words[0xA4 // 4] == 3
    assert words[0xA0 // 4] == array.adc.bits
    assert words[0x40 // 4] == 0b1000


def test_the_page_shows_the_examples() -> None:
    blocks = re.findall(r"^```(?:c|python)\n(.*?)^```", PAGE.read_text(), re.M | re.S)
    files = ("example.c", "show_frame.h", "show_contacts.h", "example.py", "example_contacts.py")
    assert len(blocks) == len(files)
    for block, name in zip(blocks, files, strict=True):
        assert block in (SOURCE / name).read_text()


def test_the_page_has_every_error_and_function() -> None:
    page, header = PAGE.read_text(), (SOURCE / "tfra_driver.h").read_text()
    errors = re.findall(r"TFRA_ERROR_(\w+) = (\d+)", header)
    assert re.findall(r"^\| (\d+) \| `(\w+)` \|", page, re.M) == [(code, name) for name, code in errors]
    functions = set(re.findall(r"^(?:tfra_error_t|uint32_t) tfra_(\w+)\(", header, re.M))
    named = set(re.findall(r"`(\w+)`", page))
    assert functions - named == {"crc32", "repair_target", "repair_source"}


@pytest.mark.long
@pytest.mark.parametrize("design", [replace(DESIGN, images="load", bus=Bus(4)), LOADED], ids=_id)
def test_the_cosimulation(tmp_path: Path, design: Design | Skin) -> None:
    """By the command in its head; a word that differs is noticed."""
    choose("verilator")
    written(tmp_path, design)
    codes = skin_frames(design) if isinstance(design, Skin) else contact_codes(design, 4, 3)
    total = sum(map(np.size, results(design, codes)))
    (tmp_path / f"{design.name}.v").write_text(to_verilog(design))
    (tmp_path / f"{design.name}_axi.v").write_text(wrapper_verilog(design))
    text = (tmp_path / "driver" / "cosim.cpp").read_text()
    (command,) = re.findall(r"^ \*  (verilator .*)\n \* +(.*)$", text, re.M)
    variables, recorded = environment("verilator", tmp_path), tmp_path / "driver" / f"{design.name}_recorded.h"
    for wrong in (0, 1):
        recorded.write_text(re.sub(r"(\}, \d+u, \{)0,", rf"\g<1>{wrong},", recorded.read_text(), count=wrong))
        words = ["sh", "-c", " ".join(command)]
        done = subprocess.run(words, cwd=tmp_path, env=variables, capture_output=True, text=True, check=False)
        assert f"{total} words compared, {wrong} differ" in done.stdout, done.stdout + done.stderr
        assert done.returncode == wrong
