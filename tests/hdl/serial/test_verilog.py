"""The portable Verilog of the serial core, in Icarus, computes what the model does."""

from __future__ import annotations

import subprocess
from pathlib import Path

import numpy as np
import pytest
from amaranth.back import rtlil

from tests.hdl.serial.designs import DESIGNS
from tfra.codegen.verilog import PASSES, run_yosys
from tfra.hdl.serial.program.memory import store_image
from tfra.hdl.serial.serial import Serial
from tfra.model.cover.scenes import contact_codes
from tfra.model.fixed.tfra.pipeline import FixedTfra
from tfra.sim.tools import choose

DESIGN = DESIGNS["short"]
"""4 × 4 taxels."""

CODES = contact_codes(DESIGN, 2, seed=6)


@pytest.fixture(scope="module")
def verilog(tmp_path_factory):
    """Folder of ``core.v``."""
    folder = tmp_path_factory.mktemp("serial")
    (folder / "core.il").write_text(rtlil.convert(Serial(DESIGN).build(), name="serial", emit_src=False))
    run_yosys(f"read_rtlil core.il; {PASSES} core.v", folder)
    return folder


def write_hex(path, values, bits):
    path.write_text("".join(f"{int(value) % (1 << bits):x}\n" for value in np.ravel(values)))


def simulate(folder, image):
    """Result words ``(n, words)`` and which of them is a frame's last, from ``image`` in the store."""
    choose("icarus")
    want = FixedTfra(DESIGN)(CODES).words
    coefficient = DESIGN.formats.coefficient
    write_hex(folder / "load.hex", image, coefficient)
    write_hex(folder / "taxel.hex", CODES, DESIGN.adc.bits)
    sizes = {"COEFFICIENT": coefficient, "LOADS": image.size, "ADC": DESIGN.adc.bits, "TAXELS": CODES.size}
    defines = [f"-D{name}={value}" for name, value in (sizes | {"WORD": DESIGN.word_bits, "WORDS": want.size}).items()]
    bench = Path(__file__).parent / "bench.v"
    subprocess.run(["iverilog", "-g2012", *defines, "-o", "bench.vvp", "core.v", bench], cwd=folder, check=True)
    done = subprocess.run(["vvp", "-n", "bench.vvp"], cwd=folder, check=True, capture_output=True, text=True)
    lines = [line.split() for line in done.stdout.splitlines() if "$finish" not in line]
    seen = np.array(lines, dtype=np.int64).reshape(*want.shape, 2)
    return seen[..., 0], seen[..., 1], want


def test_words_equal_the_model(verilog):
    words, last, want = simulate(verilog, store_image(DESIGN))
    assert (words == want).all()
    assert last[:, -1].all()
    assert last.sum() == len(want)


def test_a_wrong_coefficient_is_noticed(verilog):
    image = store_image(DESIGN)
    image[0, 0] ^= 1 << (DESIGN.formats.coefficient - 4)
    words, _, want = simulate(verilog, image)
    assert (words != want).any()
