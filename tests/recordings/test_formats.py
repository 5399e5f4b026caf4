"""The same frames in every form are the same stress, bit for bit; every key of [input] undoes what a logger did."""

import itertools
import random
import re
from contextlib import suppress
from dataclasses import fields, replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tfra.model.choices import Adc
from tfra.model.sensor import SensorArray
from tfra.recordings import formats as all_formats
from tfra.recordings.formats import suffixes, wrong_shape
from tfra.recordings.frames import Recording, read_recording
from tfra.recordings.input import PLAIN, Input
from tfra.runtime.errors import InputError

SENSOR = SensorArray(2, 3, 4e-3, 2e-3, 3e-3)
ADC = Adc(12, 150e3)
FRAMES = np.arange(24.0).reshape(4, 2, 3) - 7.25
LINES = FRAMES.reshape(4, 6)
TIMES = np.array([0.5, 0.25, 3.0, -1.0])


def read(path: Path, how: Input = PLAIN, sensor: SensorArray = SENSOR) -> Recording:
    return read_recording(path, sensor, ADC, how)


def refusal(path: Path, how: Input = PLAIN) -> str:
    with pytest.raises(InputError) as caught:
        read(path, how)
    return str(caught.value).removeprefix(f"{path}: ")


def text(separator: str, point: str, headings: str = "", time: bool = False, end: str = "\n") -> str:
    """``LINES`` as text, written by hand."""
    rows = [[repr(float(TIMES[n]))] * time + [repr(float(x)) for x in line] for n, line in enumerate(LINES)]
    return headings + "".join(separator.join(row).replace(".", point) + end for row in rows)


SEPARATORS = {"comma": ",", "comma, blank": ", ", "semicolon": ";", "tab": "\t", "bar": "|", "bars, blanks": " | "}
BLANKS = {"blank": " ", "blanks": "   ", "tab and blanks": " \t "}


@pytest.mark.parametrize("suffix", ["csv", "txt", "tsv", "CSV"])
@pytest.mark.parametrize("separator", (SEPARATORS | BLANKS).values(), ids=SEPARATORS | BLANKS)
@pytest.mark.parametrize("point", [".", ","])
def test_text(tmp_path: Path, suffix: str, separator: str, point: str) -> None:
    if separator.startswith(",") and point == ",":
        return
    path = tmp_path / f"f.{suffix}"
    heads = "# a comment; with, all | of\tthem\n" + separator.join("abcdef") + "\n#\n"
    for headings, end in itertools.product(("", heads), ("\n", " \n" if separator.isspace() else f"{separator}\n")):
        path.write_text(text(separator, point, headings, end=end))
        found = read(path)
        np.testing.assert_array_equal(found.frames, FRAMES)
        assert found.time is None
        path.write_text(text(separator, point, "", True, end))
        found = read(path, Input(skip_columns=1))
        np.testing.assert_array_equal(found.frames, FRAMES)
        assert found.time is not None
        assert found.time.tolist() == TIMES.tolist()
        assert not found.seconds


def test_skipped_columns_of_text(tmp_path: Path) -> None:
    path = tmp_path / "f.csv"
    path.write_text("time,number,a,b,c,d,e,f\n12:30:01,0,1,2,3,4,5,6\n12:30:02,1,7,8,9,10,11,12\n")
    found = read(path, Input(skip_columns=2))
    assert found.frames.tolist() == [[[1, 2, 3], [4, 5, 6]], [[7, 8, 9], [10, 11, 12]]]
    assert found.time is None
    path.write_text("1,0,1,2,3,4,5,6\n1e999,1,7,8,9,10,11,12\n")
    assert read(path, Input(skip_columns=2)).time is None
    reason = "line 1: 6 numbers (2 rows x 3 columns) after 1 skipped column are needed, got "
    assert refusal(path, Input(skip_columns=1)) == (
        f"{reason}8: are other columns than taxels first (--skip-columns 2) or last (--columns 2-7)?"
    )
    path.write_text("1,2,3,4,5,6\n")
    assert refusal(path, Input(skip_columns=1)) == f"{reason}6: are all columns taxels? (--skip-columns 0)"
    path.write_text("t,0,1,2,3,4,5\n1,2,3,4,5,6,7\n")
    assert refusal(path, Input(skip_columns=1)).endswith("from 0 to 5 are headings, not stress: remove the line")


