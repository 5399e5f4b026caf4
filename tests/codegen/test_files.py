"""Output appears completely or not at all; frames are read from three formats, or refused in one line."""

from __future__ import annotations

import os
import zipfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import BinaryIO

import numpy as np
import pytest

from tfra.codegen.files import check_archive, output_directory, write_npz
from tfra.codegen.framesfile import read_frames, read_references
from tfra.codegen.ownership import MANIFEST
from tfra.model.errors import InputError
from tfra.model.sensor import SensorArray

SENSOR = SensorArray(2, 3, 4e-3, 2e-3, 3e-3)
FRAMES = np.arange(24.0).reshape(4, 2, 3) - 7.25


def names(directory: Path) -> list[str]:
    return sorted(path.name for path in directory.iterdir())


def tree(directory: Path) -> dict[str, object]:
    """Everything below ``directory``: a file's bytes, a link's target, None for a directory."""
    return {
        str(path): os.readlink(path) if path.is_symlink() else path.read_bytes() if path.is_file() else None
        for path in directory.rglob("*")
    }


# One archive


ARRAYS = {"frames": FRAMES, "shape": np.array(["hertz"])}


def write(path: Path, value: float = 1.0, command: str = "estimate") -> None:
    write_npz(path, {"a": np.full(3, value)}, command)


def content(path: Path) -> float:
    with np.load(path) as archive:
        assert archive.files == ["a"]
        return float(archive["a"][0])


def refusal(path: Path, run: Callable[[], object]) -> str:
    """Run what must be refused, see that nothing has changed beside ``path``, and return the reason."""
    before = tree(path.parent)
    with pytest.raises(InputError) as caught:
        run()
    assert tree(path.parent) == before
    return str(caught.value).removeprefix(f"{path}: ")


def test_an_archive_is_made_and_replaced(tmp_path: Path) -> None:
    path = tmp_path / "out.npz"
    for value in (1.0, 2.0):
        check_archive(path, "estimate")
        write(path, value)
        assert content(path) == value
        assert names(tmp_path) == ["out.npz"]


@pytest.mark.parametrize("interruption", [RuntimeError, KeyboardInterrupt])
def test_an_interrupted_write_leaves_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, interruption: type[BaseException]
) -> None:
    path = tmp_path / "out.npz"
    write(path)

    def savez(stream: BinaryIO, **arrays: object) -> None:
        stream.write(b"half")
        raise interruption

    monkeypatch.setattr(np, "savez", savez)
    with pytest.raises(interruption):
        write(path, 2.0)
    monkeypatch.undo()
    assert content(path) == 1.0
    assert names(tmp_path) == ["out.npz"]


def test_write_follows_a_link(tmp_path: Path) -> None:
    (tmp_path / "link").symlink_to("real")
    write(tmp_path / "link")
    assert (tmp_path / "link").is_symlink()
    assert content(tmp_path / "real") == 1.0


def test_a_written_file_has_the_usual_permissions(tmp_path: Path) -> None:
    (tmp_path / "plain").write_bytes(b"")
    write(tmp_path / "out.npz")
    assert (tmp_path / "out.npz").stat().st_mode == (tmp_path / "plain").stat().st_mode


@pytest.mark.parametrize(
    ("path", "reason"),
    [
        ("none/out.npz", "cannot be written: No such file or directory"),
        ("file/out.npz", "cannot be written: Not a directory"),
        ("folder.npz", "is not replaced: it is not a regular file: move it away, or choose another place"),
        ("x" * 252 + ".npz", "cannot be written: File name too long"),
    ],
)
def test_unwritable_file(tmp_path: Path, path: str, reason: str) -> None:
    (tmp_path / "file").write_bytes(b"")
    (tmp_path / "folder.npz").mkdir()
    with pytest.raises(InputError) as caught:
        check_archive(tmp_path / path, "estimate")
    assert str(caught.value) == f"{tmp_path / path}: {reason}"
    with pytest.raises(InputError):
        write(tmp_path / path)
    assert names(tmp_path) == ["file", "folder.npz"]


def test_the_longest_name_can_be_written(tmp_path: Path) -> None:
    write(tmp_path / ("x" * 251 + ".npz"))
    assert names(tmp_path) == ["x" * 251 + ".npz"]


def test_devices_are_not_replaced() -> None:
    with pytest.raises(InputError, match=r"^/dev/null: is not replaced: it is not a regular file"):
        write(Path("/dev/null"))


def test_check_touches_nothing(tmp_path: Path) -> None:
    check_archive(tmp_path / "out.npz", "estimate")
    assert names(tmp_path) == []
    with pytest.raises(InputError, match=r"out\.csv: the name of the output must end in \.npz$"):
        check_archive(tmp_path / "out.csv", "estimate")


