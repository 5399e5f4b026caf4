"""Boards: the top module in a simulator, byte by byte on its line; scripts; a bitstream of a small core."""

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bench.scorecard import linters as lint
from tests.codegen.package.made import made
from tests.hdl.uart.line import framed, frames, little_endian
from tests.marks import long
from tfra.codegen.package.boards import BAUD, PORTS, boards
from tfra.families import DEFAULT, FAMILIES
from tfra.families.family import Board
from tfra.hdl.cores import microarchitecture
from tfra.sim.tools import choose

_BENCH = """
`timescale 1ns / 1ps
module bench;
  reg clock = 0, rx = 1;
  wire tx, alive, dropped, waits;
  reg [7:0] bytes [0:{last}];
  reg [7:0] heard;
  integer sent, place, got;
  top dut (.clock(clock), .button(1'b{rest}), .rx(rx), .tx(tx), .alive(alive), .dropped(dropped), .waits(waits));
  always #5 clock = !clock;
  initial begin
    $readmemh("line.hex", bytes);
    repeat (1200) @(posedge clock);
    rx = 0; repeat ({divisor} * 15) @(posedge clock); rx = 1; repeat ({divisor} * 2) @(posedge clock);  // a break
    for (sent = 0; sent <= {last}; sent = sent + 1) begin
      rx = 0; repeat ({divisor}) @(posedge clock);
      for (place = 0; place < 8; place = place + 1) begin
        rx = bytes[sent][place]; repeat ({divisor}) @(posedge clock);
      end
      rx = 1; repeat ({divisor}) @(posedge clock);
    end
    repeat ({patience}) @(posedge clock);
    $display("dropped %b", dropped);
    $finish;
  end
  always begin
    wait (tx === 1'b0);
    repeat ({divisor} / 2) @(posedge clock);
    for (got = 0; got < 8; got = got + 1) begin repeat ({divisor}) @(posedge clock); heard[got] = tx; end
    repeat ({divisor}) @(posedge clock);
    $display("byte %h", heard);
  end
endmodule
"""