def test_a_separator_is_chosen_by_what_fits(tmp_path: Path) -> None:
    """Numbers with commas between blanks would also be numbers between commas, were they as many."""
    path = tmp_path / "f.txt"
    path.write_text("1,5 2,5 3,5 4,5 5,5 6,5\n")
    assert read(path).frames.ravel().tolist() == [1.5, 2.5, 3.5, 4.5, 5.5, 6.5]
    path.write_text("1, 2, 3, 4, 5, 6\n")
    assert read(path).frames.ravel().tolist() == [1, 2, 3, 4, 5, 6]
    path.write_text("R1.1;R1.2;R1.3;R2.1;R2.2;R2.3\n1,5;2;3;4;5;6\n")
    assert read(path).frames.ravel().tolist() == [1.5, 2, 3, 4, 5, 6]


def arrays(path: Path, values: np.ndarray, **more: np.ndarray) -> None:
    if path.suffix == ".npz":
        np.savez(path, frames=values, **more)
    else:
        np.save(path, values)


@pytest.mark.parametrize("suffix", ["npy", "npz"])
def test_shapes_of_arrays(tmp_path: Path, suffix: str) -> None:
    path, across, turned = tmp_path / f"f.{suffix}", FRAMES.transpose(0, 2, 1), Input(order="columns")
    for values, how, expected in (
        *(
            (FRAMES, PLAIN, FRAMES),
            (LINES, PLAIN, FRAMES),
            (FRAMES[2], PLAIN, FRAMES[2:3]),
            (LINES[2], PLAIN, FRAMES[2:3]),
        ),
        *((across, turned, FRAMES), (across.reshape(4, 6), turned, FRAMES), (across[1], turned, FRAMES[1:2])),
        (FRAMES, Input(skip_columns=2), FRAMES),  # no columns of lines there
    ):
        arrays(path, values)
        np.testing.assert_array_equal(read(path, how).frames, expected)
    arrays(path, np.column_stack([TIMES, [9, 9, 9, 9], LINES]))
    found = read(path, Input(skip_columns=2))
    np.testing.assert_array_equal(found.frames, FRAMES)
    np.testing.assert_array_equal(found.time, TIMES)
    arrays(path, LINES)
    assert refusal(path, Input(skip_columns=1)).endswith("got (4, 6): are all columns taxels? (--skip-columns 0)")
    arrays(path, FRAMES)
    assert refusal(path, Input(order="columns")) == (
        "frames: shape (n, 3, 2) or (n, 6) is needed, got (4, 2, 3): is every frame transposed? (--order rows)"
    )


@given(
    st.integers(2, 64),
    st.integers(2, 64),
    st.integers(0, 9),
    st.booleans(),
    st.lists(st.integers(0, 70) | st.just(4096), max_size=4),
)
def test_no_shape_has_two_meanings(rows: int, columns: int, skip: int, across: bool, any_shape: list[int]) -> None:
    sensor = SensorArray(rows, columns, 1e-3, 1e-3, 1e-3)
    how = Input(order="columns" if across else "rows", skip_columns=skip)
    frame, m = ((columns, rows) if across else (rows, columns)), rows * columns
    lines, frames = ((rows, m + skip), (columns, m + skip)), ((rows, *frame), (columns, *frame))
    for shape in (tuple(any_shape), frame, frame[::-1], (m,), *lines, *frames):
        single = shape in (frame, (m,))
        meanings = [single, len(shape) == 2 and shape[1] == m + skip, len(shape) == 3 and shape[1:] == frame]
        assert sum(meanings) <= 1
        assert (wrong_shape(sensor, how, shape) is None) == any(meanings)


