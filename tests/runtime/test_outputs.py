"""Output appears completely or not at all, and what a command did not write stays."""

import hashlib
import json
import os
import zipfile
from collections.abc import Callable, Sequence
from importlib.metadata import version
from pathlib import Path
from tempfile import NamedTemporaryFile

import numpy as np
import pytest

from tfra.runtime.errors import InputError
from tfra.runtime.outputs import check_directory, check_file, output_directory, write_npz, write_text, write_vcd
from tfra.runtime.ownership import MANIFEST

SEALS = {".npz": "{}", ".html": "<!-- {} -->\n", ".toml": "# {}\n", ".vcd": "$comment {} $end\n"}
"""The comment with the seal at the end of a file, by its suffix."""

KINDS = ("", *SEALS)
"""Suffixes of outputs; that of a directory is empty."""

ADVICE = ": move it away, or choose another place"


def make(out: Path, text: str = "new", command: str = "generate", inputs: Sequence[Path] = ()) -> None:
    """Make the output of the kind that the suffix of ``out`` names."""
    if out.suffix == ".npz":
        write_npz(out, {"text": np.array(text.encode())}, command)
    elif out.suffix == ".vcd":
        with NamedTemporaryFile() as waves:
            Path(waves.name).write_text(text)
            write_vcd(out, Path(waves.name), command)
    elif out.suffix:
        write_text(out, text, command)
    else:
        with output_directory(out, command, inputs) as fresh:
            (fresh / "core.v").write_text(text)
            (fresh / "images").mkdir()
            (fresh / "images" / "a.hex").write_text(text)


def check(out: Path, command: str = "generate", inputs: Sequence[Path] = ()) -> None:
    if out.suffix:
        check_file(out, out.suffix, command, inputs)
    else:
        check_directory(out, command, inputs)


def tree(directory: Path) -> dict[str, object]:
    """Everything below ``directory``: a file's bytes, a link's target, None for a directory."""
    return {
        str(path): os.readlink(path) if path.is_symlink() else path.read_bytes() if path.is_file() else None
        for path in directory.rglob("*")
    }


def has(out: Path, text: str) -> bool:
    """Whether ``out`` is a whole output of ``text``, without anything beside it."""
    if not out.suffix:
        assert {name.removeprefix(f"{out}/") for name in tree(out)} == {"core.v", "images", "images/a.hex", MANIFEST}
    assert [path.name for path in out.parent.iterdir() if path.name.startswith(".")] == []
    return text.encode() in (out if out.suffix else out / "core.v").read_bytes()


def refusal(path: Path, run: Callable[[], object]) -> str:
    """Run what must be refused, see that nothing has changed beside ``path``, and return the reason."""
    before = tree(path.parent)
    with pytest.raises(InputError) as caught:
        run()
    assert tree(path.parent) == before
    return str(caught.value).removeprefix(f"{path}: ").removesuffix(ADVICE)


@pytest.mark.parametrize("suffix", KINDS)
@pytest.mark.parametrize("beginning", ["nothing", "empty", "link"])
def test_an_output_is_made_and_replaced_by_its_own_command(tmp_path: Path, suffix: str, beginning: str) -> None:
    out = tmp_path / f"out{suffix}"
    if beginning == "empty":
        (out.touch if suffix else out.mkdir)()
    elif beginning == "link":
        out.symlink_to(tmp_path / f"real{suffix}")
    for text in ("text 1", "text 2"):
        check(out)
        make(out, text)
        assert has(out, text)
    assert out.is_symlink() == (beginning == "link")
    assert (
        refusal(out, lambda: make(out, "text 3", "paper")) == "is not replaced: tfra generate wrote it, not tfra paper"
    )


@pytest.mark.parametrize("suffix", ["", ".npz"])
@pytest.mark.parametrize("interruption", [RuntimeError, KeyboardInterrupt])
def test_an_interrupted_write_leaves_the_old(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, suffix: str, interruption: type[BaseException]
) -> None:
    out = tmp_path / f"out{suffix}"
    make(out, "old")

    def fail(*_: object) -> None:
        raise interruption

    monkeypatch.setattr("tfra.runtime.outputs.seal_file" if suffix else "tfra.runtime.outputs.seal_directory", fail)
    with pytest.raises(interruption):
        make(out, "new")
    assert has(out, "old")


