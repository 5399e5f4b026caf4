"""Whatever registers and memories hold before a reset, no result word shows it.

Undefined values (X) show what is looked at before it is known; but a simulator takes an undefined condition for a false
one, so that random values have a say, too.
"""

import random
import re
import subprocess
from functools import partial

import pytest

from tests.marks import long
from tests.model.fixed.learned.cases import learned_design
from tfra.codegen.sidecar.build import sidecar
from tfra.codegen.verilog.emit import to_verilog
from tfra.codegen.verilog.testbench import testbench as written_testbench
from tfra.codegen.verilog.wrapper import module_name, wrapper_verilog
from tfra.hdl.cores import microarchitecture
from tfra.model.choices import SERIAL, Adc, Architecture, Search
from tfra.model.cover.scenes import directed_codes
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.sensor import SensorArray
from tfra.sim.tools import choose


def parallel(steps, words, tolerance=0.0):
    sensor = SensorArray(2, 3, 4e-3, 2e-3, 3e-3)
    return TfraDesign(sensor, adc=Adc(8), search=Search(steps, tolerance), architecture=Architecture(4, words))


DESIGNS = {
    "two candidates": parallel(1, 4),
    "four candidates": parallel(3, 1, 1.5),
    "eight candidates": parallel(7, 4),
    "learned": learned_design(2, 3, adc=Adc(8)),
    "learned, without forces": learned_design(3, 2, adc=Adc(8), taxel_forces=False),
    "serial": TfraDesign(SensorArray(2, 3, 2e-3, 3e-3, 2e-3), adc=Adc(8), search=Search(3), architecture=SERIAL),
}

_REGISTER = re.compile(r"^(  initial \w+) = (\d+)'[^;]*;$", re.M)
_MEMORY = re.compile(r"^\s*reg \[(\d+):0\] (\S+) *\[\d+:0\];$", re.M)


def undefined(bits):
    return f"{bits}'bx"


def randomly(rng, bits):
    return f"{bits}'h{rng.getrandbits(bits):x}"


def _with(value, bits, found):
    return f"{found[1]} = {value(bits)};"


def begin_with(verilog, value, memories):
    """``verilog`` with other initial values of all registers, and of all ``memories`` that are written."""
    verilog = _REGISTER.sub(lambda found: _with(value, int(found[2]), found), verilog)
    if not memories:
        return verilog

    def module(found):
        text = found[0]
        for bits, name in _MEMORY.findall(text):
            place = re.escape(name) + r" *\[[^\]]*\]"
            if re.search(place + r".* <= ", text):
                word = partial(_with, value, int(bits) + 1)
                text = re.sub(rf"({place}) = [^;]*;", word, text)
        return text

    return re.sub(r"^module .*?^endmodule", module, verilog, flags=re.M | re.S)


def ends(design, folder, verilog):
    """The testbench's last line, behind a reset of one cycle; running sums begin with anything but X."""
    choose("icarus")
    name = design.name
    bench = written_testbench(design, sidecar(design)).replace("repeat (4)", "repeat (1)")
    (folder / f"{name}_tb.v").write_text(bench)
    (folder / f"{name}.v").write_text(verilog)
    lanes = range(design.architecture.mac_lanes)
    sums = "".join(f"{name}_tb.dut.core.matvec.lane{lane}.sum = {{$random, $random}};\n" for lane in lanes)
    (folder / "sums.v").write_text(f"module sums; initial @(negedge {name}_tb.rst) begin {sums} end endmodule\n")
    files = [f"{name}.v", "sums.v", f"{name}_tb.v"]
    command = ["iverilog", "-g2012", "-s", f"{name}_tb", "-s", "sums", "-o", "tb", *files]
    subprocess.run(command, cwd=folder, check=True)
    done = subprocess.run(["vvp", "-n", "tb"], cwd=folder, check=False, capture_output=True, text=True)
    return done.stdout.splitlines()[-1]


@pytest.fixture(autouse=True)
def _few_frames(monkeypatch):
    monkeypatch.setattr("tfra.codegen.verilog.testbench.CONTACTS", 2)
    monkeypatch.setattr("tfra.codegen.verilog.testbench.directed_codes", lambda design: directed_codes(design)[:1])


@pytest.mark.parametrize(
    ("name", "seeds"),
    [
        *long(*((name, (None, 1)) for name in DESIGNS)),
    ],
)
def test_nothing_is_left_of_what_was_before_a_reset(name, seeds, tmp_path):
    design = DESIGNS[name]
    assert not microarchitecture(design).cell_models
    verilog, memories = to_verilog(design), name != "serial"  # whose memory begins with constants
    for seed in seeds:
        begun = begin_with(verilog, undefined if seed is None else partial(randomly, random.Random(seed)), memories)
        assert begun.count("'bx") > 50 or seed
        assert ends(design, tmp_path, begun).startswith("PASSED"), f"seed {seed}"


READER = """
module reader;
  reg clock = 0;
  reg resetn = 0;
  reg request = 0;
  wire answered;
  wire [31:0] word;
  always #5 clock = !clock;
  TOP dut(
    .aclk(clock), .aresetn(resetn), .s_axi_araddr(8'hbc), .s_axi_arvalid(request), .s_axi_rready(1'b1),
    .s_axi_rvalid(answered), .s_axi_rdata(word), .s_axi_awvalid(1'b0), .s_axi_wvalid(1'b0), .s_axi_bready(1'b1),
    .s_axis_tvalid(1'b0), .m_axis_tready(1'b1)
  );
  initial begin
    repeat (4) @(negedge clock);
    dut.core.front_end.calibrate.page = 0;
    resetn = 1;
    repeat (4) @(negedge clock);
    request = 1;
    @(negedge clock) request = 0;
    wait (answered) $display("%b", word);
    $finish;
  end
endmodule
"""
"""Reads CALIBRATION_VALUE and nothing before; only the page that is in use outlasts a reset."""


@pytest.mark.long
def test_calibration_value_before_a_place_is_chosen(tmp_path):
    choose("icarus")
    design = DESIGNS["serial"]
    begun = begin_with(wrapper_verilog(design), undefined, memories=False)
    assert begun.count("'bx") > 50
    (tmp_path / "axi.v").write_text(begun)
    (tmp_path / "core.v").write_text(to_verilog(design))
    (tmp_path / "reader.v").write_text(READER.replace("TOP", module_name(design)))
    command = ["iverilog", "-g2012", "-s", "reader", "-o", "tb", "reader.v", "axi.v", "core.v"]
    subprocess.run(command, cwd=tmp_path, check=True)
    done = subprocess.run(["vvp", "-n", "tb"], cwd=tmp_path, check=True, capture_output=True, text=True)
    assert done.stdout.split() == ["0" * 32]
