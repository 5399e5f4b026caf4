"""``netlist/prepare.py`` of a package changes a netlist as ``tfra synth`` does, with Python alone."""

import copy
import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from tests.codegen.package.made import ICE40
from tests.codegen.package.test_folder import CONTENTS
from tests.families.ecp5.netlists import mapped
from tests.families.ecp5.test_copies import Lanes
from tests.families.ecp5.test_registers import Times
from tfra.codegen.package.contents import Contents
from tfra.codegen.package.rules import rules
from tfra.families import find


@pytest.mark.parametrize(
    ("block", "part"),
    [(Lanes(9), "ecp5-25"), (Times(before=True), "ecp5-45"), (Times(before=True), "ecp5-12")],
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
