"""Upsets that are planted are seen for what they are: registers that decide all words, and such that nothing reads."""

import re
from pathlib import Path

import pytest

from bench.scorecard.upsets.measure import KINDS, Run, configurations, counted, facts, parsed, public, run, verdict

VARIABLES = "var TOP.a.core.gain.x\nvar TOP.a.core.forces.memory\nvar TOP.a.core.rom.memory\nbits 4 8 9\n"
RIGHT = "0 0 1 1 0 0 0 0 1 0\n1 1 1 1 0 1 2 0 1 0\n2 2 1 1 0 9 9 1 0 0\n"
"""A register outlives its upset, two frames of a written memory are wrong, and a coefficient stays so."""
CONFIGURATION = next(configurations(True))


def judged(text: str) -> tuple[bool, str]:
    found = parsed(text)
    measured = verdict({"a": found}, [facts(CONFIGURATION, found)], True)
    return measured.passed, measured.figure


def test_upsets_are_right_again_after_two_frames() -> None:
    passed, figure = judged(VARIABLES + RIGHT + "sound 1\n")
    assert passed
    assert figure.startswith("3 upsets, 3 of them in effect: wrong untold after 0.00 % (0.00 to 79.30) of those of reg")
    assert parsed(VARIABLES).bits == {"registers": 4, "written": 8, "kept": 9}


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("0 0 1 1 0 0 0 0 1 0", "0 0 1 1 0 1 3 0 1 0"),  # three frames
        ("0 0 1 1 0 0 0 0 1 0", "0 0 1 1 0 0 0 2 1 0"),  # hung
        ("0 0 1 1 0 0 0 0 1 0", "0 0 1 1 3 0 3 1 1 0"),  # stays wrong
        ("0 0 1 1 0 0 0 0 1 0", "0 0 0 1 0 0 0 0 1 0"),  # did not read back
        (
            "0 0 1 1 0 0 0 0 1 0\n1 1 1 1 0 1 2 0 1 0\n2 2 1 1",
            "0 0 1 0 0 0 0 0 1 0\n1 1 1 0 0 0 0 0 1 0\n2 2 1 0",
        ),  # no effect
        ("sound 1", "sound 0"),
        (RIGHT, ""),
    ],
)
def test_the_target_is_missed(old: str, new: str) -> None:
    text = VARIABLES + RIGHT + "sound 1\n"
    assert old in text
    assert not judged(text.replace(old, new))[0]


def test_the_worst_counts_and_its_block_is_named() -> None:
    ends = "0 0 1 1 2 1 3 0 1 0\n0 0 1 1 2 0 2 2 1 1\n0 0 1 1 0 0 0 2 1 0\n"
    found = counted(parsed(VARIABLES + ends).upsets)
    assert [found[name]["count"] for name in ("silent", "told", "hung", "outlived")] == [1, 1, 1, 0]
    assert (found["hang"]["count"], found["hang_with_interrupt"]) == (2, 1)
    assert found["frames_until_right"] == {"3": 1}
    assert found["of_blocks"] == {"gain": 3}


def test_every_register_and_memory_is_public() -> None:
    texts = public(CONFIGURATION.texts)
    lines = [line for line in "".join(texts.values()).splitlines() if re.match(r"\s*(\(\*.*\*\) )?reg\b", line)]
    assert lines
    assert [line for line in lines if not line.endswith("/* verilator public_flat_rw */;")] == []


@pytest.mark.long
def test_planted_registers(tmp_path: Path) -> None:
    configuration = next(one for one in configurations(False) if one.name == "TFRA, serial")
    register = "  reg [7999:0] {0};\n  initial {0} = 8000'd0;\n  always @(posedge clk) if (rst) {0} <= 8000'd0;\n"
    planted = "  reg body;\n  initial body = 1'd0;\n"
    planted += "  always @(posedge clk) if (result_valid & result_ready) body <= ~result_last;\n"
    planted += register.format("stuck") + register.format("spare")
    name = f"{configuration.top}.v"
    text, count = re.subn(
        r"  assign (result_data) = (.*);", rf"{planted}  assign \1 = \2 ^ (body & |stuck);", configuration.texts[name]
    )
    assert count == 1
    found: Run = run(configuration, 400, tmp_path, public(configuration.texts | {name: text}))
    assert found.sound
    assert set(found.bits) == set(KINDS)
    stuck = [one for one in found.upsets if one.name.endswith(".stuck")]
    spare = [one for one in found.upsets if one.name.endswith(".spare")]
    assert min(len(stuck), len(spare)) > 50
    assert {(one.outcome, one.end, one.healed, one.seen, one.effect) for one in stuck} == {
        ("silent", "wrong", True, True, True)
    }
    assert {(one.outcome, one.end, one.span, one.seen, one.effect) for one in spare} == {
        ("outlived", "right", 0, True, True)
    }
