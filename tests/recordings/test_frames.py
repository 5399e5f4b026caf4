"""Frames are read, or refused in one line; test_formats.py has other formats and other readings."""

import io
import struct
import warnings
import zipfile
from collections.abc import Callable
from functools import reduce
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.recordings.test_formats import FRAMES, arrays, read, refusal
from tests.recordings.test_log import ARRAY, array, mcap, of
from tfra.recordings.frames import read_references
from tfra.runtime.errors import InputError


@pytest.mark.parametrize("dtype", [np.float64, np.float32, np.int16])
def test_frames_round_trip(tmp_path: Path, dtype: type[np.generic]) -> None:
    frames = FRAMES.astype(dtype)
    for suffix in ("npz", "npy"):
        arrays(tmp_path / f"f.{suffix}", frames)
        found = read(tmp_path / f"f.{suffix}").frames
        assert found.dtype == np.float64
        np.testing.assert_array_equal(found, frames)


def test_references(tmp_path: Path) -> None:
    truth = {"resultant_ref": np.ones((4, 3)), "mu_ref": np.array([0.5, np.nan, 1, 2])}
    np.savez(tmp_path / "f.npz", frames=FRAMES, other=np.zeros(1), **truth)
    found = read_references(tmp_path / "f.npz", 4)
    assert list(found) == ["resultant_ref", "mu_ref"]
    np.testing.assert_array_equal(found["mu_ref"], truth["mu_ref"])
    assert read_references(tmp_path / "f.csv", 4) == {}


@pytest.mark.parametrize(
    ("value", "reason"),
    [
        (np.zeros(3), "shape (4,) is needed, got (3,)"),
        (np.zeros((4, 1)), "shape (4,) is needed, got (4, 1)"),
        (np.ones(4, dtype=bool), "real numbers are needed, got bool"),
        (np.array([0, 1, 2, -1e13]), "frame 3: -1e+13 is no true value"),
    ],
)
def test_wrong_references(tmp_path: Path, value: np.ndarray, reason: str) -> None:
    np.savez(tmp_path / "f.npz", frames=FRAMES, mu_ref=value)
    with pytest.raises(InputError) as caught:
        read_references(tmp_path / "f.npz", 4)
    assert str(caught.value) == f"{tmp_path / 'f.npz'}: mu_ref: {reason}"


@pytest.mark.parametrize(
    "text",
    [
        *(
            "\ufeffa,b,c,d,e,f\r\n1, 2,3,4e2,-5,6.5\r\n\r\n",
            "a,b,c,d,e,f\r1,2,3,400,-5,6.5\r",
            "# stress\n1,2,3,400,-5,6.5",
        ),
        *(f"{headings}\n1,2,3,400,-5,6.5\n" for headings in ('"a","b"', "_1,_2", "p0,,p2", "é,b")),
    ],
)
def test_csv_may_have_headings_blank_lines_a_mark_and_any_line_ends(tmp_path: Path, text: str) -> None:
    (tmp_path / "f.csv").write_text(text, newline="")
    assert read(tmp_path / "f.csv").frames.tolist() == [[[1, 2, 3], [400, -5, 6.5]]]


WRONG_CSV = [
    ("a,b\n", "frames: at least one frame is needed, got none"),
    ("1,2,3,4,5,6\n1,2,3,4,5\n", "line 2: 6 numbers (2 rows x 3 columns) are needed, got 5"),
    ("1;2;3;4;5\n", "line 1: 6 numbers (2 rows x 3 columns) are needed, got 5"),
    ("1;2;3;4;5;6\n1;2;3;4;5,0\n", "line 2: 6 numbers (2 rows x 3 columns) are needed, got 5"),
    (
        "1.5;2;3;4;5;6\n1;2;3;4;5;6\n1;2;3;4;5,25;6\n",
        "line 3: this line has decimal commas, others have decimal points",
    ),
    ("1.234,5;2;3;4;5;6\n", "line 1: this line has decimal commas, others have decimal points"),
    ("1.0.0,2.0.0,3.0.0,4.0.0,5.0.0,6.0.0\n", "line 1: '1.0.0' at position 1 is not a number"),
    ("1,2,0x10,4,5,6\n", "line 1: '0x10' at position 3 is not a number"),
    ("1,2,1e999,4,5,6\n", "frames: frame 0, row 0, column 2 is not finite"),
    ("1,2,3,4,5,-2e12\n", "frames: frame 0, row 1, column 2 is -2e+12 Pa, the limit is 1e+12 Pa"),
    ("1,2,3\0,4,5,6\n", "line 1: a NUL byte is in the text"),
    ("\ufeff", "frames: at least one frame is needed, got none"),
    ("h\n\n1,2,x,4,5,6\n", "line 3: 'x' at position 3 is not a number"),
    ("1,2,,4,5,6\n", "line 1: '' at position 3 is not a number"),
    ("1,2,3,4,5,6\n1,2,3,4,5,nan\n", "frames: frame 1, row 1, column 2 is not finite"),
    ("1,-inf,3,4,5,6\n", "frames: frame 0, row 0, column 1 is not finite"),
]


