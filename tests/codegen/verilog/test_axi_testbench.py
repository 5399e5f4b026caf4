"""The testbench of the wrapper passes for every kind of core, and notices what is wrong in words, RTL and counters."""

import re
import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from tests.codegen.package.made import PARALLEL, write
from tests.codegen.package.test_simulated import DESIGN
from tests.codegen.test_generate import DESIGNS, change_word, few_frames, run_testbench
from tests.hdl.skin.skins import skin_of, small_window
from tfra.codegen.verilog.axi_testbench import axi_testbench
from tfra.codegen.verilog.files import files
from tfra.codegen.verilog.wrapper import wrapper_verilog
from tfra.hdl.bus.map import BITS
from tfra.hdl.ip.framer import HEADER_WORDS
from tfra.model.choices import Bus
from tfra.model.fixed.design import Design
from tfra.model.skin.skin import Skin

pytestmark = pytest.mark.long

SHORT = replace(PARALLEL, name="short", images="load", bus=Bus(2))
KINDS = {
    **{name: DESIGNS[name] for name in ("odd", "serial", "learned", "learned_serial")},
    "loaded": replace(DESIGN, name="loaded", bus=Bus(4)),
    "one_beat": replace(PARALLEL, name="one_beat", bus=Bus(4)),
}


def folder_of(design: Design | Skin, folder: Path) -> Path:
    """Core, wrapper and testbench."""
    name = design.name
    with few_frames():
        texts = files(design) | {f"testbench/{name}_axi_tb.v": axi_testbench(design)}
    write(folder, texts | {f"{name}_axi.v": wrapper_verilog(design)})
    return folder


@pytest.fixture(scope="module")
def short(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return folder_of(SHORT, tmp_path_factory.mktemp("short"))


def compared(design: Design, output: str) -> int:
    """Whole frames that the testbench compared, if it passed."""
    (words,) = re.findall(r"^PASSED: (\d+) words compared, 0 differ$", output, re.M)
    return int(words) // (HEADER_WORDS + design.frame_words)


def test_it_passes(short: Path) -> None:
    assert compared(SHORT, run_testbench(short, "short_axi")) > 4


@pytest.mark.parametrize("name", KINDS)
def test_it_passes_for_every_kind(name: str, tmp_path: Path) -> None:
    design = KINDS[name]
    assert compared(design, run_testbench(folder_of(design, tmp_path), f"{design.name}_axi")) > 4


def test_a_wrong_word_is_noticed(short: Path, tmp_path: Path) -> None:
    shutil.copytree(short, tmp_path / "core")
    change_word(tmp_path / "core", "short_axi", "result", 1, 1)
    output = run_testbench(tmp_path / "core", "short_axi")
    assert all(text in output for text in ("1 differ", "FAILED", "frame 0, word 10"))


@pytest.mark.parametrize(
    ("file", "stated", "other", "seen"),
    [
        ("short.v", "assign result_data = ", "assign result_data = 1 ^ ", "frame 0, word 3"),
        ("short_axi.v", "assign m_axis_tuser = ", "assign m_axis_tuser = 1 ^ ", "frame 0, word"),
        ("short_axi.v", ".interrupt(irq)", ".interrupt()", "interrupt"),
        ("short_axi.v", "54465241 >>", "54465240 >>", "register 0x00: 54465241 expected, 54465240 observed"),
        ("testbench/short_axi_tb.v", "8'h68, 2", "8'h68, 3", "register 0x68: 00000003 expected, 00000002 observed"),
        ("testbench/short_axi_tb.v", "write(8'h40", "write(8'h44", "register 0x44: error response"),
    ],
)
def test_what_is_planted_is_noticed(short: Path, tmp_path: Path, file: str, stated: str, other: str, seen: str) -> None:
    shutil.copytree(short, tmp_path / "core")
    text = (tmp_path / "core" / file).read_text()
    assert text.count(stated) == 1
    (tmp_path / "core" / file).write_text(text.replace(stated, other))
    output = run_testbench(tmp_path / "core", "short_axi")
    assert "FAILED" in output
    assert seen in output


@pytest.fixture(scope="module")
def skin(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A skin of 6 x 9 taxels with windows of 2 x 3: core, wrapper and testbench."""
    window = replace(small_window(), name="skin", bus=Bus(2))
    return folder_of(skin_of(6, 9, window, most=3), tmp_path_factory.mktemp("skin"))


def test_it_passes_for_a_skin(skin: Path) -> None:
    assert re.search(r"^PASSED: \d{3,} words compared, 0 differ$", run_testbench(skin, "skin_axi"), re.M)


def test_a_frame_of_a_skin_that_ends_with_a_record_is_noticed(skin: Path, tmp_path: Path) -> None:
    shutil.copytree(skin, tmp_path / "core")
    text = (tmp_path / "core" / "skin.v").read_text()
    assert text.count("assign result_data = ") == 1
    (tmp_path / "core" / "skin.v").write_text(text.replace("assign result_data = ", "assign result_data = 1 | "))
    assert "FAILED" in run_testbench(tmp_path / "core", "skin_axi")


def test_tlast_alone_is_noticed(skin: Path, tmp_path: Path) -> None:
    """The same data, but the word is due as the last one of its frame."""
    shutil.copytree(skin, tmp_path / "core")
    change_word(tmp_path / "core", "skin_axi", "result", 1, 1 << BITS)
    output = run_testbench(tmp_path / "core", "skin_axi")
    assert all(text in output for text in ("1 differ", "FAILED", "frame 0, word 10"))
