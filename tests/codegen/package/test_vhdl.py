"""The component for VHDL by GHDL: a design in VHDL instantiates it with the widths of the wrapper's ports."""

import shutil
import subprocess
from pathlib import Path

import pytest

from tests.codegen.package.test_folder import CONTENTS
from tests.marks import long
from tfra.codegen.package.folder import vhdl
from tfra.codegen.verilog.wrapper import ports_of


def top() -> str:
    """An architecture with a signal for every port, and checks of some constants."""
    pins, registers = ports_of(CONTENTS.design), CONTENTS.registers
    kinds = {pin.name: f"std_logic_vector({pin.bits - 1} downto 0)" if pin.bits > 1 else "std_logic" for pin in pins}
    signals = "\n".join(f"signal {name} : {kind};" for name, kind in kinds.items())
    checks = {"C_RESULT_LENGTH": CONTENTS.design.frame_words, "AT_CONTROL": registers["CONTROL"].address}
    checks |= {"C_LATENCY_CYCLES": registers["LATENCY"].fields[0].reset}
    facts = "\n".join(f"assert {name} = {value} severity failure;" for name, value in checks.items())
    maps = ", ".join(f"{name} => {name}" for name in kinds)
    head = "library ieee; use ieee.std_logic_1164.all; use work.lanes_axi_pkg.all; entity top is end;"
    return f"{head}\narchitecture a of top is\n{signals}\nbegin\n{facts}\ncore: lanes_axi port map ({maps});\nend;\n"


@pytest.mark.parametrize(
    ("stated", "other", "seen"),
    [
        ("", "", ""),
        *long(
            ("m_axis_tdata : out std_logic_vector(31", "m_axis_tdata : out std_logic_vector(30", "m_axis_tdata"),
            ("      irq : out std_logic", "      interrupt : out std_logic", "irq"),
            ("AT_CONTROL : natural := 64", "AT_CONTROL : natural := 65", "assertion failure"),
        ),
    ],
)
def test_a_design_instantiates_it(tmp_path: Path, stated: str, other: str, seen: str) -> None:
    assert shutil.which("ghdl"), "ghdl is missing, please run: sudo apt-get install ghdl"
    (component,) = vhdl(CONTENTS).values()
    assert stated in component
    (tmp_path / "component.vhd").write_text(component.replace(stated, other) if stated else component)
    (tmp_path / "top.vhd").write_text(top())
    script = "ghdl -a component.vhd top.vhd && ghdl -e top && ghdl -r top --stop-time=1ns"
    done = subprocess.run(["sh", "-c", script], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (done.returncode == 0) == (not seen), done.stderr
    assert seen in done.stdout + done.stderr