@pytest.mark.parametrize(("text", "reason"), WRONG_CSV)
def test_wrong_csv(tmp_path: Path, text: str, reason: str) -> None:
    (tmp_path / "f.csv").write_text(text)
    assert refusal(tmp_path / "f.csv") == reason


WRONG_ARRAYS = [
    (FRAMES[None], "frames: shape (n, 2, 3) or (n, 6) is needed, got (1, 4, 2, 3)"),
    (np.float64(1), "frames: shape (n, 2, 3) or (n, 6) is needed, got ()"),
    (FRAMES * 1e200, "frames: frame 0, row 0, column 0 is -7.25e+200 Pa, the limit is 1e+12 Pa"),
    (FRAMES * np.longdouble("1e4000"), "frames: frame 0, row 0, column 0 is not finite"),
    (np.array([[[(1.0, 2)] * 3] * 2], dtype="f8,i4"), "frames: real numbers are needed, got records"),
    (np.zeros((1, 2, 3), dtype="M8[s]"), "frames: real numbers are needed, got datetime64[s]"),
    (np.where(FRAMES == 4.75, np.nan, FRAMES), "frames: frame 2, row 0, column 0 is not finite"),
    (FRAMES.astype(str), "frames: real numbers are needed, got <U32"),
    (FRAMES > 0, "frames: real numbers are needed, got bool"),
]


@pytest.mark.parametrize("suffix", ["npz", "npy"])
@pytest.mark.parametrize(("array", "reason"), WRONG_ARRAYS, ids=[reason for _, reason in WRONG_ARRAYS])
def test_wrong_array(tmp_path: Path, suffix: str, array: np.ndarray, reason: str) -> None:
    arrays(tmp_path / f"f.{suffix}", array)
    assert refusal(tmp_path / f"f.{suffix}") == reason


@pytest.mark.parametrize("suffix", ["npz", "npy"])
@pytest.mark.parametrize("damage", ["empty", "noise", "truncated", "pickle"])
def test_damaged_file(tmp_path: Path, suffix: str, damage: str) -> None:
    path = tmp_path / f"f.{suffix}"
    arrays(path, np.array([{}]) if damage == "pickle" else FRAMES)
    good = path.read_bytes()
    path.write_bytes({"empty": b"", "noise": b"noise" * 50, "truncated": good[:-60], "pickle": good}[damage])
    usual = {"npz": "is not a readable .npz file: File is not a zip file", "npy": "frames: is not a .npy array"}
    special = {
        ("pickle", "npz"): "frames: real numbers are needed, got object",
        ("pickle", "npy"): "frames: real numbers are needed, got object",
        ("truncated", "npy"): "frames: the header promises 192 bytes of numbers, the file has 132",
    }
    assert refusal(path) == special.get((damage, suffix), usual[suffix])


def test_mistaken_suffix(tmp_path: Path) -> None:
    np.save(tmp_path / "array.npy", FRAMES)
    np.savez(tmp_path / "archive.npz", frames=FRAMES)
    (tmp_path / "array.npy").rename(tmp_path / "a.npz")
    (tmp_path / "archive.npz").rename(tmp_path / "a.npy")
    for name, reason in {
        "a.npz": "is not a .npz file but a single array: call it .npy",
        "a.npy": "frames: is not a .npy array: it is a .npz file",
        "a.dat": "a name that ends in .csv, .mcap, .npy, .npz, .parquet, .tsv or .txt is needed, or the folder of a "
        "rosbag2",
        "a.txt": "cannot be read: No such file or directory",
        "none.csv": "cannot be read: No such file or directory",
        "none.npz": "cannot be read: No such file or directory",
    }.items():
        assert refusal(tmp_path / name) == reason


# Headers that promise what is not there


def npy(header: str, data: bytes = b"", version: int = 1) -> bytes:
    text = header.encode()
    return b"\x93NUMPY" + bytes([version, 0]) + struct.pack("<H" if version == 1 else "<I", len(text)) + text + data


