"""Output appears completely or not at all; frames are read from three formats, or refused in one line."""

from __future__ import annotations

import json
import os
import zipfile
from pathlib import Path

import numpy as np
import pytest

from tfra.codegen.files import atomic_directory, atomic_write, check_writable, write_npz
from tfra.codegen.framesfile import read_frames, read_references
from tfra.model.errors import InputError
from tfra.model.sensor import SensorArray

SENSOR = SensorArray(2, 3, 4e-3, 2e-3, 3e-3)
FRAMES = np.arange(24.0).reshape(4, 2, 3) - 7.25


def names(directory: Path) -> list[str]:
    return sorted(path.name for path in directory.iterdir())


# One file


def test_write_replaces(tmp_path: Path) -> None:
    path = tmp_path / "out"
    path.write_bytes(b"old")
    with atomic_write(path) as stream:
        stream.write(b"new")
        stream.flush()
        assert path.read_bytes() == b"old"
    assert path.read_bytes() == b"new"
    assert names(tmp_path) == ["out"]


@pytest.mark.parametrize("interruption", [RuntimeError, KeyboardInterrupt])
def test_interrupted_write_leaves_nothing(tmp_path: Path, interruption: type[BaseException]) -> None:
    def write() -> None:
        with atomic_write(tmp_path / "out") as stream:
            stream.write(b"half")
            raise interruption

    with pytest.raises(interruption):
        write()
    assert names(tmp_path) == []


def test_write_follows_a_link(tmp_path: Path) -> None:
    (tmp_path / "link").symlink_to("real")
    with atomic_write(tmp_path / "link") as stream:
        stream.write(b"new")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "real").read_bytes() == b"new"


def test_written_file_has_the_usual_permissions(tmp_path: Path) -> None:
    (tmp_path / "plain").write_bytes(b"")
    with atomic_write(tmp_path / "out"):
        pass
    assert (tmp_path / "out").stat().st_mode == (tmp_path / "plain").stat().st_mode


@pytest.mark.parametrize(
    ("path", "reason"),
    [
        ("none/out.npz", "cannot be written: No such file or directory"),
        ("file/out.npz", "cannot be written: Not a directory"),
        ("folder.npz", "cannot be written: it is not a regular file"),
        ("x" * 252 + ".npz", "cannot be written: File name too long"),
    ],
)
def test_unwritable_file(tmp_path: Path, path: str, reason: str) -> None:
    (tmp_path / "file").write_bytes(b"")
    (tmp_path / "folder.npz").mkdir()
    with pytest.raises(InputError) as caught:
        check_writable(tmp_path / path, ".npz")
    assert str(caught.value) == f"{tmp_path / path}: {reason}"
    with pytest.raises(InputError):
        write_npz(tmp_path / path, {"a": np.zeros(1)})
    assert names(tmp_path) == ["file", "folder.npz"]


def test_devices_are_not_replaced() -> None:
    with pytest.raises(InputError, match=r"^/dev/null: cannot be written: it is not a regular file$"):
        write_npz("/dev/null", {"a": np.zeros(1)})


def test_check_writable_touches_nothing(tmp_path: Path) -> None:
    path = tmp_path / "out.npz"
    check_writable(path, ".npz")
    assert names(tmp_path) == []
    with pytest.raises(InputError, match=r"out\.npz: the name of the output must end in \.csv$"):
        check_writable(path, ".csv")


def test_npz_has_no_dates(tmp_path: Path) -> None:
    for name in ("a.npz", "b.npz"):
        write_npz(tmp_path / name, {"frames": FRAMES, "shape": np.array(["hertz"])})
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()
    with zipfile.ZipFile(tmp_path / "a.npz") as archive:
        assert {info.date_time for info in archive.infolist()} == {(1980, 1, 1, 0, 0, 0)}


# A directory


def generate(path: Path, text: str = "new", generator: str = "tfra 0.1.0") -> None:
    with atomic_directory(path, "core.json") as fresh:
        (fresh / "core.v").write_text(text)
        (fresh / "core.json").write_text(json.dumps({"generator": generator}))


def test_directory_is_made_and_replaced(tmp_path: Path) -> None:
    out = tmp_path / "out"
    generate(out, "old")
    (out / "stale.v").write_text("")
    generate(out)
    assert names(out) == ["core.json", "core.v"]
    assert (out / "core.v").read_text() == "new"
    assert names(tmp_path) == ["out"]


