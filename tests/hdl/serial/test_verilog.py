"""The portable Verilog of the serial core, in Icarus, computes what the model does."""

import subprocess
from pathlib import Path

import numpy as np
import pytest
from amaranth.back import rtlil

from tests.hdl.serial.designs import DESIGNS, LEARNED
from tests.marks import long
from tfra.codegen.verilog.emit import plain_verilog
from tfra.hdl.cores import as_serial
from tfra.hdl.serial.program.memory import store_image
from tfra.model.cover.scenes import contact_codes
from tfra.sim.tools import choose

CORES = [DESIGNS["short"], *long(LEARNED["short"])]
"""4 × 4 and 3 × 3 taxels."""


@pytest.fixture(scope="module", params=CORES, ids=["TFRA", "learned"])
def design(request):
    return request.param


@pytest.fixture(scope="module")
def verilog(design, tmp_path_factory):
    """Folder of ``core.v``."""
    folder = tmp_path_factory.mktemp("serial")
    text = str(rtlil.convert(as_serial(design).build(), name="serial", emit_src=False))
    (folder / "core.v").write_text(plain_verilog(text, "serial"))
    return folder


def write_hex(path, values, bits):
    path.write_text("".join(f"{int(value) % (1 << bits):x}\n" for value in np.ravel(values)))


def simulate(design, folder, image):
    """Result words ``(n, words)`` and which of them is a frame's last, from ``image`` in the store."""
    choose("icarus")
    codes = contact_codes(design, 2, seed=6)
    want = design.model(codes).words
    coefficient = design.formats.coefficient
    write_hex(folder / "load.hex", image, coefficient)
    write_hex(folder / "taxel.hex", codes, design.adc.bits)
    sizes = {"COEFFICIENT": coefficient, "LOADS": image.size, "ADC": design.adc.bits, "TAXELS": codes.size}
    defines = [f"-D{name}={value}" for name, value in (sizes | {"WORD": design.word_bits, "WORDS": want.size}).items()]
    bench = Path(__file__).parent / "bench.v"
    subprocess.run(["iverilog", "-g2012", *defines, "-o", "bench.vvp", "core.v", bench], cwd=folder, check=True)
    done = subprocess.run(["vvp", "-n", "bench.vvp"], cwd=folder, check=True, capture_output=True, text=True)
    lines = [line.split() for line in done.stdout.splitlines() if "$finish" not in line]
    seen = np.array(lines, dtype=np.int64).reshape(*want.shape, 2)
    return seen[..., 0], seen[..., 1], want


def test_words_equal_the_model(design, verilog):
    words, last, want = simulate(design, verilog, store_image(design))
    assert (words == want).all()
    assert last[:, -1].all()
    assert last.sum() == len(want)


def test_a_wrong_coefficient_is_noticed(design, verilog):
    image = store_image(design)
    image[0, 0] ^= 1 << (design.formats.coefficient - 4)
    words, _, want = simulate(design, verilog, image)
    assert (words != want).any()