def described(shape: str, kind: str = "'<f8'", order: str = "False") -> str:
    return f"{{'descr': {kind}, 'fortran_order': {order}, 'shape': {shape}, }}\n"


SIX = np.arange(1.0, 7.0).tobytes()

HEADERS = [
    (described("(True, 2, 3)"), "frames: the header is damaged: shape (True, 2, 3)"),
    (described("(-1, 2, 3)"), "frames: the header is damaged: "),
    (described("(1.0, 2, 3)"), "frames: the header is damaged: "),
    (described("[1, 2, 3]"), "frames: the header is damaged: "),
    (described("(1, 2, 3)", order="1"), "frames: the header is damaged: "),
    (described("(1, 2, 3)", kind="'<f7'"), "frames: the header is damaged: "),
    (described("(1, 2, 3)", kind="7"), "frames: the header is damaged: "),
    ("{'descr': '<f8'}", "frames: the header is damaged: Header does not contain the correct keys"),
    ("[" * 9000, "frames: the header is damaged: "),
    ("{'shape': " + "9" * 5000 + "}", "frames: the header is damaged: "),
    ("", "frames: the header is damaged: "),
    (described(f"({2**64}, 2, 3)"), "frames: the header promises the impossible shape (18446744073709551616, 2, 3)"),
    (described(f"({2**62}, 2, 3)"), "frames: the header promises 221,360,928,884,514,619,392 bytes of numbers"),
    (described("(2, 2, 3)"), "frames: the header promises 96 bytes of numbers, the file has 48"),
    (described("(0, 2, 3)"), "frames: the header promises 0 bytes of numbers, the file has 48"),
    (described("(1, 2, 3)", kind="'|O'"), "frames: real numbers are needed, got object"),
    (described("(1, 2, 3)", kind="[('a', '<f8')]"), "frames: real numbers are needed, got records"),
    ("x" * 20_000, "frames: the header is damaged: Header info length (20000) is large"),
]


@pytest.mark.parametrize(("header", "reason"), HEADERS, ids=[f"{n}" for n in range(len(HEADERS))])
@pytest.mark.parametrize("suffix", ["npz", "npy"])
def test_headers(tmp_path: Path, suffix: str, header: str, reason: str) -> None:
    path = tmp_path / f"f.{suffix}"
    path.write_bytes(npy(header, SIX) if suffix == "npy" else zipped(npy(header, SIX)))
    assert refusal(path).startswith(reason)


@pytest.mark.parametrize("version", [1, 2, 3])
def test_versions_and_orders(tmp_path: Path, version: int) -> None:
    (tmp_path / "f.npy").write_bytes(npy(described("(1, 2, 3)", order="True"), SIX, version))
    assert read(tmp_path / "f.npy").frames.tolist() == [[[1, 3, 5], [2, 4, 6]]]
    (tmp_path / "f.npy").write_bytes(npy(described("(1, 2, 3)", kind="'>f8'"), SIX[::-1], version))
    assert read(tmp_path / "f.npy").frames.tolist() == [[[6, 5, 4], [3, 2, 1]]]


# Archives


def zipped(data: bytes, method: int = zipfile.ZIP_STORED, name: str = "frames.npy") -> bytes:
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", method) as archive:
        archive.writestr(name, data)
    return packed.getvalue()


METHODS = {
    "stored": zipfile.ZIP_STORED,
    "deflate": zipfile.ZIP_DEFLATED,
    "bzip2": zipfile.ZIP_BZIP2,
    "lzma": zipfile.ZIP_LZMA,
}


@pytest.mark.parametrize(
    ("offset", "value", "reason"),
    [
        (8, 99, "frames: cannot be unpacked: That compression method is not supported"),
        (6, 1, "frames: is encrypted"),
        (14, 7, "frames: is damaged: Bad CRC-32 for file 'frames.npy'"),
    ],
)
def test_unreadable_members(tmp_path: Path, offset: int, value: int, reason: str) -> None:
    """``offset`` is that of the local header; the central directory has the same fields two bytes further on."""
    np.save(data := io.BytesIO(), FRAMES)
    archive = bytearray(zipped(data.getvalue()))
    archive[offset] = archive[archive.index(b"PK\x01\x02") + offset + 2] = value
    (tmp_path / "f.npz").write_bytes(archive)
    assert refusal(tmp_path / "f.npz") == reason