def test_times_of_an_archive(tmp_path: Path) -> None:
    path = tmp_path / "f.npz"
    np.savez(path, frames=FRAMES, time=TIMES)
    np.testing.assert_array_equal(read(path).time, TIMES)
    for other in (np.zeros(3), np.array(list("abcd")), np.array([0, 1, np.nan, 2]), np.zeros((4, 1))):
        np.savez(path, frames=FRAMES, time=other)
        assert read(path).time is None
        np.testing.assert_array_equal(read(path).frames, FRAMES)


# A format of its own


def test_a_new_format_is_a_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """No other file has to know it; its packages are asked for before it reads."""
    (tmp_path / "raw.py").write_text(
        "import numpy as np\n"
        "from tfra.recordings.formats import Format, Values\n"
        "def read(file, sensor, given):\n"
        "    return Values(np.fromfile(file).reshape(-1, sensor.taxels))\n"
        "FORMAT = Format(('.raw',), read, needs=('raw', 'numpy'))\n"
    )
    monkeypatch.setattr(all_formats, "__path__", [*all_formats.__path__, str(tmp_path)])
    all_formats.formats.cache_clear()
    try:
        FRAMES.tofile(tmp_path / "f.raw")
        np.testing.assert_array_equal(read(tmp_path / "f.raw").frames, FRAMES)
        monkeypatch.setattr("tfra.runtime.errors.find_spec", lambda name: None)
        assert refusal(tmp_path / "f.raw") == "numpy is missing, please run: pip install 'tfra[raw]'"
    finally:
        all_formats.formats.cache_clear()


# Parquet


def parquet(path: Path, table: dict[str, Any]) -> Path:
    pl.DataFrame(table).write_parquet(path)
    return path


def test_parquet(tmp_path: Path) -> None:
    path = tmp_path / "f.parquet"
    whole = np.arange(24).reshape(4, 6).astype(np.int16)
    found = read(parquet(path, {f"taxel_{k}": whole[:, k] for k in range(6)}))
    assert found.frames[3].tolist() == [[18, 19, 20], [21, 22, 23]]
    columns: dict[str, Any] = {f"taxel_{k}": LINES[:, k] for k in range(6)}
    found = read(parquet(path, {"t": TIMES, "note": list("abcd"), **columns}), Input(skip_columns=2))
    np.testing.assert_array_equal(found.frames, FRAMES)
    np.testing.assert_array_equal(found.time, TIMES)
    for values in (pl.Series(LINES.tolist()), pl.Series(FRAMES)):
        found = read(parquet(path, {"n": ["a", "b", "c", "d"], "stress": values}), Input(skip_columns=1))
        np.testing.assert_array_equal(found.frames, FRAMES)
        assert found.time is None
    small = pl.Series(LINES.astype(np.float32).tolist(), dtype=pl.List(pl.Float32))
    np.testing.assert_array_equal(read(parquet(path, {"stress": small})).frames, FRAMES)


def test_wrong_parquet(tmp_path: Path) -> None:
    path = tmp_path / "f.parquet"
    columns: dict[str, Any] = {f"t{k}": LINES[:, k] for k in range(6)}
    assert refusal(parquet(path, {"t": TIMES, **columns})) == (
        "frames: shape (n, 2, 3) or (n, 6) is needed, got (1, 7): is the first column a time stamp? (--skip-columns 1)"
    )
    assert refusal(parquet(path, columns | {"t2": list("abcd")})) == "column 't2': real numbers are needed, got String"
    assert refusal(parquet(path, {"a": [[1.0], [1.0, 2.0]]})).startswith("column 'a': all lists must have the same len")
    assert refusal(parquet(path, {"a": [[1.0] * 6, [1.0] * 5 + [None]]})) == "column 'a': lacks a value, first at 11"
    empty = {name: np.empty(0) for name in columns}
    assert refusal(parquet(path, empty)) == "frames: at least one frame is needed, got none"
    good = parquet(path, columns).read_bytes()
    path.write_bytes(good[:-20])
    assert refusal(path) == "is not a Parquet file, or ends early"
    path.write_bytes(b"PAR1" + b"x" * 50 + b"PAR1")
    assert refusal(path) == "is not a readable Parquet file: is it damaged?"
    assert refusal(tmp_path / "none.parquet") == "cannot be read: No such file or directory"