def test_a_written_file_has_the_usual_permissions(tmp_path: Path) -> None:
    (tmp_path / "plain").write_bytes(b"")
    make(tmp_path / "out.npz")
    assert (tmp_path / "out.npz").stat().st_mode == (tmp_path / "plain").stat().st_mode


@pytest.mark.parametrize(
    ("path", "reason"),
    [
        ("none/out.npz", "cannot be written: No such file or directory"),
        ("none/out", "cannot be written: No such file or directory"),
        ("file/out.npz", "cannot be written: Not a directory"),
        ("folder.npz", "is not replaced: it is not a regular file"),
        ("file", "is not replaced: it is not a directory"),
        ("x" * 252 + ".npz", "cannot be written: File name too long"),
        ("/dev/null", "is not replaced: it is not a directory"),
    ],
)
def test_what_cannot_be_written(tmp_path: Path, path: str, reason: str) -> None:
    (tmp_path / "file").write_bytes(b"")
    (tmp_path / "folder.npz").mkdir()
    for attempt in (check, make):
        with pytest.raises(InputError) as caught:
            attempt(tmp_path / path)
        assert (
            str(caught.value).removesuffix(": move it away, or choose another place") == f"{tmp_path / path}: {reason}"
        )
    assert sorted(os.listdir(tmp_path)) == ["file", "folder.npz"]


def test_the_longest_name_can_be_written(tmp_path: Path) -> None:
    make(tmp_path / ("x" * 251 + ".npz"))
    assert os.listdir(tmp_path) == ["x" * 251 + ".npz"]
    with pytest.raises(InputError, match=r"^/dev/null: is not replaced: it is not a regular file"):
        write_npz("/dev/null", {}, "generate")


@pytest.mark.parametrize("suffix", SEALS)
def test_a_file_ends_in_a_seal_that_readers_pass_over(tmp_path: Path, suffix: str) -> None:
    check(tmp_path / f"a{suffix}")
    assert os.listdir(tmp_path) == []
    for name in ("a", "b"):
        make(tmp_path / f"{name}{suffix}", "μ")
    data = (tmp_path / f"a{suffix}").read_bytes()
    assert (tmp_path / f"b{suffix}").read_bytes() == data
    before, _, _ = data.partition(SEALS[suffix].partition("{")[0].encode() + b"tfra ")
    content = before[:-2] if suffix == ".npz" else "μ".encode()
    seal = SEALS[suffix].format(f"tfra {version('tfra')} generate sha256:{hashlib.sha256(content).hexdigest()}")
    assert data == before + seal.encode()
    if suffix == ".npz":
        with zipfile.ZipFile(tmp_path / "a.npz") as archive:
            assert archive.testzip() is None
            assert {info.date_time for info in archive.infolist()} == {(1980, 1, 1, 0, 0, 0)}
    with pytest.raises(InputError, match=rf"out\.htm: the name of the output must end in \{suffix}$"):
        check_file(tmp_path / "out.htm", suffix, "view")


@pytest.mark.parametrize("foreign", ["not sealed", "changed", "changed in its seal", "cut", "longer"])
@pytest.mark.parametrize("suffix", SEALS)
def test_a_file_that_is_not_as_it_was_written_stays(tmp_path: Path, suffix: str, foreign: str) -> None:
    out = tmp_path / f"out{suffix}"
    make(out, "some text")
    data = out.read_bytes()
    digest = data.index(b"sha256:") + 7
    out.write_bytes(
        {
            "not sealed": data[: data.index(b"tfra ")],
            "changed": data.replace(b"some text", b"some test"),
            "changed in its seal": data[:digest] + (b"0" if data[digest] != b"0"[0] else b"1") + data[digest + 1 :],
            "cut": data[:-2],
            "longer": data + SEALS[suffix].format("notes").encode(),
        }[foreign]
    )
    reason = "it has changed since tfra wrote it" if foreign.startswith("changed") else "tfra did not write it"
    for attempt in (check, make):
        assert refusal(out, lambda attempt=attempt: attempt(out)) == f"is not replaced: {reason}"


@pytest.mark.parametrize("way", ["itself", "link", "hard link"])
def test_an_archive_that_is_read_stays(tmp_path: Path, way: str) -> None:
    out, read = tmp_path / "out.npz", tmp_path / "read.npz"
    make(out)
    if way == "link":
        read.symlink_to(out)
    elif way == "hard link":
        read.hardlink_to(out)
    line = "is not replaced: this command reads it: choose another place"
    source = out if way == "itself" else read
    assert refusal(out, lambda: check(out, inputs=[tmp_path / "none", source])) == line


