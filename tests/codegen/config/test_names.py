"""Names of cores: keywords and ports are refused, and the list of ports is complete."""

import shutil
import subprocess
from pathlib import Path

import pytest

from tfra.codegen.config.names import KEYWORDS, PACKAGED, PORTS, check_packaged, checked, name_from
from tfra.codegen.verilog.emit import Top
from tfra.model.choices import Architecture
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.sensor import SensorArray


def test_keywords_of_ieee_1800_2017() -> None:
    """Annex B has 248 words; these are first, last, and those that are names of sensors."""
    assert len(KEYWORDS) == 248
    assert {"accept_on", "xor", "small", "medium", "large", "soft", "strong", "config", "always", "module"} <= KEYWORDS


def test_ports() -> None:
    design = TfraDesign(SensorArray(2, 2, 4e-3, 4e-3, 3e-3), architecture=Architecture(4), images="load")
    assert set(Top(design).signature.members) | {"clk", "rst"} == PORTS


@pytest.mark.parametrize(
    ("word", "kind"),
    [
        *[("module", "a keyword of Verilog"), ("small", "a keyword of Verilog"), ("clk", "a port of the core")],
        *[("wreal", "a keyword of Verilog simulators"), ("skin__core", "like a module inside of a core")],
    ],
)
def test_words_that_are_taken(word: str, kind: str) -> None:
    with pytest.raises(ValueError, match=rf'^name: "{word}" is {kind}$'):
        checked(word)
    with pytest.raises(ValueError, match=rf'^name: is missing, and the file\'s own, "{word}", is {kind}: set another'):
        name_from(word)


@pytest.mark.parametrize(
    ("word", "reason"),
    [
        *[(word, "a keyword of VHDL, which a package is used in$") for word in ("signal", "Signal")],
        *[("double", "a keyword of C,"), ("lambda", "a keyword of Python,"), ("lappend", "a keyword of Tcl,")],
        *[(word, "no name in VHDL, which has no") for word in ("skin_", "my__skin")],
    ],
)
def test_words_that_no_package_may_be_called(word: str, reason: str) -> None:
    """A core alone may: its Verilog knows none of these languages."""
    assert checked(word) == word
    with pytest.raises(ValueError, match=rf'^name: "{word}" is {reason}'):
        check_packaged(word)


def test_words_of_languages_are_complete() -> None:
    """C23 has 54, nine of which begin with an underscore, as no core does."""
    assert len(PACKAGED["C"]) == 54 - 9
    assert {"begin", "entity", "signal", "process", "view"} <= PACKAGED["VHDL"]
    assert {"None", "lambda", "yield"} <= PACKAGED["Python"]
    check_packaged("skin")


def test_icarus_agrees(tmp_path: Path) -> None:
    """A module of a free name compiles, one of a keyword does not."""
    assert [checked(name) for name in ("Module", "skin", "dut", "core")] == ["Module", "skin", "dut", "core"]
    assert shutil.which("iverilog"), "apt-get install iverilog"
    for name in ("small", "module", "logic", "wreal", "skin", "dut"):
        source = tmp_path / f"{name}.v"
        source.write_text(f"module {name}; endmodule\nmodule {name}_tb; {name} dut(); endmodule\n")
        command = ["iverilog", "-g2012", "-o", str(tmp_path / "out"), str(source)]
        assert (subprocess.run(command, capture_output=True, check=False).returncode == 0) == (name in ("skin", "dut"))
