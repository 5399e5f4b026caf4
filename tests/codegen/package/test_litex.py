"""The package as a module of a LiteX system on chip, whose Verilog yosys reads."""

import importlib.util
from pathlib import Path
from typing import Any

import pytest

from tests.codegen.package.made import PARALLEL, PART
from tfra.codegen.package.contents import Contents
from tfra.codegen.package.projects import litex
from tfra.codegen.sidecar.build import sidecar
from tfra.codegen.verilog.emit import run_yosys, to_verilog
from tfra.codegen.verilog.wrapper import ports_of, wrapper_verilog


def module(folder: Path) -> Any:
    """The module that a package has, imported from its file."""
    contents = Contents(PARALLEL, sidecar(PARALLEL) | {"images": []}, {}, PART)
    ((name, text),) = litex(contents).items()
    file = folder / name
    file.parent.mkdir()
    file.write_text(text)
    spec = importlib.util.spec_from_file_location("lanes_litex", file)
    assert spec is not None
    assert spec.loader is not None
    found = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(found)
    return found


@pytest.mark.long
def test_a_system_with_the_core_is_elaborated(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from litex.build.generic_platform import GenericPlatform, Pins
    from litex.soc.integration.soc import SoCRegion
    from litex.soc.integration.soc_core import SoCMini
    from migen import ClockDomain

    monkeypatch.chdir(tmp_path)
    places = {"clk": 1, "rst": 1, "taxel": 16}
    platform = GenericPlatform("none", [(name, 0, Pins(" ".join("X" * bits))) for name, bits in places.items()])
    soc = SoCMini(platform, clk_freq=int(50e6))
    soc.clock_domains.cd_sys = ClockDomain()
    soc.comb += [soc.cd_sys.clk.eq(platform.request("clk")), soc.cd_sys.rst.eq(platform.request("rst"))]
    soc.submodules.lanes = core = module(tmp_path).Tfra(platform)
    soc.bus.add_slave("lanes", core.bus, SoCRegion(origin=0x9000_0000, size=256, cached=False))
    soc.comb += [core.sink.data.eq(platform.request("taxel")), core.sink.valid.eq(1), core.source.ready.eq(1)]
    soc.finalize()
    verilog = str(platform.get_verilog(soc, name="system"))
    for pin in ports_of(PARALLEL):
        assert f".{pin.name}" in verilog, pin.name
    (tmp_path / "system.v").write_text(verilog)
    (tmp_path / "lanes_axi.v").write_text(wrapper_verilog(PARALLEL))
    (tmp_path / "lanes.v").write_text(to_verilog(PARALLEL))
    read = "read_verilog lanes.v lanes_axi.v system.v"
    run_yosys(f"{read}; hierarchy -check -top system; proc; check -assert", tmp_path)