# Directories


SIDECAR = '{"generator": "tfra 0.1.0"}'
WRONG_MANIFESTS = ["", "[]", "{}", SIDECAR, '{"generator": "npm", "command": "generate", "sha256": {}}', "[" * 9999]


@pytest.mark.parametrize("text", WRONG_MANIFESTS)
def test_a_foreign_directory_stays(tmp_path: Path, text: str) -> None:
    out = tmp_path / "out"
    out.mkdir()
    (out / "a thesis.tex").write_text("years of work")
    (out / MANIFEST).write_text(text)
    line = f"is not replaced: it holds a thesis.tex, and no {MANIFEST} that says tfra wrote it"
    assert refusal(out, lambda: make(out)) == line


FOREIGN, NO_MANIFEST = "it holds {}, which tfra did not write", f"it holds core.v, and no {MANIFEST} that says"

CHANGES: dict[str, tuple[Callable[[Path], object], str]] = {
    "notes beside": (lambda out: (out / "notes.txt").touch(), FOREIGN.format("notes.txt")),
    "notes below": (lambda out: (out / "images" / "notes.txt").touch(), FOREIGN.format("images/notes.txt")),
    "a repository": (lambda out: (out / ".git").mkdir(), FOREIGN.format(".git")),
    "another text": (lambda out: (out / "core.v").write_text("mine"), "core.v in it has changed since tfra wrote it"),
    "a link": (
        lambda out: (out / "core.v").rename(out / "a") and (out / "core.v").symlink_to("a"),
        FOREIGN.format("a"),
    ),
    "a directory": (lambda out: (out / "core.v").unlink() or (out / "core.v").mkdir(), FOREIGN.format("core.v")),
    "another manifest": (lambda out: (out / MANIFEST).write_text(SIDECAR), NO_MANIFEST),
    "a manifest that reaches out": (
        lambda out: (out / MANIFEST).write_text((out / MANIFEST).read_text().replace("core.v", "../core.v")),
        NO_MANIFEST,
    ),
}


@pytest.mark.parametrize("meanwhile", [False, True])
@pytest.mark.parametrize(("change", "reason"), CHANGES.values(), ids=CHANGES)
def test_an_output_that_is_not_as_it_was_written_stays(
    tmp_path: Path, change: Callable[[Path], object], reason: str, meanwhile: bool
) -> None:
    out = tmp_path / "out"
    make(out, "old")
    before: dict[str, object] = {}

    def run() -> None:
        with output_directory(out, "generate") as fresh:
            (fresh / "core.v").write_text("new")
            change(out)
            before.update(tree(tmp_path / "out"))

    if meanwhile:
        with pytest.raises(InputError) as caught:
            run()
        assert reason in str(caught.value)
        assert tree(tmp_path) == before | {str(out): None}
    else:
        change(out)
        assert refusal(out, lambda: make(out)).startswith(f"is not replaced: {reason}")


def test_a_directory_with_files_missing_is_replaced(tmp_path: Path) -> None:
    make(tmp_path / "out", "old")
    (tmp_path / "out" / "core.v").unlink()
    make(tmp_path / "out")
    assert has(tmp_path / "out", "new")


def test_a_name_that_no_file_can_have_is_a_file_that_is_missing(tmp_path: Path) -> None:
    make(tmp_path / "out", "old")
    manifest = tmp_path / "out" / MANIFEST
    content = json.loads(manifest.read_text())
    content["sha256"]["x" * 300] = content["sha256"]["a\0"] = "00"
    manifest.write_text(json.dumps(content))
    make(tmp_path / "out")
    assert has(tmp_path / "out", "new")


@pytest.mark.parametrize("where", ["current", "home", "input"])
@pytest.mark.parametrize("below", ["", "sub", "sub/sub"])
def test_places_that_are_needed_stay(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, where: str, below: str) -> None:
    out = tmp_path / "out"
    make(out)
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
    what = f"{inputs[-1]}, which this command reads" if where == "input" else f"the {where} directory"
    relation = "holds" if below or where == "input" else "is"
    reason = refusal(out, lambda: make(out, inputs=inputs))
    assert reason == f"is not replaced: it {relation} {what}: choose another place"