def test_damaged_parquet(tmp_path: Path) -> None:
    """The process lives on, whatever polars makes of a damaged file: numbers, or a line."""
    path = parquet(tmp_path / "f.parquet", {"skin": LINES.tolist()})
    good, draw = path.read_bytes(), random.Random(3)
    for _ in range(4):
        damaged = bytearray(good)
        for _ in range(3):
            damaged[draw.randrange(4, len(good) - 4)] = draw.randrange(256)
        path.write_bytes(damaged)
        with suppress(InputError):
            assert read(path).frames.shape == (4, 2, 3)


# Keys of [input]


def test_the_page_has_every_key_and_format() -> None:
    page = (Path(__file__).parents[2] / "docs" / "recordings.md").read_text()
    rows = "".join(re.findall(r"^\| (`.*?) \|", page, re.MULTILINE))
    for name in (*(field.name for field in fields(Input)), *suffixes()):
        assert f"`{name}`" in rows, name


def logged_line(how: Input, codes: list[list[int]], rest: list[list[int]]) -> list[int]:
    """What a logger writes, independently, of a frame whose true codes, compression negative, are ``codes``."""
    rows, columns = range(len(codes)), range(len(codes[0]))
    places = [(i, j) for i in rows for j in columns] if how.order == "rows" else [(i, j) for j in columns for i in rows]
    sign = -1 if how.compression == "positive" else 1
    zero = 1 << (ADC.bits - 1) if how.coding == "offset" else 0
    seen = [(rows[-1 - i] if how.flip_y else i, columns[-1 - j] if how.flip_x else j) for i, j in places]
    return [sign * codes[i][j] + zero + rest[i][j] for i, j in seen]


SMALL = st.integers(-500, 500)


@st.composite
def logged(draw: st.DrawFn) -> tuple[Input, list[list[list[int]]], list[list[int]]]:
    rows, columns, n = draw(st.integers(2, 4)), draw(st.integers(2, 4)), draw(st.integers(1, 4))
    how = Input(
        unit="codes",
        compression=draw(st.sampled_from(["negative", "positive"])),
        coding=draw(st.sampled_from(["signed", "offset"])),
        order=draw(st.sampled_from(["rows", "columns"])),
        flip_x=draw(st.booleans()),
        flip_y=draw(st.booleans()),
        tare_frames=draw(st.sampled_from([0, 1, 2])),
    )
    grid = st.lists(st.lists(SMALL, min_size=columns, max_size=columns), min_size=rows, max_size=rows)
    rest = draw(grid) if how.tare_frames else [[0] * columns] * rows
    codes = [[[0] * columns] * rows] * how.tare_frames + [draw(grid) for _ in range(n)]
    return how, codes, rest


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(found=logged(), skip=st.integers(0, 2))
def test_any_logger_is_undone(tmp_path: Path, found: tuple[Any, ...], skip: int) -> None:
    how, codes, rest = found
    sensor = SensorArray(len(rest), len(rest[0]), 1e-3, 1e-3, 1e-3)
    lines = [logged_line(how, frame, rest) for frame in codes]
    rows = [["7"] * skip + [str(number) for number in line] for line in lines]
    (tmp_path / "f.csv").write_text("".join(";".join(row) + "\n" for row in rows))
    np.save(tmp_path / "f.npy", np.array([[int(cell) for cell in row] for row in rows], dtype=np.int32))
    for suffix in ("csv", "npy"):
        stress = read(tmp_path / f"f.{suffix}", replace(how, skip_columns=skip), sensor).frames
        lsb = Fraction(ADC.full_scale) / 2 ** (ADC.bits - 1)
        assert stress.tolist() == [[[float(c * lsb) for c in row] for row in frame] for frame in codes]