def test_an_archive_has_no_dates_and_a_seal_that_readers_pass_over(tmp_path: Path) -> None:
    for name in ("a.npz", "b.npz"):
        write_npz(tmp_path / name, ARRAYS, "frames")
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()
    with zipfile.ZipFile(tmp_path / "a.npz") as archive:
        assert {info.date_time for info in archive.infolist()} == {(1980, 1, 1, 0, 0, 0)}
        assert archive.testzip() is None
        assert archive.comment.startswith(b"tfra ")


@pytest.mark.parametrize("foreign", ["a recording", "changed at its start", "changed in its seal", "cut", "longer"])
def test_an_archive_that_is_not_as_it_was_written_stays(tmp_path: Path, foreign: str) -> None:
    path = tmp_path / "out.npz"
    if foreign == "a recording":
        np.savez(path, frames=FRAMES)
    else:
        write(path)
        data = path.read_bytes()
        middle, seal = len(data) // 2, len(data) - 80
        path.write_bytes(
            {
                "changed at its start": data[:middle] + bytes([data[middle] ^ 1]) + data[middle + 1 :],
                "changed in its seal": data[:-1] + (b"0" if data[-1:] != b"0" else b"1"),
                "cut": data[:seal],
                "longer": data + b"notes",
            }[foreign]
        )
    changed = foreign.startswith("changed")
    reason = "it has changed since tfra wrote it" if changed else "tfra did not write it"
    line = f"is not replaced: {reason}: move it away, or choose another place"
    assert refusal(path, lambda: check_archive(path, "estimate")) == line
    assert refusal(path, lambda: write(path)) == line


def test_an_archive_of_another_command_stays(tmp_path: Path) -> None:
    path = tmp_path / "out.npz"
    write(path, command="frames")
    line = "is not replaced: tfra frames wrote it, not tfra estimate: move it away, or choose another place"
    assert refusal(path, lambda: write(path)) == line


def test_an_empty_file_is_replaced(tmp_path: Path) -> None:
    (tmp_path / "out.npz").touch()
    write(tmp_path / "out.npz")
    assert content(tmp_path / "out.npz") == 1.0


@pytest.mark.parametrize("way", ["itself", "link", "hard link"])
def test_an_archive_that_is_read_stays(tmp_path: Path, way: str) -> None:
    path, read = tmp_path / "out.npz", tmp_path / "read.npz"
    write(path)
    if way == "link":
        read.symlink_to(path)
    elif way == "hard link":
        read.hardlink_to(path)
    line = "is not replaced: this command reads it: choose another place"
    source = path if way == "itself" else read
    assert refusal(path, lambda: check_archive(path, "estimate", [tmp_path / "none", source])) == line


# A directory


def generate(path: Path, text: str = "new", command: str = "generate", inputs: Sequence[Path] = ()) -> None:
    with output_directory(path, command, inputs) as fresh:
        (fresh / "core.v").write_text(text)
        (fresh / "images").mkdir()
        (fresh / "images" / "a.hex").write_text(text)


FILES = ["core.v", "images", MANIFEST]


def test_a_directory_is_made_and_replaced(tmp_path: Path) -> None:
    out = tmp_path / "out"
    for text in ("old", "new"):
        generate(out, text)
        assert names(out) == FILES
        assert (out / "core.v").read_text() == (out / "images" / "a.hex").read_text() == text
        assert names(tmp_path) == ["out"]


