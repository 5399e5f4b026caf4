"""The table of loads: what is read, and one line for everything that is wrong."""

import math
from pathlib import Path

import pytest

from tfra.calibrate.loads import read_loads
from tfra.calibrate.response import Indenter
from tfra.runtime.errors import InputError


def read(folder: Path, text: str):
    (folder / "loads.csv").write_text(text)
    return read_loads(folder / "loads.csv")


def test_a_table_of_everything(tmp_path: Path) -> None:
    rest, weight, pulled, tilted, even = read(
        tmp_path,
        "recording,force_n,tangential_n,direction_deg,tilt_deg,pressure_kpa,indenter,radius_mm,x_mm,y_mm,frames,branch\n"
        "rest,,,,,,,,,,,\n"
        "# a comment\n"
        "a.csv,5,,,,,Flat,4,1.5,-2,12-80,unloading\n"
        "b,5,1.5,-90,,,finger,,,,,\n"
        "c,10,,0,30,,,8,,,,\n"
        "d,,,,,20,,,,,,\n",
    )
    assert rest.at_rest
    assert (weight.normal, weight.indenter, weight.radius) == (5.0, Indenter.FLAT, 0.004)
    assert (weight.place, weight.frames, weight.unloading, weight.line) == ((0.0015, -0.002), (12, 80), True, 4)
    assert (pulled.tangential, pulled.direction, pulled.radius) == (1.5, -math.pi / 2, None)
    assert (tilted.normal, tilted.tangential) == (pytest.approx(10 * math.cos(math.pi / 6)), pytest.approx(5.0))
    assert (even.pressure, even.normal, even.at_rest) == (20e3, 0.0, False)


def test_decimal_commas_between_semicolons(tmp_path: Path) -> None:
    (load,) = read(tmp_path, "recording;force_n\npress;4,905\n")
    assert load.normal == 4.905


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("", "loads.csv: is empty: a header is needed"),
        ("recording,force_n\n", "has no loads below its header"),
        ("force_n\n1\n", 'line 1: a column "recording"'),
        ("recording,force\na,1\n", "line 1: unknown column 'force', the nearest valid one is \"force_n\""),
        ("recording,recording\na,b\n", "line 1: a column is there twice"),
        ("recording,force_n\na,1,2\n", "line 2: 2 cells are needed as in the header, got 3"),
        ("recording,force_n\na,-2\n", "line 2: force_n: a force into the array is positive here, got -2"),
        ("recording,force_n\na,two\n", "line 2: force_n: a valid number"),
        (f"recording,force_n\na,{'1' * 200_000}\n", "line 2: 2 cells are needed as in the header, got 1"),
        ("recording,tangential_n\na,2\n", "line 2: force_n: is needed with a tangential force or a tilt"),
        (
            "recording,force_n,tangential_n\na,1,30\n",
            "line 2: tangential_n: 30 beside 1 N is no friction: is it an angle?",
        ),
        (
            "recording,force_n,tangential_n,tilt_deg\na,1,1,20\n",
            "line 2: tilt_deg: and tangential_n exclude each other",
        ),
        ("recording,force_n,pressure_kpa\na,1,1\n", "line 2: pressure_kpa: and force_n exclude each other"),
        ("recording,force_n,x_mm\na,1,1\n", "line 2: x_mm: a place needs x_mm and y_mm"),
        ("recording,force_n,indenter\na,1,flat\n", "line 2: radius_mm: is needed of a flat punch"),
        (
            "recording,force_n,indenter\na,1,cube\n",
            "line 2: indenter: 'ball', 'flat' or 'finger' is needed, got 'cube'",
        ),
        ("recording,force_n,frames\na,1,9-3\n", "line 2: frames: the first is after the last"),
        ("recording,force_n,frames\na,1,9\n", "line 2: frames: the first and the last frame are needed, as 120-180"),
    ],
)
def test_wrong_tables(tmp_path: Path, text: str, reason: str) -> None:
    with pytest.raises(InputError) as raised:
        read(tmp_path, text)
    assert reason in str(raised.value)