def test_empty_directory_is_replaced(tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    generate(tmp_path / "out")
    assert names(tmp_path / "out") == ["core.json", "core.v"]


@pytest.mark.parametrize("sidecar", [None, "", "[]", "{}", '{"generator": "npm"}'])
def test_foreign_directory_is_left_alone(tmp_path: Path, sidecar: str | None) -> None:
    out = tmp_path / "out"
    out.mkdir()
    (out / "thesis.tex").write_text("years of work")
    if sidecar is not None:
        (out / "core.json").write_text(sidecar)
    before = names(out)
    with pytest.raises(InputError) as caught:
        generate(out)
    reason = "is not replaced: it is not empty and holds no core.json written by tfra"
    assert str(caught.value) == f"{out}: {reason}"
    assert names(out) == before
    assert names(tmp_path) == ["out"]


def test_unwritable_directory(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match=r"file: cannot be replaced: it is not a directory$"):
        generate(tmp_path / "file")
    with pytest.raises(InputError, match=r"none/out: cannot be written: No such file or directory$"):
        generate(tmp_path / "none" / "out")


def test_failed_generation_keeps_the_old(tmp_path: Path) -> None:
    out = tmp_path / "out"
    generate(out, "old")
    with pytest.raises(RuntimeError), atomic_directory(out, "core.json"):
        raise RuntimeError
    with pytest.raises(ValueError, match=r"core\.json"):
        generate(out, generator="someone")
    assert (out / "core.v").read_text() == "old"
    assert names(tmp_path) == ["out"]


def test_failed_swap_restores_the_old(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    out, rename = tmp_path / "out", os.rename
    generate(out, "old")

    def fail_into_place(source: Path, target: Path) -> None:
        if source.suffix == ".tmp":
            raise OSError(28, "No space left on device")
        rename(source, target)

    monkeypatch.setattr(os, "rename", fail_into_place)
    with pytest.raises(InputError, match=r"out: cannot be written: No space left on device$"):
        generate(out)
    assert (out / "core.v").read_text() == "old"
    assert names(tmp_path) == ["out"]


# Frames


@pytest.mark.parametrize("dtype", [np.float64, np.float32, np.int16])
def test_frames_round_trip(tmp_path: Path, dtype: type[np.generic]) -> None:
    frames = FRAMES.astype(dtype)
    np.savez(tmp_path / "f.npz", frames=frames, mu_ref=np.zeros(4))
    np.save(tmp_path / "f.npy", frames)
    np.savetxt(tmp_path / "f.csv", frames.reshape(4, 6), delimiter=",")
    for suffix in ("npz", "npy", "csv"):
        found = read_frames(tmp_path / f"f.{suffix}", SENSOR)
        assert found.dtype == np.float64
        np.testing.assert_array_equal(found, frames)


def test_references(tmp_path: Path) -> None:
    truth = {"resultant_ref": np.ones((4, 3)), "mu_ref": np.array([0, 1, 2, 3])}
    np.savez(tmp_path / "f.npz", frames=FRAMES, other=np.zeros(1), **truth)
    found = read_references(tmp_path / "f.npz", 4)
    assert list(found) == ["resultant_ref", "mu_ref"]
    assert found["mu_ref"].tolist() == [0.0, 1.0, 2.0, 3.0]
    assert read_references(tmp_path / "f.csv", 4) == {}


@pytest.mark.parametrize(
    ("value", "reason"),
    [
        (np.zeros(3), "shape (4,) is needed, got (3,)"),
        (np.zeros((4, 1)), "shape (4,) is needed, got (4, 1)"),
        (np.array(list("abcd")), "is not a readable array of numbers"),
    ],
)
def test_wrong_references(tmp_path: Path, value: np.ndarray, reason: str) -> None:
    np.savez(tmp_path / "f.npz", frames=FRAMES, mu_ref=value)
    with pytest.raises(InputError) as caught:
        read_references(tmp_path / "f.npz", 4)
    assert str(caught.value) == f"{tmp_path / 'f.npz'}: mu_ref: {reason}"


def test_csv_may_have_headings_blank_lines_and_a_mark(tmp_path: Path) -> None:
    path = tmp_path / "f.csv"
    path.write_bytes(b"\xef\xbb\xbfa,b,c,d,e,f\r\n1, 2,3,4e2,-5,6.5\r\n\r\n")
    assert read_frames(path, SENSOR).tolist() == [[[1, 2, 3], [400, -5, 6.5]]]


WRONG_CSV = [
    ("", "frames: at least one frame is needed, got none"),
    ("a,b\n", "frames: at least one frame is needed, got none"),
    ("1,2,3,4,5,6\n1,2,3,4,5\n", "line 2: 6 numbers (2 rows x 3 columns) are needed, got 5"),
    ("1,2,3,4,5,6,\n", "line 1: 6 numbers (2 rows x 3 columns) are needed, got 7"),
    ("1;2;3;4;5;6\n1;2;3;4;5;6\n", "line 2: 6 numbers (2 rows x 3 columns) are needed, got 1"),
    ("h\n\n1,2,x,4,5,6\n", "line 3: 'x' at position 3 is not a number"),
    ("1,2,,4,5,6\n", "line 1: '' at position 3 is not a number"),
    ("1,2,3,4,5,6\n1,2,3,4,5,nan\n", "frames: frame 1, row 1, column 2 is not finite"),
    ("1,-inf,3,4,5,6\n", "frames: frame 0, row 0, column 1 is not finite"),
]


@pytest.mark.parametrize(("text", "reason"), WRONG_CSV)
def test_wrong_csv(tmp_path: Path, text: str, reason: str) -> None:
    path = tmp_path / "f.csv"
    path.write_text(text)
    with pytest.raises(InputError) as caught:
        read_frames(path, SENSOR)
    assert str(caught.value) == f"{path}: {reason}"


WRONG_ARRAYS = [
    (FRAMES[0], "frames: shape (n, 2, 3) is needed, got (2, 3)"),
    (FRAMES.reshape(4, 3, 2), "frames: shape (n, 2, 3) is needed, got (4, 3, 2)"),
    (FRAMES[:0], "frames: at least one frame is needed, got none"),
    (np.where(FRAMES == 4.75, np.nan, FRAMES), "frames: frame 2, row 0, column 0 is not finite"),
    (FRAMES * 1j, "frames: real numbers are needed, got complex128"),
    (FRAMES.astype(str), "frames: real numbers are needed, got <U32"),
    (FRAMES > 0, "frames: real numbers are needed, got bool"),
]


@pytest.mark.parametrize("suffix", ["npz", "npy"])
@pytest.mark.parametrize(("array", "reason"), WRONG_ARRAYS, ids=[reason for _, reason in WRONG_ARRAYS])
def test_wrong_array(tmp_path: Path, suffix: str, array: np.ndarray, reason: str) -> None:
    path = tmp_path / f"f.{suffix}"
    if suffix == "npz":
        np.savez(path, frames=array)
    else:
        np.save(path, array)
    with pytest.raises(InputError) as caught:
        read_frames(path, SENSOR)
    assert str(caught.value) == f"{path}: {reason}"


def test_missing_key(tmp_path: Path) -> None:
    np.savez(tmp_path / "f.npz", stress=FRAMES, mu=FRAMES)
    with pytest.raises(InputError, match=r"frames: the key is missing, the file has: stress, mu$"):
        read_frames(tmp_path / "f.npz", SENSOR)


@pytest.mark.parametrize("suffix", ["npz", "npy"])
@pytest.mark.parametrize("damage", ["empty", "noise", "truncated", "pickle"])
def test_damaged_file(tmp_path: Path, suffix: str, damage: str) -> None:
    path = tmp_path / f"f.{suffix}"
    array = np.array([{}]) if damage == "pickle" else FRAMES
    if suffix == "npz":
        np.savez(path, frames=array)
    else:
        np.save(path, array)
    good = path.read_bytes()
    path.write_bytes({"empty": b"", "noise": b"noise" * 50, "truncated": good[:-60], "pickle": good}[damage])
    with pytest.raises(InputError, match=r"is not a readable (\.np[yz] file|array) of numbers$"):
        read_frames(path, SENSOR)


def test_mistaken_suffix(tmp_path: Path) -> None:
    np.save(tmp_path / "array.npy", FRAMES)
    np.savez(tmp_path / "archive.npz", frames=FRAMES)
    (tmp_path / "array.npy").rename(tmp_path / "a.npz")
    (tmp_path / "archive.npz").rename(tmp_path / "a.npy")
    for name, reason in {
        "a.npz": "is not a .npz file",
        "a.npy": "is not a .npy file",
        "a.txt": "a name that ends in .npz, .npy or .csv is needed",
        "none.csv": "cannot be read: No such file or directory",
        "none.npz": "cannot be read: No such file or directory",
    }.items():
        with pytest.raises(InputError) as caught:
            read_frames(tmp_path / name, SENSOR)
        assert str(caught.value) == f"{tmp_path / name}: {reason}"
