"""Every variant of a primitive computes the same in the same cycles, whatever its enable does."""

import re
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bench.scorecard import linters as lint
from tests.hdl.primitives.harness import in_amaranth, in_icarus
from tests.marks import long
from tfra.hdl.primitives import Multiplier, Rom, cell_models
from tfra.model.choices import TARGETS

CYCLES = 120
KINDS = ["amaranth", *TARGETS]
"""The portable variant in Amaranth's simulator, and the Verilog of every target in Icarus."""


def play(kind: str, make: Any, inputs: dict[str, list[int]], outputs: dict[str, int], place: Path) -> list[list[str]]:
    if kind == "amaranth":
        return in_amaranth(make("portable"), inputs, outputs)
    return in_icarus(make(kind), inputs, outputs, kind, place)


def enables(rng: np.random.Generator) -> list[int]:
    """Low in runs and now and then, after two cycles that fill the registers."""
    steps = rng.random(CYCLES) < 0.7
    steps[CYCLES // 2 : CYCLES // 2 + 9] = False
    steps[:2] = True
    return [int(step) for step in steps]


def late(values: list[Any], enable: list[int], latency: int) -> Iterator[tuple[int, Any]]:
    """Cycles, and what stands behind ``latency`` registers in them; cycles before the first value are left out."""
    row: list[Any] = [None] * latency
    for cycle, (value, step) in enumerate(zip(values, enable, strict=True)):
        if row[-1] is not None:
            yield cycle, row[-1]
        row = [value, *row[:-1]] if step else row


def words(rng: np.random.Generator, bits: int) -> list[int]:
    """Random words of random lengths, and the corners of the format first and last."""
    top = (1 << (bits - 1)) - 1
    corners = [-top - 1, -top - 1, top, -1, 0, 1, top, -top - 1]
    free = rng.integers(-top - 1, top, CYCLES - 2 * len(corners), endpoint=True) >> rng.integers(0, bits)
    return [*corners, *(int(word) for word in free), *corners]


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(
    ("a_bits", "b_bits"), [(18, 18), (24, 24), *long((10, 14), (18, 19), (27, 18), (27, 27), (35, 20))]
)
def test_multiplier(kind: str, a_bits: int, b_bits: int, tmp_path: Path) -> None:
    rng = np.random.default_rng(a_bits * b_bits)
    inputs = {"a": words(rng, a_bits), "b": words(rng, b_bits)[::-1], "enable": enables(rng)}
    inputs["b"][:3] = [-(1 << (b_bits - 1))] * 3
    bits = a_bits + b_bits
    seen = play(kind, lambda target: Multiplier(a_bits, b_bits, target), inputs, {"product": bits}, tmp_path)
    products = [a * b for a, b in zip(inputs["a"], inputs["b"], strict=True)]
    checked = 0
    for cycle, product in late(products, inputs["enable"], Multiplier.latency):
        assert int(seen[cycle][0], 16) == product % (1 << bits), cycle
        checked += 1
    assert checked > CYCLES // 2


SHAPES = [
    (1, 5, 18),
    (3, 350, 18),
    *long((2, 512, 18), (2, 513, 18), (4, 1325, 18), (1, 2100, 18), (2, 2600, 10), (2, 900, 24), (3, 2100, 27)),
]
"""Images, their depth, bits: shared memories, memories of their own, several behind one another and side by side."""


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(("number", "depth", "bits"), SHAPES)
def test_rom(kind: str, number: int, depth: int, bits: int, tmp_path: Path) -> None:
    rng = np.random.default_rng(depth)
    images = rng.integers(-(1 << (bits - 1)), 1 << (bits - 1), (number, depth))
    addresses = [0, depth - 1, *(int(place) for place in rng.integers(0, depth, CYCLES - 2))]
    addresses[9:15] = [place % depth for place in (511, 512, 1023, 1024, 2047, 2048)]
    inputs = {"address": addresses, "enable": enables(rng)}
    outputs = {f"words__{n}": bits for n in range(number)}
    seen = play(kind, lambda target: Rom(images, bits, target), inputs, outputs, tmp_path)
    checked = 0
    for cycle, address in late(addresses, inputs["enable"], Rom.latency):
        expected = [word % (1 << bits) for word in images[:, address].tolist()]
        assert [int(word, 16) for word in seen[cycle]] == expected, cycle
        checked += 1
    assert checked > CYCLES // 2


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(("number", "depth", "bits"), [(3, 350, 18), *long((1, 5, 18), (2, 1325, 18), (3, 900, 24))])
def test_loaded(kind: str, number: int, depth: int, bits: int, tmp_path: Path) -> None:
    """What is written in any order is read, and nothing else was."""
    rng = np.random.default_rng(number)
    images, written = rng.integers(-(1 << (bits - 1)), 1 << (bits - 1), (number, depth)), number * depth
    order = [(int(place) // depth, int(place) % depth) for place in rng.permutation(written)]
    addresses = [0, depth - 1, *(int(place) for place in rng.integers(0, depth, CYCLES - 2))]
    inputs = {
        "address": [*(place for _, place in order), *addresses],
        "write": [*(1 << image for image, _ in order), *[0] * CYCLES],
        "data": [*(int(images[place]) for place in order), *words(rng, bits)],
        "enable": [1] * (written + CYCLES),
    }
    outputs = {f"words__{n}": bits for n in range(number)}
    seen = play(kind, lambda target: Rom(images, bits, target, loaded=True), inputs, outputs, tmp_path)
    for cycle, address in late(addresses, [1] * CYCLES, Rom.latency):
        expected = [word % (1 << bits) for word in images[:, address].tolist()]
        assert [int(word, 16) for word in seen[written + cycle]] == expected, cycle


def test_a_wrong_image_is_noticed(tmp_path: Path) -> None:
    images = np.arange(8).reshape(2, 4)
    inputs, outputs = {"address": [3, 3, 3, 3], "enable": [1, 1, 1, 1]}, {"words__0": 18, "words__1": 18}
    images[1, 3] ^= 1
    seen = in_icarus(Rom(images, 18, "ecp5"), inputs, outputs, "ecp5", tmp_path)
    assert [int(word, 16) for word in seen[-1]] == [3, 6]


@pytest.mark.parametrize(
    ("cell", "setting"),
    [
        ("MULT18X18D", '.REG_INPUTC_CLK("CLK0")'),
        ("MULT18X18D", '.REG_OUTPUT_CLK("CLK7")'),
        ("MULT18X18D", '.MULT_BYPASS("ENABLED")'),
        ("MULT18X18D", '.RESETMODE("ASYNC")'),
        ("DP16KD", '.CSDECODE_A("0b001")'),
        ("DP16KD", ".DATA_WIDTH_A(12)"),
        ("DP16KD", ".DATA_WIDTH_B(36)"),
        ("DP16KD", '.REGMODE_B("REG")'),
        ("DP16KD", '.WRITEMODE_A("SOMEHOW")'),
        ("DP16KD", '.WEAMUX("INV")'),
    ],
)
def test_a_mode_without_a_model_is_fatal(cell: str, setting: str, tmp_path: Path) -> None:
    done = ended(f"{cell} #({setting}) cell_ ();", tmp_path)
    assert done.returncode == 1
    assert cell in done.stdout


MODES = [
    *(f'DP16KD #(.DATA_WIDTH_A({a}), .DATA_WIDTH_B({b}))' for a, b in ((1, 2), (4, 9), (18, 18), (36, 36))),
    *(f'DP16KD #(.WRITEMODE_A("{mode}"), .WRITEMODE_B("{mode}"))' for mode in ("WRITETHROUGH", "READBEFOREWRITE")),
    'DP16KD #(.REGMODE_A("OUTREG"), .REGMODE_B("OUTREG"), .CLKAMUX("INV"), .CLKBMUX("INV"))',
    'MULT18X18D #(.REG_INPUTA_CLK("CLK1"), .REG_PIPELINE_CLK("CLK2"), .REG_OUTPUT_CLK("CLK3"))',
]


def test_linters_are_silent_about_every_mode(tmp_path: Path) -> None:
    """With names of rules that Verilator has had since 5.006."""
    models = cell_models("ecp5", "multiplier", "rom")
    cells = " ".join(f"{mode} cell{number} ();" for number, mode in enumerate(MODES))
    (tmp_path / "modes.v").write_text(f"/* verilator lint_off PINMISSING */\nmodule modes; {cells} endmodule\n")
    assert lint.verilator(tmp_path / "modes.v", tmp_path, models) == ""
    off = {rule for model in models for rule in re.findall(r"lint_off (\w+)", model.read_text())}
    assert off <= {"DECLFILENAME", "UNUSED", "WIDTH"}


@pytest.mark.parametrize("port", ["A", "B"])
def test_an_asynchronous_reset_is_fatal_when_it_comes(port: str, tmp_path: Path) -> None:
    for mode, resets, code in (("SYNC", 1, 0), ("ASYNC", 0, 0), ("ASYNC", 1, 1)):
        line = f'reg r = 0; initial #1 r = {resets}; DP16KD #(.RESETMODE("{mode}")) cell_ (.RST{port}(r));'
        assert ended(line, tmp_path).returncode == code
    for clock in ("A", "B"):
        cell = f'DP16KD #(.RESETMODE("ASYNC")) cell_ (.RST{port}(1\'b1), .CLK{clock}(c));'
        assert ended(f"reg c = 0; always #1 c = !c; {cell}", tmp_path).returncode == 1


def ended(line: str, place: Path) -> subprocess.CompletedProcess[str]:
    """Icarus on a module of one ``line``."""
    (place / "tb.v").write_text(f"module tb; {line} initial #9 $finish; endmodule")
    files = [str(file) for file in cell_models("ecp5", "multiplier", "rom")]
    subprocess.run(["iverilog", "-g2012", "-s", "tb", "-o", "tb.vvp", "tb.v", *files], cwd=place, check=True)
    return subprocess.run(["vvp", "-n", "tb.vvp"], cwd=place, capture_output=True, text=True, check=False)