def test_a_member_that_is_shorter_than_it_says(tmp_path: Path) -> None:
    data = npy(described("(9, 2, 3)"), bytes(400))
    archive = bytearray(zipped(data))
    for offset in (22, archive.index(b"PK\x01\x02") + 24):
        archive[offset : offset + 4] = struct.pack("<I", len(data) + 32)
    (tmp_path / "f.npz").write_bytes(archive)
    assert refusal(tmp_path / "f.npz") == "frames: the header promises 432 bytes of numbers, the file ends before them"


@pytest.mark.filterwarnings("ignore:Duplicate name")
def test_a_key_twice(tmp_path: Path) -> None:
    with zipfile.ZipFile(tmp_path / "f.npz", "w") as archive:
        for _ in range(2):
            archive.writestr("frames.npy", npy(described("(1, 2, 3)"), SIX))
    assert refusal(tmp_path / "f.npz") == "frames: the archive holds this key more than once"


def test_a_bomb_is_not_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What an archive promises is compared with the machine's memory before a byte of it is unpacked."""
    monkeypatch.setattr("tfra.recordings.arrays.memory", lambda: 1000)
    (tmp_path / "f.npz").write_bytes(zipped(npy(described("(20, 2, 3)"), bytes(960)), zipfile.ZIP_DEFLATED))
    reason = "frames: the header promises 960 bytes of numbers, more than half of this machine's memory"
    assert refusal(tmp_path / "f.npz") == reason


def test_an_archive_of_no_arrays(tmp_path: Path) -> None:
    (tmp_path / "f.npz").write_bytes(zipped(b"hello", name="frames.npy"))
    assert refusal(tmp_path / "f.npz") == "frames: is not a .npy array"
    (tmp_path / "f.npz").write_bytes(zipped(npy(described("(1, 2, 3)"), SIX, 4)))
    assert refusal(tmp_path / "f.npz") == "frames: version 1, 2 or 3 of the .npy format is needed, got 4.0"
    (tmp_path / "f.npz").write_bytes(zipped(b"hello", name="x" * 30_000))
    assert len(refusal(tmp_path / "f.npz")) < 300


def test_out_of_memory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def exhausted(*_: object, **__: object) -> None:
        raise MemoryError("Unable to allocate 7.45 GiB")

    np.save(tmp_path / "f.npy", FRAMES)
    monkeypatch.setattr("tfra.recordings.arrays.np.empty", exhausted)
    assert refusal(tmp_path / "f.npy") == "there is not enough memory for it: Unable to allocate 7.45 GiB"


# Anything at all


def mutated(good: bytes) -> st.SearchStrategy[bytes]:
    """``good`` with bytes changed, inserted, dropped or doubled."""
    change = st.tuples(st.integers(0, len(good)), st.integers(0, 40), st.binary(max_size=20))

    def apply(data: bytes, change: tuple[int, int, bytes]) -> bytes:
        start, length, new = change
        return data[:start] + new + data[start + length :]

    return st.lists(change, min_size=1, max_size=4).map(lambda changes: reduce(apply, changes, good))


def result_or_line(run: Callable[[], Any], path: Path) -> Any:
    """The result of ``run``, or None if it raises an ``InputError`` of one short line; nothing else and no warning."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            return run()
        except InputError as error:
            line = str(error).removeprefix(str(path))
            assert len(line) <= 300
            assert line.isprintable()
            return None


def good_files() -> dict[str, bytes]:
    text = "a,b,c,d,e,f\n" + "\n".join(",".join(map(str, frame.ravel())) for frame in FRAMES)
    np.save(array := io.BytesIO(), FRAMES)
    files = {f"{method}.npz": zipped(array.getvalue(), number) for method, number in METHODS.items()}
    texts = {"f.csv": text.encode(), "f.txt": text.replace(",", ";").replace(".", ",").encode()}
    return {"f.npy": array.getvalue(), **texts, **files}


@pytest.mark.parametrize("name", ["f.mcap", *good_files()])
@settings(max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_mutated_files(tmp_path: Path, name: str, data: st.DataObject) -> None:
    """Where a file has checksums, a result is right."""
    path = tmp_path / name
    good = good_files()[name] if name != "f.mcap" else mcap(path, of("/a", ARRAY, array)).read_bytes()
    path.write_bytes(data.draw(mutated(good)))
    found = result_or_line(lambda: read(path).frames, path)
    if found is not None and path.suffix in (".npz", ".mcap"):
        np.testing.assert_array_equal(found, FRAMES)
