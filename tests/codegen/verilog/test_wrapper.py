"""The Verilog of the wrapper: the standard's ports, no warnings, one core."""

import re
from dataclasses import replace
from pathlib import Path

import pytest

from tests.codegen import lint
from tests.codegen.test_generate import DESIGNS
from tfra.codegen.verilog.emit import to_verilog
from tfra.codegen.verilog.wrapper import module_name, ports_of, wrapper_verilog
from tfra.model.choices import Adc, Bus
from tfra.model.fixed.design import Design

CASES = [DESIGNS["serial"], replace(DESIGNS["even"], bus=Bus(2)), replace(DESIGNS["loaded"], bus=Bus(4))]


@pytest.mark.long
@pytest.mark.parametrize("design", CASES, ids=lambda design: design.name)
def test_plain_verilog_with_one_core(design: Design, tmp_path: Path) -> None:
    """Its ports are the standard's, which the head explains; linters find nothing."""
    text, name = wrapper_verilog(design), module_name(design)
    files = [tmp_path / f"{name}.v", tmp_path / f"{design.name}.v"]
    for file, content in zip(files, (text, to_verilog(design)), strict=True):
        file.write_text(content)
    (tmp_path / "tools").mkdir()
    assert lint.icarus(*files) == ""
    assert lint.verilator(files[0], tmp_path / "tools", rules=["--top-module", name, files[1]]) == ""
    modules = re.findall(r"^module (\w+)\(", text, re.M)
    assert modules[0] == name
    assert all(module.startswith(f"{name}__core") for module in modules[1:])
    assert len(re.findall(rf"^  {design.name} \w+ \($", text, re.M)) == 1
    body = text[text.index("\nmodule ") : text.index("endmodule")]
    for port in ports_of(design):
        size = rf"\[{port.bits - 1}:0\] " if port.bits > 1 else ""
        assert re.search(rf"^  {port.direction}put {size}{port.name};", body, re.M), port.name
        assert re.search(rf"^//   {port.name} ", text, re.M), port.name


@pytest.mark.parametrize("bits", [7, 17])
def test_a_converter_that_does_not_fit_is_refused(bits: int) -> None:
    with pytest.raises(ValueError, match=r"adc\.bits: 8 to 16"):
        wrapper_verilog(replace(DESIGNS["serial"], adc=Adc(bits)))
