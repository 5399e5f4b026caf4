"""The Verilog of the wrapper: the standard's ports, no warnings, one core, the same text every time."""

import re
from dataclasses import replace
from pathlib import Path

import pytest

from tests.codegen import lint
from tests.codegen.test_generate import DESIGNS
from tests.marks import long
from tfra.codegen.verilog.emit import to_verilog
from tfra.codegen.verilog.wrapper import module_name, ports_of, wrapper_verilog
from tfra.model.choices import Adc, Bus
from tfra.model.fixed.design import Design

CASES = {
    "serial": DESIGNS["serial"],
    "even": replace(DESIGNS["even"], bus=Bus(2)),
    "loaded": replace(DESIGNS["loaded"], bus=Bus(4)),
}


@pytest.mark.parametrize("design", ["serial", *long("even", "loaded")])
def test_plain_verilog_with_one_core(design: str, tmp_path: Path) -> None:
    of: Design = CASES[design]
    text = wrapper_verilog(of)
    files = [tmp_path / f"{module_name(of)}.v", tmp_path / f"{of.name}.v"]
    for file, content in zip(files, (text, to_verilog(of)), strict=True):
        file.write_text(content)
    (tmp_path / "tools").mkdir()
    assert lint.icarus(*files) == ""
    top = ["--top-module", module_name(of)]
    assert lint.verilator(files[0], tmp_path / "tools", rules=[*top, files[1]]) == ""
    modules = re.findall(r"^module (\w+)\(", text, re.M)
    inner = f"{module_name(of)}__core"
    assert modules[0] == module_name(of)
    assert all(name.startswith(inner) for name in modules[1:])
    assert len(re.findall(rf"^  {of.name} \w+ \($", text, re.M)) == 1
    assert wrapper_verilog(of) == text


@pytest.mark.long
def test_ports_are_those_of_the_standard() -> None:
    text = wrapper_verilog(CASES["serial"])
    body = text[text.index("\nmodule ") : text.index("endmodule")]
    for port in ports_of(CASES["serial"]):
        name, direction, bits = port.name, port.direction, port.bits
        size = rf"\[{bits - 1}:0\] " if bits > 1 else ""
        assert re.search(rf"^  {direction}put {size}{name};", body, re.M), name
        assert re.search(rf"^//   {name} ", text, re.M), name


@pytest.mark.parametrize("bits", [7, 17])
def test_a_converter_that_does_not_fit_is_refused(bits: int) -> None:
    with pytest.raises(ValueError, match=r"adc\.bits: 8 to 16"):
        wrapper_verilog(replace(DESIGNS["serial"], adc=Adc(bits)))
