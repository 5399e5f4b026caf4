"""The header by a C compiler, IP-XACT by an XML parser, the page: each against the map of the gateware."""

import json
import os
import re
import subprocess
import sys
from dataclasses import replace
from html import unescape
from pathlib import Path
from xml.etree import ElementTree

import pytest

from tfra.codegen.registers.files import register_files
from tfra.codegen.registers.source import register_map
from tfra.codegen.registers.values import parameters
from tfra.hdl.bus.map import Kind
from tfra.model.choices import Architecture
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.sensor import SensorArray
from tfra.runtime import errors as packages
from tfra.runtime.errors import InputError

DESIGN = TfraDesign(SensorArray(3, 2, 4e-3, 4e-3, 3e-3), architecture=Architecture(4))
MAP = register_map(parameters(DESIGN))
STRICT = ("-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic")


@pytest.fixture(scope="module")
def files() -> dict[str, str]:
    return register_files(DESIGN)


def test_the_header_in_c(files: dict[str, str], tmp_path: Path) -> None:
    """Offsets, masks, places and reset values, as a strict compiler sees them."""
    (tmp_path / "tfra.h").write_text(files["registers/tfra.h"])
    lines, expected = [], []
    for register in MAP.registers:
        lines.append(f'printf("%lu\\n", (unsigned long)offsetof(tfra_t, {register.name}));')
        expected.append(register.address)
        for field in register.fields:
            name = f"TFRA__{register.name}__{field.name.upper()}"
            shown = {"bm": field.mask, "bp": field.low, "bw": field.bits}
            shown |= {} if field.kind is Kind.STATUS else {"reset": field.reset}
            lines += [f'printf("%lu\\n", (unsigned long){name}_{ending});' for ending in shown]
            expected += shown.values()
    includes = "".join(f"#include {name}\n" for name in ("<stddef.h>", "<stdio.h>", '"tfra.h"'))
    (tmp_path / "shown.c").write_text(f"{includes}int main(void) {{\n" + "\n".join(lines) + "\nreturn 0;\n}\n")
    subprocess.run(["gcc", *STRICT, "-o", "shown", "shown.c"], cwd=tmp_path, check=True)
    done = subprocess.run([tmp_path / "shown"], capture_output=True, text=True, check=True)
    assert [int(word) for word in done.stdout.split()] == expected


def test_names_are_those_of_every_design(files: dict[str, str]) -> None:
    """Of two designs' headers only reset values differ, so one driver serves both."""
    other = register_files(replace(DESIGN, sensor=SensorArray(2, 4, 4e-3, 4e-3, 3e-3)))["registers/tfra.h"]
    lines = [text.splitlines() for text in (files["registers/tfra.h"], other)]
    differ = [mine for mine, its in zip(*lines, strict=True) if mine != its]
    assert differ
    assert all(re.match(r"#define TFRA__\w+_reset 0x", line) for line in differ)


def test_ipxact(files: dict[str, str]) -> None:
    root = ElementTree.fromstring(files["registers/tfra.xml"])
    space = {"x": root.tag[1:].partition("}")[0]}
    assert space["x"].endswith("1685-2014")
    assert root.findtext("x:version", namespaces=space) == "1"
    found = {}
    for register in root.iterfind(".//x:register", space):
        base = register.findtext("x:addressOffset", "", space)
        for field in register.iterfind("x:field", space):
            texts = [field.findtext(f"x:{key}", "", space) for key in ("bitOffset", "bitWidth", "access")]
            texts.append(field.findtext("x:modifiedWriteValue", "", space))
            path = f"{register.findtext('x:name', '', space)}.{field.findtext('x:name', '', space)}"
            found[path] = (int(base.removeprefix("'h"), 16), int(texts[0]), int(texts[1]), *texts[2:])
            described = " ".join(field.findtext("x:description", "", space).split())
            assert described in {f.text for r in MAP.registers for f in r.fields}
    access = {Kind.SETTING: "read-write", Kind.EVENT: "read-write", Kind.PULSE: "write-only", Kind.PORT: "write-only"}
    assert found == {
        f"{r.name}.{f.name}": (
            *(r.address, f.low, f.bits, access.get(f.kind, "read-only")),
            "oneToClear" if f.kind is Kind.EVENT else "",
        )
        for r in MAP.registers
        for f in r.fields
    }


def test_the_page(files: dict[str, str]) -> None:
    """A section with all texts for every register, and nothing that is loaded."""
    page = files["registers/tfra.html"]
    sections = re.findall(r"<section>.*?</section>", page, re.S)
    for section, register in zip(sections, MAP.registers, strict=True):
        assert f'<h2 id="{register.name}">0x{register.address:02X} {register.name}</h2>' in section
        cells = re.findall(r"<t[dh][^>]*>(.*?)</t[dh]>", section)
        assert [unescape(cell) for cell in cells[9::5]] == [field.text for field in register.fields]
        assert register.text in unescape(section)
    assert not re.search(r"(?:src|href)=\"(?!#|data:)", page)


@pytest.mark.long
def test_the_same_design_gives_the_same_files(files: dict[str, str]) -> None:
    """In another process, with other hashes of strings."""
    code = (
        "import sys, json; from tests.codegen.registers.test_files import DESIGN\n"
        "from tfra.codegen.registers.files import register_files\n"
        "json.dump(register_files(DESIGN), sys.stdout)"
    )
    root = Path(__file__).parents[3]
    variables = {**os.environ, "PYTHONHASHSEED": "7", "PYTHONPATH": str(root)}
    done = subprocess.run([sys.executable, "-c", code], cwd=root, env=variables, capture_output=True, check=True)
    assert json.loads(done.stdout) == files


def test_a_missing_package_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(packages, "find_spec", lambda name: None if name == "peakrdl_ipxact" else object())
    with pytest.raises(InputError, match=r"peakrdl-ipxact is missing, please run: pip install 'tfra\[ip\]'"):
        register_files(DESIGN)
