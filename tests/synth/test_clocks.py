"""The clock that sizes are chosen for: never more than was measured, from the stored reports of place and route."""

import json
from pathlib import Path
from typing import Any

import pytest

from tfra.codegen.package.contents import placed
from tfra.families import TARGETS, find
from tfra.synth.clocks import Clock, clock_of

AIM = "the aim of place and route"


@pytest.fixture
def rows(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Reports that are made up: of two kinds on one part, one without a clock."""

    def row(kind: str, target: str, lowest: float | None) -> dict[str, Any]:
        clock = {"median_mhz": 99.0, "lowest_mhz": lowest} if lowest else None
        return {"architecture": {"kind": kind}, "target": target, "clock": clock}

    made = [
        row("serial", "ice40up5k", 27.0),
        row("serial", "ice40up5k", 26.5),
        row("parallel", "ice40up5k", 12.0),
        row("parallel", "ecp5-45-6", 117.0),
        row("parallel", "gw2a-18", None),
    ]
    file = tmp_path / "measured.json"
    file.write_text(json.dumps(made))
    monkeypatch.setattr("tfra.codegen.package.contents._MEASURED", file)


@pytest.mark.parametrize(
    ("kind", "part", "mhz", "basis"),
    [
        ("serial", "ice40up5k", 26.5, "the slowest serial core measured on ice40up5k"),
        ("parallel", "ice40up5k", 12.0, "the slowest parallel core measured on ice40up5k"),
        ("parallel", "ecp5-45", 98.0, f"{AIM}; parallel cores measured on ecp5-45-6 reach 117 MHz or more"),
        ("serial", "ecp5-45", 98.0, f"{AIM}; no serial core was measured on ecp5-45-6"),
        ("parallel", "gw2a-18", 100.0, "assumed; no parallel core was measured on gw2a-18"),
    ],
)
def test_the_slowest_measured(rows: None, kind: str, part: str, mhz: float, basis: str) -> None:
    assert clock_of(kind, find(part)) == Clock(mhz, basis, measured="no " not in basis)


def test_no_promise_above_a_measurement() -> None:
    """Of the stored reports: each core reaches what is assumed of its kind on its part."""
    found = placed()
    assert len(found) >= 6
    for row in found:
        assert row["clock"]["lowest_mhz"] >= clock_of(row["architecture"]["kind"], TARGETS[row["target"]]).mhz