@pytest.fixture(scope="module", params=["ice40", *long("parallel")])
def package(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[Any, Path]:
    """A design, and the files of its board and core."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("tfra.codegen.package.folder.WRITERS", (lambda contents: contents.cells, boards))
        return made(request.param, tmp_path_factory.mktemp(request.param))


def board_of(design: Any) -> Board:
    board = FAMILIES.get(design.target, DEFAULT).board
    assert board
    return board


def answers(design: Any, package: Path, folder: Path, line: bytes, due: int) -> tuple[list[bytes], bool]:
    """Frames that the board sends for a ``line`` of bytes, and whether its lamp says that some were dropped."""
    choose("icarus")
    board = board_of(design)
    values = {"last": len(line) - 1, "divisor": board.clock_hz // BAUD, "rest": int(board.inverted)}
    bench = _BENCH.format(**values, patience=2000 + due * 11 * board.clock_hz // BAUD)
    (folder / "bench.v").write_text(bench)
    (folder / "line.hex").write_text("".join(f"{byte:02x}\n" for byte in line))
    cells = [str(file) for file in package.glob("testbench/SB_*.v")]
    files = ["bench.v", str(package / "boards" / board.name / "top.v"), str(package / f"{design.name}.v"), *cells]
    subprocess.run(["iverilog", "-g2012", "-s", "bench", "-o", "bench", *files], cwd=folder, check=True)
    said = subprocess.run(["vvp", "-n", "bench"], cwd=folder, check=True, capture_output=True, text=True).stdout
    found = bytes(int(byte, 16) for byte in re.findall(r"byte (\w\w)", said))
    return frames(found), ("dropped 1" in said) != board.inverted


@pytest.mark.long
def test_the_board_answers_with_the_models_words(package: tuple[Any, Path], tmp_path: Path) -> None:
    """After a break and the load; short and long frames between the good ones have no answer and shift nothing."""
    design, folder = package
    facts = json.loads((folder / "boards" / "line.json").read_text())
    codes = np.array(facts["codes"])[:2]
    start = b""
    if facts["coefficient_bytes"]:
        start = framed(little_endian(microarchitecture(design).loaded, facts["coefficient_bytes"]))
    first, second = (framed(little_endian(one, 2)) for one in codes)
    line = start + first + framed(b"abc") + framed(b"123456789012") + second
    expected = design.model(codes.reshape(2, design.sensor.rows, -1)).words
    found, dropped = answers(design, folder, tmp_path, line, 2 * 4 * design.frame_words + 100)
    assert found == [little_endian(words, 4) for words in expected]
    assert dropped
    assert [words[1:] for words in facts["words"][:2]] == expected[:, 1:].tolist()


def test_the_top_module_is_clean(package: tuple[Any, Path]) -> None:
    design, folder = package
    top = folder / "boards" / board_of(design).name / "top.v"
    assert lint.icarus(top, folder / f"{design.name}.v", *folder.glob("testbench/SB_*.v")) == ""


def test_every_port_has_a_pin(package: tuple[Any, Path]) -> None:
    design, folder = package
    board = board_of(design)
    (pins,) = [file for file in (folder / "boards" / board.name).iterdir() if file.suffix in (".lpf", ".pcf")]
    placed = re.findall(r'^(?:LOCATE COMP "(\w+)" SITE|set_io (\w+))', pins.read_text(), re.M)
    assert sorted(first or second for first, second in placed) == sorted(PORTS)
    assert board.clock_hz % BAUD == 0


class Port:
    """A serial port whose other side is the model; what ``talk.py`` needs of pyserial."""

    def __init__(self, facts: dict[str, Any], shift: int) -> None:
        self.facts, self.shift, self.waiting, self.loaded = facts, shift, b"", not facts["coefficient_bytes"]
        self.breaks = 0

    def __enter__(self) -> "Port":
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def send_break(self, _: float) -> None:
        self.breaks += 1

    def reset_input_buffer(self) -> None:
        self.waiting = b""

    def write(self, line: bytes) -> None:
        ((content),) = frames(line)
        if not self.loaded:
            self.loaded = True
            return
        codes = [int.from_bytes(content[n : n + 2], "little", signed=True) for n in range(0, len(content), 2)]
        number = self.facts["codes"].index(codes)
        words = self.facts["words"][number]
        self.waiting += framed(little_endian([number, *words[1:-1], words[-1] + self.shift], 4))

    def read_until(self, end: bytes) -> bytes:
        head, _, self.waiting = self.waiting.partition(end)
        return head + end


@pytest.mark.parametrize("shift", [0, 1])
def test_the_host_compares_every_word(package: tuple[Any, Path], shift: int, monkeypatch: Any, capsys: Any) -> None:
    _, folder = package
    facts = json.loads((folder / "boards" / "line.json").read_text())
    port = Port(facts, shift)
    monkeypatch.setattr("serial.Serial", lambda *_, **__: port)
    names: dict[str, Any] = {"__file__": str(folder / "boards" / "talk.py"), "__name__": "talk"}
    exec((folder / "boards" / "talk.py").read_text(), names)
    assert names["main"]("/dev/null") == shift
    assert capsys.readouterr().out.count("NOT") == shift * len(facts["codes"])
    assert port.breaks == 1
    assert port.loaded


@pytest.mark.long
def test_a_bitstream_is_built(tmp_path: Path) -> None:
    """With the tools of PyPI, which are found beside Python."""
    design, folder = made("ice40", tmp_path)
    script = folder / "boards" / board_of(design).name / "build.sh"
    assert os.access(script, os.X_OK)
    variables = os.environ | {"PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"}
    subprocess.run(["sh", str(script)], env=variables, check=True, cwd=tmp_path)
    (report,) = folder.glob("boards/*/build/report.json")
    fastest = max(json.loads(report.read_text())["fmax"].values(), key=lambda clock: clock["constraint"])
    assert fastest["achieved"] > board_of(design).clock_hz / 1e6
    (image,) = [file for file in report.parent.iterdir() if file.suffix in (".bit", ".bin")]
    assert image.stat().st_size > 10_000


def test_a_missing_tool_is_named(package: tuple[Any, Path], tmp_path: Path) -> None:
    design, folder = package
    script = folder / "boards" / board_of(design).name / "build.sh"
    (tmp_path / "bin").mkdir()
    for tool in ("sh", "dirname"):
        (tmp_path / "bin" / tool).symlink_to(str(shutil.which(tool)))
    command, variables = [str(tmp_path / "bin" / "sh"), str(script)], {"PATH": str(tmp_path / "bin")}
    done = subprocess.run(command, env=variables, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (1, "yosys is missing\n")