def one(tmp_path: Path, values: list[float], how: Input, adc: Adc = ADC) -> list[float]:
    np.save(tmp_path / "f.npy", np.array([values]))
    frames = read_recording(tmp_path / "f.npy", SENSOR, adc, how).frames
    return frames.ravel().tolist()  # type: ignore[no-any-return]  # NumPy's has no type


def test_corners_of_units(tmp_path: Path) -> None:
    adc = Adc(12, 204800.0)  # 100 Pa a code
    codes = Input(unit="codes")
    assert one(tmp_path, [-2048, 2047, 0, 1, -1, 5], codes, adc) == [-204800, 204700, 0, 100, -100, 500]
    offset = replace(codes, coding="offset")
    assert one(tmp_path, [0, 4095, 2048, 2049, 2047, 1], offset, adc) == [-204800, 204700, 0, 100, -100, -204700]
    unipolar = replace(codes, coding="unipolar", compression="positive")
    assert one(tmp_path, [0, 4095, 2048, 1, 2, 3], unipolar, adc) == [0, -204700, -102400, 0, -100, -100]
    kilo = Input(unit="kPa")
    numbers = [1.1, -0.3, 0, 1e-9, 7, 2**-60]
    assert one(tmp_path, numbers, kilo) == [float(1000 * Fraction(x)) for x in numbers]
    assert one(tmp_path, [1, -2, 3, 4, 5, 0.1], Input(compression="positive")) == [-1, 2, -3, -4, -5, -0.1]


def test_a_plain_recording_is_its_own_stress(tmp_path: Path) -> None:
    values = np.random.default_rng(0).normal(size=(5, 2, 3)) * np.array(-0.0)
    np.save(tmp_path / "f.npy", values)
    assert read(tmp_path / "f.npy").frames.tobytes() == values.tobytes()


def test_tare(tmp_path: Path) -> None:
    rest = np.array([[1.0, 2, 3, 4, 5, 6], [3, 2, 1, 0, -1, -2]])  # its mean: 2 everywhere
    np.save(tmp_path / "rest.npy", rest)
    (tmp_path / "f.csv").write_text("".join(" ".join(map(str, line)) + "\n" for line in [*rest, *LINES]))
    found = read(tmp_path / "f.csv", Input(tare_frames=2)).frames
    np.testing.assert_array_equal(found.reshape(6, 6), np.concatenate([rest, LINES]) - 2)
    for how in (Input(), Input(unit="kPa"), Input(compression="positive"), Input(order="columns", flip_x=True)):
        taken = read(tmp_path / "f.csv", replace(how, tare=tmp_path / "rest.npy")).frames
        np.testing.assert_array_equal(taken, read(tmp_path / "f.csv", replace(how, tare_frames=2)).frames)
    assert refusal(tmp_path / "f.csv", Input(tare_frames=7)) == (
        "frames: the first 7 frames are the tare, the recording has 6 (--tare-frames)"
    )
    with pytest.raises(InputError, match=r"none\.npy: cannot be read"):
        read(tmp_path / "f.csv", Input(tare=tmp_path / "none.npy"))
    np.save(tmp_path / "rest.npy", np.full((1, 6), np.nan))
    with pytest.raises(InputError, match=r"rest\.npy: frames: frame 0, row 0, column 0 is not finite"):
        read(tmp_path / "f.csv", Input(tare=tmp_path / "rest.npy"))


