"""Output appears completely or not at all."""

import hashlib
import os
import zipfile
from collections.abc import Callable, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import BinaryIO

import numpy as np
import pytest

from tfra.runtime.errors import InputError
from tfra.runtime.outputs import check_file, output_directory, write_npz, write_text
from tfra.runtime.ownership import MANIFEST

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
        check_file(path, ".npz", "estimate")
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
        check_file(tmp_path / path, ".npz", "estimate")
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
    check_file(tmp_path / "out.npz", ".npz", "estimate")
    assert names(tmp_path) == []
    with pytest.raises(InputError, match=r"out\.csv: the name of the output must end in \.npz$"):
        check_file(tmp_path / "out.csv", ".npz", "estimate")


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
    assert refusal(path, lambda: check_file(path, ".npz", "estimate")) == line
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
    assert refusal(path, lambda: check_file(path, ".npz", "estimate", [tmp_path / "none", source])) == line


# One page, one CONFIG

PAGE = "<!DOCTYPE html>\n<title>μ</title>\n"

TEXTS = {".html": "<!-- {} -->\n", ".toml": "# {}\n"}
"""The comment of a text's seal, by the suffix."""


@pytest.mark.parametrize("suffix", TEXTS)
def test_a_text_ends_in_a_comment_with_its_seal(tmp_path: Path, suffix: str) -> None:
    for name in ("a", "b"):
        check_file(tmp_path / f"{name}{suffix}", suffix, "view")
        write_text(tmp_path / f"{name}{suffix}", PAGE, "view")
    text = (tmp_path / f"a{suffix}").read_text(encoding="utf-8")
    assert text.startswith(PAGE)
    digest = hashlib.sha256(PAGE.encode()).hexdigest()
    assert text.removeprefix(PAGE) == TEXTS[suffix].format(f"tfra {version('tfra')} view sha256:{digest}")
    assert (tmp_path / f"b{suffix}").read_text(encoding="utf-8") == text
    with pytest.raises(InputError, match=rf"out\.htm: the name of the output must end in \{suffix}$"):
        check_file(tmp_path / "out.htm", suffix, "view")


@pytest.mark.parametrize("suffix", TEXTS)
def test_a_text_is_replaced_by_its_own_command(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"out{suffix}"
    for text in (PAGE, PAGE * 2):
        write_text(path, text, "view")
        assert path.read_text(encoding="utf-8").startswith(text)
    line = "is not replaced: tfra view wrote it, not tfra paper: move it away, or choose another place"
    assert refusal(path, lambda: write_text(path, PAGE, "paper")) == line


@pytest.mark.parametrize("foreign", ["a text", "changed", "cut", "longer"])
@pytest.mark.parametrize("suffix", TEXTS)
def test_a_text_that_is_not_as_it_was_written_stays(tmp_path: Path, suffix: str, foreign: str) -> None:
    path = tmp_path / f"out{suffix}"
    write_text(path, PAGE, "view")
    data = path.read_bytes()
    path.write_bytes(
        {
            "a text": PAGE.encode(),
            "changed": data.replace(b"title", b"style"),
            "cut": data[:-2],
            "longer": data + TEXTS[suffix].format("notes").encode(),
        }[foreign]
    )
    reason = "it has changed since tfra wrote it" if foreign == "changed" else "tfra did not write it"
    line = f"is not replaced: {reason}: move it away, or choose another place"
    assert refusal(path, lambda: check_file(path, suffix, "view")) == line
    assert refusal(path, lambda: write_text(path, PAGE, "view")) == line


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