def test_an_empty_directory_and_one_with_files_missing_are_replaced(tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    generate(tmp_path / "out", "old")
    (tmp_path / "out" / "core.v").unlink()
    generate(tmp_path / "out")
    assert names(tmp_path / "out") == FILES


def test_a_link_to_a_directory_stays_one(tmp_path: Path) -> None:
    (tmp_path / "link").symlink_to("real")
    for text in ("old", "new"):
        generate(tmp_path / "link", text)
        assert (tmp_path / "link").is_symlink()
        assert (tmp_path / "real" / "core.v").read_text() == text


SIDECAR = '{"generator": "tfra 0.1.0"}'
WRONG_MANIFESTS = ["", "[]", "{}", SIDECAR, '{"generator": "npm", "command": "generate", "sha256": {}}', "[" * 9999]


@pytest.mark.parametrize("name", ["core.json", MANIFEST])
@pytest.mark.parametrize("text", WRONG_MANIFESTS)
def test_a_foreign_directory_stays(tmp_path: Path, name: str, text: str) -> None:
    out = tmp_path / "out"
    out.mkdir()
    (out / "a thesis.tex").write_text("years of work")
    (out / name).write_text(text)
    line = f"it holds a thesis.tex, and no {MANIFEST} that says tfra wrote it"
    reason = refusal(out, lambda: generate(out))
    assert reason == f"is not replaced: {line}: move it away, or choose another place"


def change(out: Path, how: str) -> str:
    """Change an output, and return what is said of it."""
    foreign = "it holds {}, which tfra did not write".format
    match how:
        case "notes beside":
            (out / "notes.txt").touch()
            return foreign("notes.txt")
        case "notes below":
            (out / "images" / "notes.txt").touch()
            return foreign("images/notes.txt")
        case "a repository":
            (out / ".git").mkdir()
            return foreign(".git")
        case "another text":
            (out / "core.v").write_text("mine")
            return "core.v in it has changed since tfra wrote it"
        case "a link instead":
            (out / "core.v").rename(out.parent / "core.v")
            (out / "core.v").symlink_to("../core.v")
            return foreign("core.v")
        case "a directory instead":
            (out / "core.v").unlink()
            (out / "core.v").mkdir()
            return foreign("core.v")
        case "another manifest":
            (out / MANIFEST).write_text(SIDECAR)
            return f"it holds core.v, and no {MANIFEST} that says tfra wrote it"
        case "a manifest that reaches out":
            text = (out / MANIFEST).read_text().replace("core.v", "../core.v")
            (out / MANIFEST).write_text(text)
            return f"it holds core.v, and no {MANIFEST} that says tfra wrote it"
    raise LookupError(how)


CHANGES = [
    *("notes beside", "notes below", "a repository", "another text", "a link instead", "a directory instead"),
    *("another manifest", "a manifest that reaches out"),
]


@pytest.mark.parametrize("how", CHANGES)
def test_an_output_that_is_not_as_it_was_written_stays(tmp_path: Path, how: str) -> None:
    out = tmp_path / "out"
    generate(out, "old")
    line = f"is not replaced: {change(out, how)}: move it away, or choose another place"
    assert refusal(out, lambda: generate(out)) == line


@pytest.mark.parametrize("how", CHANGES)
def test_an_output_that_changes_meanwhile_stays(tmp_path: Path, how: str) -> None:
    out = tmp_path / "out"
    generate(out, "old")

    def run() -> None:
        with output_directory(out, "generate") as fresh:
            (fresh / "core.v").write_text("new")
            said.append(change(out, how))
            before.update(tree(out))

    said: list[str] = []
    before: dict[str, object] = {}
    with pytest.raises(InputError) as caught:
        run()
    assert said[0] in str(caught.value)
    assert tree(out) == before


def test_an_output_of_another_command_stays(tmp_path: Path) -> None:
    generate(tmp_path / "out", command="synth")
    line = "is not replaced: tfra synth wrote it, not tfra generate: move it away, or choose another place"
    assert refusal(tmp_path / "out", lambda: generate(tmp_path / "out")) == line


@pytest.mark.parametrize("where", ["current", "home", "input"])
@pytest.mark.parametrize("below", ["", "sub", "sub/sub"])
def test_places_that_are_needed_stay(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, where: str, below: str) -> None:
    out = tmp_path / "out"
    generate(out)
    inner = out / below
    inner.mkdir(parents=True, exist_ok=True)
    inputs = [tmp_path / "elsewhere.toml"]
    if where == "current":
        monkeypatch.chdir(inner)
    elif where == "home":
        monkeypatch.setenv("HOME", str(inner))
    else:
        inputs.append(inner / "sensor.toml")
        inputs[-1].touch()
    what = "the current directory" if where == "current" else "the home directory"
    what = f"{inputs[-1]}, which this command reads" if where == "input" else what
    relation = "holds" if below or where == "input" else "is"
    reason = refusal(out, lambda: generate(out, inputs=inputs))
    assert reason == f"is not replaced: it {relation} {what}: choose another place"


def test_unwritable_directory(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match=r"file: is not replaced: it is not a directory: move it away"):
        generate(tmp_path / "file")
    with pytest.raises(InputError, match=r"none/out: cannot be written: No such file or directory$"):
        generate(tmp_path / "none" / "out")


def test_a_failed_generation_keeps_the_old(tmp_path: Path) -> None:
    out = tmp_path / "out"
    generate(out, "old")

    def fail() -> None:
        with output_directory(out, "generate") as fresh:
            (fresh / "core.v").write_text("new")
            raise RuntimeError

    with pytest.raises(RuntimeError):
        fail()
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