def test_unsigned_codes_are_read_as_the_hint_says(tmp_path: Path) -> None:
    """At rest at half of the range, or anywhere else."""
    for rest, hint in ((2048, "(--coding offset)"), (600, "at about 600? (--coding unipolar --rest-code 600)")):
        np.save(tmp_path / "f.npy", np.array([[rest, rest, rest + 1500, rest, rest - 3, rest]]))
        assert hint in refusal(tmp_path / "f.npy", Input(unit="codes"))
        given = Input("codes", coding="offset") if rest == 2048 else Input("codes", coding="unipolar", rest_code=600.0)
        assert (read(tmp_path / "f.npy", given).frames[0, 0, :2] == 0).all()


def test_frames_of_a_file_are_averaged(tmp_path: Path) -> None:
    """The time is that of the last; what is left over is in none; the tare counts means."""
    raw = np.arange(5 * 6).reshape(5, 6) ** 2
    np.savetxt(tmp_path / "f.csv", np.column_stack([0.5 * np.arange(5), raw]), delimiter=",")
    how = Input(unit="codes", skip_columns=1, average=2)
    found = read(tmp_path / "f.csv", how)
    assert found.time is not None
    assert found.time.tolist() == [0.5, 1.5]
    lsb = read(tmp_path / "f.csv", replace(how, average=1)).frames[0, 0, 1]
    assert (found.frames == np.rint(raw[:4].reshape(2, 2, 2, 3).mean(axis=1) + 1e-9) * lsb).all()
    assert found.doubts == ()
    assert (read(tmp_path / "f.csv", replace(how, tare_frames=1)).frames[0] == 0).all()
    few = "frames: 8 of them are one frame, the recording has 5 (--average)"
    assert refusal(tmp_path / "f.csv", replace(how, average=8)).endswith(few)


def test_codes_may_be_means(tmp_path: Path) -> None:
    """Those of the core's counts are silent, however they are printed; other fractions are told."""
    codes = np.random.default_rng(3).integers(-2000, 2000, (8, 64, 6))
    for count in (2, 4, 64):
        np.savetxt(tmp_path / "f.csv", codes[:, :count].mean(axis=1), delimiter=",", fmt="%.2f")
        assert read(tmp_path / "f.csv", Input(unit="codes")).doubts == ()
    np.savetxt(tmp_path / "f.csv", codes[:, :10].mean(axis=1), delimiter=",", fmt="%.1f")
    (told,) = read(tmp_path / "f.csv", Input(unit="codes")).doubts or ()
    reason = "that no mean of 2, 4, ... 64 codes has: is the unit Pa or kPa? (--unit)"
    assert re.fullmatch(rf"codes have fractions, as -?[\d.]+, {re.escape(reason)}", told)


@pytest.mark.parametrize(
    ("value", "coding", "said"),
    [
        (2048, "signed", "are they unsigned, at rest at about 0? (--coding unipolar)"),
        (-1, "offset", "offset codes of 12 bits are from 0 to 4095: are they signed? (--coding signed)"),
        (-1, "unipolar", "unipolar codes of 12 bits are from 0 to 4095: are they signed? (--coding signed)"),
        (70000, "offset", "codes of 12 bits are from 0 to 4095: is the unit Pa or kPa? (--unit)"),
    ],
)
def test_what_is_no_code(tmp_path: Path, value: float, coding: Any, said: str) -> None:
    np.save(tmp_path / "f.npy", np.array([[0, 0, value, 0, 0, 0]]))
    how = Input(unit="codes", coding=coding)
    assert f"frames: frame 0, row 0, column 2 is {value:g}, " in refusal(tmp_path / "f.npy", how)
    assert said in refusal(tmp_path / "f.npy", how)
    assert f"row 1, column 1 is {value:g}, " in refusal(tmp_path / "f.npy", replace(how, order="columns", flip_y=True))
